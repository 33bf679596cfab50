"""Ground truth: the objects and boundaries that contours are compared with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.contours.contour import Contour, Contours, sample_contours
from cpm_core.contours.graph import Graph
from cpm_core.contours.rasterize import rasterize_labels, rasterize_mask
from cpm_core.contours.surface import surface_from_labels
from cpm_core.image import drawing
from cpm_core.image.surface import Surface
from cpm_core.numerics.grids import rank_values
from cpm_core.numerics.real_numbers import as_real_array, check_voxel_sides
from cpm_core.numerics.types import Array, Extent, Sides, Texts, record
from cpm_core.parameters.formatting import format_count, format_repr, format_size

Labels = NDArray[np.int32]

MAX_LABEL = int(np.iinfo(np.int32).max)
"""Largest number of a label that is read, kept and written."""

_MAX_CHANGING_NEIGHBORS = 0.5
"""Largest fraction of neighboring pixels that may differ in a mask; in a noisy image nearly all do."""

_BLACK_WHITE_TOLERANCE = 0.125
"""Largest distance from black or white, as a fraction of the range, in a mask from a lossy format."""


class _LabeledTruth:
    """Properties of an image or a volume that follow from its labels."""

    labels: Labels

    @property
    def shape(self) -> Extent:
        """Shape of the image or volume."""
        return self.labels.shape

    @cached_property
    def objects(self) -> Labels:
        """Labels of the objects, in the shape of `labels`; the objects of a single class are its connected parts."""
        if self.labels.max(initial=0) > 1:
            return self.labels
        return np.asarray(scipy.ndimage.label(self.labels)[0], np.int32)


@record
class Truth(_LabeledTruth, drawing.Pictured):
    """The true objects and boundaries of an image.

    Attributes
    ----------
    labels : ndarray of int32, shape (H, W)
        Object of each pixel: 0 for the background, 1, 2, ... for the objects in the order of their gray levels. A mask
        of two gray levels has a single class.
    contours : tuple of Contour
        Boundaries of the objects [px]: between the pixels of a mask, or the contours of a file.
    source : str
        Name of the file for the user.
    notes : tuple of str
        What was left out or assumed when the file was read, one sentence each.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("disks"), cpm.uniform_grid((64, 64)))
    >>> truth = cpm.Truth(result.labels, result.contours, "drawn")
    >>> truth
    <Truth drawn, 64 x 64 px, 2 contours>
    >>> truth.shape, int(truth.objects.max()), truth.boundary.shape[1]
    ((64, 64), 2, 2)
    >>> axes = truth.plot()
    """

    labels: Labels
    contours: tuple[Contour, ...]
    source: str = "ground truth"
    notes: Texts = ()

    @cached_property
    def boundary(self) -> Array:
        """Points every quarter of a pixel along the boundaries, shape (K, 2) [px]."""
        return sample_contours(self.contours)

    def __repr__(self) -> str:
        return format_repr("Truth", self.source, format_size(self.shape), format_count(len(self.contours), "contour"))

    def plot(self, ax: drawing.Axes | None = None) -> drawing.Axes:
        """Draw the pixels of the objects and their boundaries by matplotlib."""
        return drawing.draw_curves_on_image(ax, (self.labels > 0).astype(float), self.contours)


def truth_from_contours(
    contours: Contours, shape: Sequence[int], source: str = "ground truth", *, holes: bool = True
) -> Truth:
    """Build a ground truth from contours: closed ones are objects, labeled as in the label mask except for holes.

    Parameters
    ----------
    contours : sequence of Contour
        Boundaries [px].
    shape : sequence of int
        Shape of the image, (rows, columns).
    source : str
        Name for the user.
    holes : bool
        Whether a contour in another is a hole, and one in a hole another object; see `rasterize_mask`.
    """
    size = (int(shape[0]), int(shape[1]))
    labels = np.where(rasterize_mask(contours, size, holes=holes), rasterize_labels(contours, size), 0)
    return Truth(labels.astype(np.int32), tuple(contours), source)


def truth_from_mask(values: NDArray[np.generic], source: str = "ground truth") -> Truth:
    """Build a ground truth from a mask.

    Parameters
    ----------
    values : ndarray of real numbers or bool, shape (H, W)
        Gray levels: the lowest is the background, each other an object.
    source : str
        Name for the user.

    Returns
    -------
    Truth
        Boundaries run through the centers of the sides between pixels of different objects and meet where three
        objects do; the image border is no boundary.

    Raises
    ------
    ValueError
        When all pixels are equal, or too many neighbors differ for a mask.
    """
    labels = label_gray_levels(values, source)
    return Truth(labels, _trace_label_boundaries(labels), source)


_MAX_LOSSY_RANGE = 2**16
"""Range of gray levels below which many of them may be black and white from a lossy format."""

_ROUNDING_NOISE = 1e-3
"""Distance from a whole number up to which gray levels are that label, even several of them."""

_MAX_ROUNDING = 0.1
"""Largest distance from whole numbers of labels, which a file may store with a slope."""


def label_gray_levels(values: NDArray[np.generic], source: str) -> Labels:
    """Label the gray levels of a mask by numbers from 0.

    Parameters
    ----------
    values : ndarray of real numbers, shape (H, W) or (P, R, C)
        Gray levels.
    source : str
        Name for messages.

    Returns
    -------
    ndarray of int32, shape of `values`
        Index of each gray level among the sorted ones.

    Raises
    ------
    ValueError
        When all pixels are equal, too many neighbors differ for a mask, or labels are negative.
    """
    return _find_levels(values, source)[2]


def number_gray_levels(values: NDArray[np.generic], source: str) -> tuple[Labels, bool]:
    """Return the gray levels of a mask as labels where they are whole, else those of `label_gray_levels`.

    Returns
    -------
    labels : ndarray of int32, shape of `values`
        Number of each gray level, 0 for the lowest.
    whole : bool
        Whether they are the numbers in the file, to which its names belong.
    """
    levels, ranks, labels = _find_levels(values, source)
    if (levels % 1.0).any():
        return labels, False
    if levels[-1] > MAX_LABEL:
        raise ValueError(
            f"{source} has the label {levels[-1]:.0f}, but the largest that is read is {MAX_LABEL}: renumber them."
        )
    return np.r_[0, levels[1:]].astype(np.int32)[ranks], True


def _find_levels(values: NDArray[np.generic], source: str) -> tuple[Array, Labels, Labels]:
    """Find the gray levels of a mask, sorted, the index of each among them, and its label by `label_gray_levels`."""
    levels, ranks = _round_levels(*rank_values(values))
    if len(levels) < 2:
        raise ValueError(f"{source} has one gray level everywhere, so it shows no object: choose another mask.")
    labels, span = ranks, (levels - levels[0]) / (levels[-1] - levels[0])
    lossy = len(levels) > 8 and levels[-1] - levels[0] < _MAX_LOSSY_RANGE
    if lossy := lossy and np.minimum(span, 1.0 - span).max() < _BLACK_WHITE_TOLERANCE:
        labels = (span > 0.5).astype(np.int32)[ranks]
    changes = np.mean(
        [(np.diff(labels, axis=axis) != 0).mean() for axis in range(labels.ndim) if labels.shape[axis] > 1]
    )
    if len(levels) > 2 and changes > _MAX_CHANGING_NEIGHBORS:
        raise ValueError(
            f"{source} has {len(levels)} gray levels that change from pixel to pixel, so it is an image, not a mask: "
            "choose an image with one gray level for the background and one for each object."
        )
    if levels[1] <= 0.0 and not lossy and not (levels % 1.0).any():
        raise ValueError(
            f"{source} has the label {levels[0]:.0f}, and none may be below 0: replace it, by 0 where it is background."
        )
    return levels, ranks, labels


def _round_levels(levels: NDArray[np.generic], ranks: Labels) -> tuple[Array, Labels]:
    """Round gray levels that a slope in the file has moved off whole numbers, and leave all others as they are."""
    exact = levels.astype(float)
    whole = np.rint(exact)
    off, merged = float(np.abs(exact - whole).max()), bool((np.diff(whole) == 0.0).any())
    if whole[0] == whole[-1] or off > (_ROUNDING_NOISE if merged else _MAX_ROUNDING):
        return exact, ranks
    kept, again = np.unique(whole, return_inverse=True)
    return kept, again.astype(np.int32)[ranks]


def _trace_label_boundaries(labels: Labels) -> tuple[Contour, ...]:
    """Trace the boundaries between pixels of different labels.

    Around each corner of four pixels up to four sides separate labels. Two of them are joined; three or four meet at
    the corner.
    """
    vertical, horizontal = labels[:, :-1] != labels[:, 1:], labels[:-1] != labels[1:]
    around = np.stack([vertical[:-1], vertical[1:], horizontal[:, :-1], horizontal[:, 1:]], axis=-1)
    row, col = np.nonzero(around.sum(axis=-1, dtype=np.uint8) > 1)
    separating = around[row, col]
    # numbers of places on a grid of half pixels: the corner, and the centers of the sides around it
    width = 2 * labels.shape[1] - 1
    corner = ((2 * row + 1) * width + 2 * col + 1)[:, None]
    sides = corner + np.array([-width, width, -1, 1])
    two = separating.sum(axis=1) == 2
    pairs = sides[two][separating[two]].reshape(-1, 2)
    rays = np.stack(np.broadcast_arrays(sides, corner), axis=-1)[separating & ~two[:, None]]
    used, edges = np.unique(np.concatenate([pairs, rays]), return_inverse=True)
    return Graph(
        0.5 * np.stack(np.divmod(used, width), axis=1), edges.reshape(-1, 2).astype(np.int64)
    ).extract_contours()


@record
class VolumeTruth(_LabeledTruth):
    """The true objects of a volume.

    Attributes
    ----------
    labels : ndarray of int32, shape (P, R, C)
        Object of each voxel: 0 for the background, and 1, 2, ... for objects. With 1 alone the connected parts are the
        objects.
    spacing : tuple of float
        Size of a voxel along (plane, row, col), in `unit`.
    unit : str or None
        Unit of `spacing`; None when it is not known.
    source : str
        Name of the file for the user.
    boundary : Surface or None
        Boundaries of the objects, where they are known more precisely than halfway between voxels.
    notes : tuple of str
        As for `Truth`.

    Raises
    ------
    ValueError
        When the labels are not whole numbers of at least 0 in three axes.

    Examples
    --------
    >>> volume = cpm.example("ball")
    >>> truth = cpm.VolumeTruth(volume.values > volume.values.mean())
    >>> truth
    <VolumeTruth ground truth, 31 x 31 x 31 voxels, 1 object>
    >>> truth.shape, int(truth.objects.max()), truth.surface.closed
    ((31, 31, 31), 1, True)
    """

    labels: Labels
    spacing: Sides = (1.0, 1.0, 1.0)
    unit: str | None = None
    source: str = "ground truth"
    boundary: Surface | None = None
    notes: Texts = ()

    def __post_init__(self) -> None:
        given = as_real_array(self.labels)
        if given.ndim != 3 or given.size == 0 or given.min() < 0 or given.max() > MAX_LABEL or (given % 1.0).any():
            raise ValueError(
                "the labels of a volume must be whole numbers of at least 0 with three axes, but those of "
                f"{self.source} have the shape {given.shape} and lie between {given.min(initial=0):g} and "
                f"{given.max(initial=0):g}."
            )
        object.__setattr__(self, "labels", given.astype(np.int32))
        object.__setattr__(self, "spacing", tuple(check_voxel_sides("The spacing of labels", self.spacing).tolist()))

    @cached_property
    def surface(self) -> Surface:
        """The boundaries of the objects, halfway between voxels unless known; the border of the volume is none."""
        if self.boundary is not None:
            return replace(self.boundary, spacing=self.spacing, unit=self.unit)
        found = surface_from_labels(self.labels, self.spacing, self.unit, open_border=True)
        return replace(found, numbers=None)

    def __repr__(self) -> str:
        objects = len(np.unique(self.objects[self.objects > 0]))
        return format_repr(
            "VolumeTruth", self.source, format_size(self.shape, "voxels"), format_count(objects, "object")
        )
