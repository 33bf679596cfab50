"""Selection: the object that a prompt selects."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import NamedTuple, TypeVar

import numpy as np

from cpm_core.contours.contour import Contour
from cpm_core.image import drawing
from cpm_core.image.image import Image
from cpm_core.image.region import Region
from cpm_core.image.surface import Surface
from cpm_core.numerics.types import Array, Arrays, Extent, Index, Mask, record
from cpm_core.objects.confidence import ConfidenceFeatures, whole_percent
from cpm_core.objects.prior.body_prediction import BodyPrediction
from cpm_core.parameters.formatting import format_count, format_repr


@record
class Selection(drawing.Pictured):
    """An object of an image or a volume that a prompt selects.

    Attributes
    ----------
    region : Region
        Its pixels; in a volume its voxels within its surface, which is not known once the object has been painted.
    shape : tuple of int
        Shape of the image.
    inside, outside : ndarray, shape (M, D) and (K, D)
        The positive and negative points of the prompt [px].
    contours : tuple of Contour
        Its closed boundary in an image: outlines of its parts and of its holes.
    gaps : tuple of ndarray, shape (K, 2)
        Stretches of the boundary that follow no contour [px].
    confidence : float
        Probability, 0 to 1, that its overlap with the intended object is at least `confidence.CORRECT_IOU`; NaN where
        that is not known, as of a body that points select.
    remark : str
        One sentence on what was unusual about the points, or on an answer of almost no confidence; else empty.
    features : ConfidenceFeatures or None
        Features that the confidence was estimated from.
    prediction : BodyPrediction or None
        In a volume, what the network predicted, for further points to correct.
    image : Image or None
        The image that it was selected in; None where that is not known.
    model : str
        The larger model that answered; empty for the network and for contours.

    Examples
    --------
    >>> chosen = cpm.partition(cpm.example("disks")).select([(32, 18)])
    >>> chosen.mask.shape, chosen.contours[0].closed, len(chosen.gaps), chosen.has_only_points
    ((64, 64), True, 0, False)
    >>> chosen.has_boundary, chosen.has_same_region(chosen), chosen.size
    (True, True, 301.0)
    >>> chosen.contains(np.array([(32.0, 18.0), (32.0, 46.0)])).tolist()
    [True, False]
    >>> axes = chosen.plot()
    >>> body = cpm.partition(cpm.example("ball")).select([(15, 15, 15)])
    >>> body, body.mask.shape, body.surface.closed
    (<Selection ball, 1 part>, (31, 31, 31), True)
    """

    region: Region
    shape: Extent
    inside: Array
    outside: Array
    contours: tuple[Contour, ...] = ()
    gaps: Arrays = ()
    confidence: float = np.nan
    remark: str = ""
    features: ConfidenceFeatures | None = None
    prediction: BodyPrediction | None = None
    image: Image | None = None
    model: str = ""

    @property
    def mask(self) -> Mask:
        """Pixels whose centers lie in the object, an array in the shape of the image."""
        return self.region.paste(self.shape)

    @cached_property
    def surface(self) -> Surface | None:
        """Its surface in a volume, with the size of a voxel; None in an image, and where nothing is selected."""
        if self.region.ndim == 2 or self.region.is_empty:
            return None
        surface, image = self.region.find_surface(), self.image
        if image is None or (surface.spacing, surface.unit) == (image.spacing, image.unit):
            return surface
        return replace(surface, spacing=image.spacing, unit=image.unit)

    @property
    def has_boundary(self) -> bool:
        """Whether it has a boundary."""
        return not self.region.is_empty

    @property
    def size(self) -> float:
        """Area [px²], or volume within its surface, in the unit of the image, cubed."""
        if len(self.shape) == 2:
            return self.region.size
        return self.surface.volume if self.surface is not None else 0.0

    def has_same_region(self, other: Selection) -> bool:
        """Return whether another selection has the same pixels, in a volume within the same surface."""
        return self.region == other.region

    @property
    def has_only_points(self) -> bool:
        """Whether it holds only the pixels of the positive points: no object was found around them."""
        return len(self.shape) == 2 and 0 < self.region.size <= len(self.inside)

    def contains(self, places: Array) -> Mask:
        """Return which points, shape (N, D) [px], lie in it, shape (N,); one outside is moved to the nearest pixel."""
        return self.region.encloses(np.rint(np.clip(places, 0, np.array(self.shape) - 1)))

    def __repr__(self) -> str:
        if len(self.shape) == 3:
            parts = 0 if self.surface is None else self.surface.components
            source = "" if self.image is None else self.image.source
            return format_repr("Selection", source, format_count(parts, "part"))
        pixels, contours = f"{self.region.size:,.0f} px", format_count(len(self.contours), "contour")
        gaps, sure = format_count(len(self.gaps), "gap"), f"{whole_percent(self.confidence):.0f} % sure"
        return format_repr("Selection", pixels, contours, gaps, sure)

    def plot(self, ax: drawing.Axes | None = None) -> drawing.Axes:
        """Draw the pixels of the object and its boundaries by matplotlib, or its surface."""
        if self.surface is not None:
            return self.surface.plot(ax)
        return drawing.draw_curves_on_image(ax, self.mask.astype(float), self.contours)


class Candidate(NamedTuple):
    """A region that may be an object.

    Attributes
    ----------
    region : Region
        Its pixels.
    features : ConfidenceFeatures or None
        What its confidence is estimated from, as far as it is known.
    bounded : bool
        Whether contours bound it: alone, where several meet, or with gaps.
    unambiguous : bool
        Whether an unambiguous contour encloses it.
    likelihood : float
        Overlap with an object that the network predicts, times the one expected from its probabilities; 0 if it has not
        found it.
    strength : float
        Mean edge strength along its boundary, in differences between white and black [1 / px].
    confidence : float
        Probability that it is an object.
    model : str
        The larger model that found it; empty if none did.
    """

    region: Region
    features: ConfidenceFeatures | None = None
    bounded: bool = False
    unambiguous: bool = False
    likelihood: float = 0.0
    strength: float = 0.0
    confidence: float = 0.0
    model: str = ""


EXCLUDED_POINT_REMARK = "A point in another object is ignored."
"""Remark on a selection by points some of which are on excluded pixels."""

CONFLICTING_POINT_REMARK = "The same point is marked as inside and as outside; the last mark counts."
"""Remark on a selection by points that contradict each other."""


UNLIKELY_REMARK = "There may be no object here: the confidence is almost zero."
"""Remark on a selection of almost no confidence, as in the background."""

LEAST_CONFIDENCE = 0.05
"""Confidence below which a selection has this remark: of twenty such answers not one is an object."""

_Points = TypeVar("_Points", Array, Index)


def remark_on_doubt(selection: Selection) -> Selection:
    """Return a selection with a remark if hardly anything says that it is an object, and nothing else is remarked."""
    doubted = not selection.remark and selection.confidence < LEAST_CONFIDENCE  # which is not said of an unknown one
    return replace(selection, remark=UNLIKELY_REMARK) if doubted else selection


def keep_last_marks(inside: _Points, outside: _Points, newer: Mask) -> tuple[_Points, _Points, bool]:
    """Keep the last mark of each pixel or voxel, and return whether any has two.

    `inside` and `outside` are points, shape (M, D) and (K, D); where they are in the same place, the positive ones
    count that are `newer`, shape (M,).
    """
    same = (np.rint(inside)[:, None] == np.rint(outside)).all(axis=2)
    return inside[newer | ~same.any(axis=1)], outside[~(same & newer[:, None]).any(axis=0)], bool(same.any())


def find_newer_points(inside: Array, outside: Array, previous: Selection | None) -> Mask:
    """Find the positive points, shape (M, D), that are newer than negative ones, shape (K, D), in the same place.

    They are those that the previous selection lacks, and those that it holds, unless a later negative point takes them
    away: of two marks that are both older than it, it tells by what it holds which was the last.
    """
    if previous is None:
        return np.zeros(len(inside), np.bool_)
    later = np.rint(outside[len(previous.outside) :])
    held = previous.contains(inside) & ~is_among(np.rint(inside), later)
    return held | ~is_among(inside, previous.inside)


def is_among(places: Array | Index, others: Array | Index) -> Mask:
    """Return which points, shape (N, D), are among others, shape (N,)."""
    return (places[:, None] == others[None]).all(axis=2).any(axis=1)
