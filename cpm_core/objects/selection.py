"""Selection: the object that a prompt selects."""

from __future__ import annotations

from typing import TypeVar

import numpy as np

from cpm_core.contours.contour import Contour
from cpm_core.image import drawing
from cpm_core.image.image import Image
from cpm_core.numerics.types import Array, Arrays, Index, Mask, record
from cpm_core.objects.confidence import ConfidenceFeatures
from cpm_core.parameters.formatting import format_count, format_repr


@record
class Selection(drawing.Pictured):
    """An object: a set of pixels with its closed boundary.

    Attributes
    ----------
    mask : ndarray of bool, shape (H, W)
        Pixels whose centers lie in the object.
    contours : tuple of Contour
        Its closed boundary: outlines of its parts and of its holes.
    gaps : tuple of ndarray, shape (K, 2)
        Stretches of the boundary that follow no contour [px].
    confidence : float
        Probability, 0 to 1, that its overlap with the intended object is at least `confidence.CORRECT_IOU`.
    inside, outside : ndarray, shape (M, 2) and (K, 2)
        The positive and negative points of the prompt [px].
    remark : str
        One sentence on what was unusual about the points, or on an answer of almost no confidence; else empty.
    features : ConfidenceFeatures or None
        Features that the confidence was estimated from.
    image : Image or None
        The image that it was selected in; None where that is not known.

    Examples
    --------
    >>> chosen = cpm.partition(cpm.example("disks")).select([(32, 18)])
    >>> chosen.mask.shape, chosen.contours[0].closed, len(chosen.gaps), chosen.has_only_points
    ((64, 64), True, 0, False)
    >>> chosen.has_boundary, chosen.has_same_region(chosen)
    (True, True)
    >>> chosen.contains(np.array([(32.0, 18.0), (32.0, 46.0)])).tolist()
    [True, False]
    >>> axes = chosen.plot()
    """

    mask: Mask
    contours: tuple[Contour, ...]
    gaps: Arrays
    confidence: float
    inside: Array
    outside: Array
    remark: str = ""
    features: ConfidenceFeatures | None = None
    image: Image | None = None

    @property
    def has_boundary(self) -> bool:
        """Whether it has a boundary."""
        return bool(self.contours)

    def has_same_region(self, other: Selection) -> bool:
        """Return whether another selection has the same pixels."""
        return np.array_equal(self.mask, other.mask)

    @property
    def has_only_points(self) -> bool:
        """Whether it holds only the pixels of the positive points: no object was found around them."""
        return bool(0 < np.count_nonzero(self.mask) <= len(self.inside))

    def contains(self, places: Array) -> Mask:
        """Return which points, shape (N, 2) [px], lie in it, shape (N,); one outside is moved to the nearest pixel."""
        pixel = np.rint(np.clip(places, 0, np.array(self.mask.shape) - 1)).astype(int)
        return self.mask[tuple(pixel.T)]

    def __repr__(self) -> str:
        pixels, contours = f"{np.count_nonzero(self.mask):,} px", format_count(len(self.contours), "contour")
        return format_repr(
            "Selection", pixels, contours, format_count(len(self.gaps), "gap"), f"{100.0 * self.confidence:.0f} % sure"
        )

    def plot(self, ax: drawing.Axes | None = None) -> drawing.Axes:
        """Draw the pixels of the object and its boundaries by matplotlib."""
        return drawing.draw_curves_on_image(ax, self.mask.astype(float), self.contours)


EXCLUDED_POINT_REMARK = "A point in another object is ignored."
"""Remark on a selection by points some of which are on excluded pixels."""

CONFLICTING_POINT_REMARK = "The same point is marked as inside and as outside; the last mark counts."
"""Remark on a selection by points that contradict each other."""


_Points = TypeVar("_Points", Array, Index)


def keep_last_marks(inside: _Points, outside: _Points, newer: Mask) -> tuple[_Points, _Points, bool]:
    """Keep the last mark of each pixel or voxel, and return whether any has two.

    `inside` and `outside` are points, shape (M, D) and (K, D); where they are in the same place, the positive ones
    count that are `newer`, shape (M,).
    """
    same = (np.rint(inside)[:, None] == np.rint(outside)).all(axis=2)
    return inside[newer | ~same.any(axis=1)], outside[~(same & newer[:, None]).any(axis=0)], bool(same.any())


def compute_iou(one: Mask, other: Mask) -> float:
    """Compute the intersection over union of two masks of one shape; 0 when both are empty."""
    whole = np.count_nonzero(one | other)
    return np.count_nonzero(one & other) / whole if whole else 0.0
