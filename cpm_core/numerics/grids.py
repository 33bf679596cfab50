"""Grids of values: local maxima and means, processing by windows and bands, and connected parts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import product
from typing import Any, TypeVar

import numpy as np
import scipy
import skimage
from numpy.typing import ArrayLike, NDArray

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import run_in_parallel
from cpm_core.numerics.types import Array, Extent, Index, Mask, Single, record

Labels = NDArray[np.int32]
"""Numbers of parts or columns, in 32 bits."""

Values = TypeVar("Values", Array, Single, Mask, NDArray[np.uint8])
Filling = TypeVar("Filling", Single, Labels)
_Kind = TypeVar("_Kind", bound=np.integer)

Window = tuple[slice, ...]
"""Pixels of a grid, a range along each axis."""


def whole_window(shape: Extent) -> Window:
    """All pixels of a grid of this shape."""
    return tuple(slice(0, n) for n in shape)


def expand_window(window: Window, margin: int, shape: Extent) -> Window:
    """Return a window with a margin of pixels around it, cut off at the border of a grid of this shape."""
    return tuple(
        slice(max(side.start - margin, 0), min(side.stop + margin, n)) for side, n in zip(window, shape, strict=True)
    )


def running_maximum(values: Values, reach: ArrayLike) -> Values:
    """Return the maximum over a box around every pixel, cut off at the border; of a mask, whether any pixel is true.

    The box reaches `reach` pixels to both sides, the same or another number along each axis. The result has the shape
    of `values`. Whole arrays are compared with shifted copies, one axis after the other: for small boxes this is
    several times faster than a filter that visits every pixel.
    """
    for axis, reached in enumerate(np.broadcast_to(reach, values.ndim).tolist()):
        before = values
        values = before.copy()
        for shift in range(1, min(reached, values.shape[axis] - 1) + 1):
            ahead = (slice(None),) * axis + (slice(shift, None),)
            behind = (slice(None),) * axis + (slice(None, -shift),)
            np.maximum(values[ahead], before[behind], out=values[ahead])
            np.maximum(values[behind], before[ahead], out=values[behind])
    return values


def relative_window(window: Window, outer: Window) -> Window:
    """Return a window in the pixel coordinates of an outer window that contains it."""
    return tuple(slice(a.start - b.start, a.stop - b.start) for a, b in zip(window, outer, strict=True))


def enclose_windows(one: Window, other: Window) -> Window:
    """Return the smallest window around two windows."""
    return tuple(slice(min(a.start, b.start), max(a.stop, b.stop)) for a, b in zip(one, other, strict=True))


def first_pixel(window: Window) -> Index:
    """Return the first pixel of a window."""
    return np.array([side.start for side in window], np.int64)


def window_at(corner: Iterable[int], shape: Extent) -> Window:
    """Return the window of this shape that begins at a pixel."""
    return tuple(slice(at, at + side) for at, side in zip(corner, shape, strict=True))


def window_around(pixel: Index, reach: int) -> Window:
    """Return the window within so many pixels of a pixel along each axis, cut off at the first ones."""
    return tuple(slice(max(at - reach, 0), at + reach + 1) for at in pixel.tolist())


def lie_inside(pixels: NDArray[Any], shape: Extent | int) -> Mask:
    """Tell which pixels, shape (N, D), lie in a grid of this shape, shape (N,)."""
    return np.asarray(((pixels >= 0) & (pixels < shape)).all(axis=1))


def grid_points(axes: Sequence[ArrayLike]) -> NDArray[Any]:
    """Return all points of a grid with these coordinates along its axes, shape (N, D)."""
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))


def split_into_tiles(shape: Extent, side: int) -> list[Window]:
    """Split a grid of this shape into windows of this side, smaller at the end of an axis."""
    axes = ([slice(at, min(at + side, n)) for at in range(0, n, side)] for n in shape)
    return list(product(*axes))


def window_shape(window: Window) -> tuple[int, ...]:
    """Return lengths of the sides of a window."""
    return tuple(side.stop - side.start for side in window)


@record
class ConnectedParts:
    """Connected parts of a mask of three axes.

    `labels` has the number of the part of each voxel plus one, and 0 where the mask is False.
    """

    labels: Labels
    count: int

    def fill_voxels(self, values: Filling, out: Filling) -> Filling:
        """Write a value for each part into its voxels."""
        inside = self.labels > 0
        out[inside] = values[self.labels[inside] - 1]
        return out

    @property
    def sizes(self) -> Index:
        """Number of voxels of each part."""
        return np.bincount(self.labels[self.labels > 0] - 1, minlength=self.count).astype(np.int64)

    @property
    def at_border(self) -> Mask:
        """Which parts touch the border of the mask."""
        found = np.zeros(self.count + 1, np.bool_)
        for axis in range(3):
            found[self.labels.take([0, -1], axis)] = True
        return found[1:]

    def part_at(self, voxels: Index) -> Index:
        """Return the part of each voxel, shape (N, 3), as shape (N,); -1 where the mask is False."""
        return self.labels[tuple(voxels.T)].astype(np.int64) - 1


_MAX_COUNTED_RANGE = 2**16
"""Largest range of whole numbers that are counted rather than sorted."""


def rank_values(values: NDArray[Any]) -> tuple[NDArray[Any], Labels]:
    """Return the different values of an array, sorted, and the index of each value among them, in its shape.

    Sorting each voxel of a volume takes long: runs of equal values are one, and whole numbers are counted.
    """
    flat = values.ravel()
    begin = np.flatnonzero(np.r_[True, flat[1:] != flat[:-1]])
    runs = flat[begin]
    low = float(runs.min())
    if float(runs.max()) - low <= _MAX_COUNTED_RANGE and not (runs % 1).any():
        shifted = np.subtract(runs, low).astype(np.int32)
        there = np.bincount(shifted) > 0
        levels, index = (low + np.flatnonzero(there)).astype(values.dtype), (np.cumsum(there) - 1)[shifted]
    else:
        levels, index = np.unique(runs, return_inverse=True)
    ranks = np.repeat(index.astype(np.int32), np.diff(begin, append=flat.size))
    return levels, ranks.reshape(values.shape)


def find_label_boxes(labels: NDArray[np.integer]) -> list[tuple[int, Window]]:
    """Find the window of each label above 0, in order; labels may be as large as those of brain atlases."""
    numbers, ranks = rank_values(labels)
    boxes = scipy.ndimage.find_objects(ranks + 1)
    return [(number, box) for number, box in zip(numbers.tolist(), boxes, strict=True) if number > 0]


def find_connected_parts(mask: Mask, *, corners: bool) -> ConnectedParts:
    """Find the connected parts of a mask, shape (P, R, C); with `corners` voxels have 26 neighbors, else 6."""
    return ConnectedParts(*label_parts(mask, corners=corners))


def label_parts(mask: Mask, *, corners: bool = True) -> tuple[Labels, int]:
    """Label the connected parts of a mask from 1, and return their number, too; pixels connect at `corners` or not."""
    labels, count = scipy.ndimage.label(mask, np.ones((3,) * mask.ndim) if corners else None)
    return np.asarray(labels, np.int32), int(count)


def measure_depth(mask: Mask, sides: Array | None = None) -> Array:
    """Measure how far each pixel of a mask is from the outside, which begins beyond the border of the grid.

    The unit is that of the sides of a pixel, shape (D,), by default [px].
    """
    depth: Array = scipy.ndimage.distance_transform_edt(np.pad(mask, 1), sampling=sides)[(slice(1, -1),) * mask.ndim]
    return depth


def flood_from_markers(heights: NDArray[np.floating], markers: Labels, basin: Mask | None = None) -> Labels:
    """Flood a grid, or a basin of it, from labeled markers over the lowest heights; return the labels."""
    flood: Callable[..., Labels] = skimage.segmentation.watershed
    return np.asarray(flood(heights, markers, mask=basin), np.int32)


@compiled
def find_root(group: Index, k: int) -> int:
    """Find the first member of the group of an item, `group` of shape (N,), and shorten the path to it."""
    while group[k] != k:
        group[k] = group[group[k]]
        k = group[k]
    return k


def find_high_maxima(heights: Array, least: float) -> Mask:
    """Find the pixels of the maxima of a grid from which every way to a higher pixel descends by a least height.

    The highest ones are among them if they are so far above the lowest pixel. Pixels also connect at corners
    (h-maxima: Soille 2004, doi:10.1007/978-3-662-05088-0).
    """
    low = heights.min()
    padded = np.pad(np.ascontiguousarray(heights, np.float64), 1, constant_values=low)
    flat, strides = padded.ravel() - low, np.array(padded.strides) // padded.itemsize
    above = np.flatnonzero(flat > 0.0)
    highest_first = above[np.argsort(-flat[above], kind="stable")]
    beside = grid_points([[-1, 0, 1]] * heights.ndim) @ strides
    group, equal = np.full((2, flat.size), -1)
    found = np.zeros(flat.size, np.bool_)
    _find_high_maxima(flat, highest_first, beside, least, group, equal, found)
    return found.reshape(padded.shape)[(slice(1, -1),) * heights.ndim]


@compiled
def _find_high_maxima(
    heights: Array, highest_first: Index, beside: Index, least: float, group: Index, equal: Index, found: Mask
) -> None:
    """Mark maxima that stand out; `group` and `equal` are -1 everywhere.

    A group is what is connected by pixels no lower than the one at hand. Its first member is its maximum, and no longer
    one when that pixel joins the group to a higher one. What is joined to an equal one is a maximum if that is.
    """
    for here in highest_first:
        group[here] = here
        for way in beside:
            if group[here + way] >= 0:
                one, other = find_root(group, here), find_root(group, here + way)
                if heights[other] > heights[one] or (heights[other] == heights[one] and other < one):
                    one, other = other, one
                if one != other:
                    found[other] = heights[other] - heights[here] >= least
                    if heights[other] == heights[one] and not found[other]:
                        equal[other] = one
                    group[other] = one
    for here in highest_first:
        if group[here] == here:
            found[here] = heights[here] >= least
        elif equal[here] >= 0:
            found[here] = found[equal[here]]


def spread_labels(labels: NDArray[_Kind]) -> NDArray[_Kind]:
    """Give each pixel without a label, which is 0, that of the nearest pixel with one."""
    nearest = scipy.ndimage.distance_transform_edt(labels == 0, return_distances=False, return_indices=True)
    return labels[tuple(nearest)]


def nearest_pixels(places: ArrayLike, shape: Extent) -> Index:
    """Return the pixels of a grid of this shape that are nearest to places, shape (..., D)."""
    inside: Array = np.clip(places, 0, np.array(shape) - 1)
    return np.rint(inside).astype(np.int64)


def compute_iou(one: Mask, other: Mask) -> float:
    """Compute the intersection over union of two masks of one shape; 0 when both are empty."""
    whole = np.count_nonzero(one | other)
    return np.count_nonzero(one & other) / whole if whole else 0.0


def find_largest_part(mask: Mask) -> Mask:
    """Find the largest connected part of a mask whose neighbors share a side."""
    parts, _ = scipy.ndimage.label(mask)
    sizes = np.bincount(parts.ravel())
    sizes[0] = 0
    return parts == sizes.argmax()


@compiled
def renumber_groups(group: Index) -> int:
    """Label groups from 0 in the order of their first members, which lead to themselves; return how many there are."""
    count = 0
    for q in range(len(group)):
        if group[q] == q:
            group[q] = count
            count += 1
        else:
            group[q] = group[group[q]]
    return count


def label_joined_pairs(pairs: Iterable[Index], count: int) -> Index:
    """Return the number, from 0, of the part of each of `count` items; `pairs`, shape (2, N), are connected."""
    one, other = pairs
    joined = scipy.sparse.coo_array((np.ones(len(one)), (one, other)), (count, count))
    return scipy.sparse.csgraph.connected_components(joined, directed=False)[1].astype(np.int64)


_MIN_RELATIVE_VALUE = 1e-3
"""Least size of a value, in the median size: no vertex lies at a voxel, where triangles would have no area."""

_CUBE_CORNERS = tuple(product((0, 1), repeat=3))
"""Corners of a cube of eight voxels; the first four are opposite to the last four."""


def zero_surface(values: Single, inner: tuple[tuple[int, int], ...] | None = None) -> tuple[Array, Index]:
    """Return vertices [voxels], shape (N, 3), and triangles, shape (F, 3), of the surface around the voxels above zero.

    Seen from outside, triangles run counter-clockwise. Voxels inside are connected over faces and edges, those outside
    over faces alone. `inner` is the range of voxels to consider along each axis; the surface is open where it leaves
    that range.
    """
    begin, end = np.transpose(inner if inner is not None else [(0, size) for size in values.shape])
    part = values[tuple(map(slice, begin, end))]
    if min(part.shape) < 2 or not part.max() > 0.0 >= part.min():
        return np.empty((0, 3)), np.empty((0, 3), np.int64)
    least = np.float32(_MIN_RELATIVE_VALUE) * np.median(np.abs(part), overwrite_input=True)
    darker = -part
    for plane in darker:
        small = np.abs(plane) < least
        plane[small] = np.where(plane[small] < 0.0, -least, least)
    vertices, faces, _, _ = skimage.measure.marching_cubes(darker, 0.0, method="lorensen")  # type: ignore[no-untyped-call]
    return vertices.astype(float) + begin, faces.astype(np.int64)


_PLANES_PER_PASS = 16
"""Number of planes of cubes that are examined together."""


def bridge_corner_contacts(values: Single, raised: float) -> None:
    """Raise voxels of a volume so that two above zero that touch at a corner only are connected over faces as well."""
    inside = values > 0.0
    for first in range(0, len(values) - 1, _PLANES_PER_PASS):
        part = inside[first : first + _PLANES_PER_PASS + 1]
        corners = {
            at: part[tuple(slice(k, n - 1 + k) for k, n in zip(at, part.shape, strict=True))] for at in _CUBE_CORNERS
        }
        two = np.zeros(corners[0, 0, 0].shape, np.uint8)
        for here in corners.values():
            two += here
        two = two == 2
        for (plane, row, col), corner in zip(_CUBE_CORNERS[:4], _CUBE_CORNERS[:3:-1], strict=True):
            joint = np.argwhere(two & corners[plane, row, col] & corners[corner])
            values[tuple((joint + np.array((first + 1 - plane, row, col))).T)] = raised


def true_bounds(mask: Mask) -> Index:
    """Return the first and last position along each axis, shape (2, D), of the true pixels of a mask."""
    others = (tuple(k for k in range(mask.ndim) if k != axis) for axis in range(mask.ndim))
    lines = (np.flatnonzero(mask.any(axis=axes)) for axes in others)
    return np.array([[line[0], line[-1]] for line in lines]).T


def bounding_window(mask: Mask) -> Window:
    """Return the smallest window with all true pixels of a mask that is not empty."""
    return tuple(slice(int(first), int(last) + 1) for first, last in true_bounds(mask).T)


_GAUSSIAN_TRUNCATION = 4.0
"""Number of standard deviations at which the Gaussian is cut off."""

_BAND_ROWS = 32
"""Number of rows of a band, which then stays in the cache of a core."""

_SUMMED_PIXELS = 512
"""Number of pixels of a row that are summed together, for the same reason."""


def run_in_bands(work: Callable[[int, int], object], rows: int, lines: int = _BAND_ROWS) -> None:
    """Process bands of rows in parallel; `work` gets the first row of a band and the one behind its last."""

    def run_bands(first: int, end: int) -> None:
        for begin in range(lines * first, min(lines * end, rows), lines):
            work(begin, min(begin + lines, rows))

    run_in_parallel(run_bands, -(-rows // lines), 1)


def gaussian_radius(sigma: float) -> int:
    """Return the distance at which a Gaussian of standard deviation `sigma` is cut off [px]."""
    return int(_GAUSSIAN_TRUNCATION * sigma + 0.5)


def half_gaussian_weights(sigma: float) -> Array:
    """Return the weights of a Gaussian of standard deviation `sigma` [px] from its middle on, shape (R + 1,)."""
    weights = np.exp(-0.5 / (sigma * sigma) * np.arange(gaussian_radius(sigma), -1, -1) ** 2)
    weights /= np.concatenate([weights, weights[-2::-1]]).sum()
    return weights[::-1].copy()


def smooth_rows(values: Array, sigma: float, first: int, end: int) -> Array:
    """Return rows of an image, shape (H, W), after a Gaussian of standard deviation `sigma` along both axes [px].

    The image continues beyond its border by its outermost pixels. Rows outside the image are left out. The sums are
    those of `scipy.ndimage.gaussian_filter`, bit for bit, in a tenth of its time.
    """
    first, end = max(first, 0), min(end, len(values))
    smooth, top = np.empty((end - first, values.shape[1])), max(first - gaussian_radius(sigma), 0)
    lines = values[top : end + gaussian_radius(sigma)].astype(np.float64, copy=False)
    lines.flags.writeable = False  # as those of an image are, else Numba would compile the loops for both
    weights = half_gaussian_weights(sigma)
    _write_smoothed_rows(lines, weights, first - top, np.empty(values.shape[1] + 2 * len(weights) - 2), smooth)
    return smooth


@compiled
def _write_smoothed_rows(values: Array, weights: Array, first: int, line: Array, smooth: Array) -> None:
    """Write rows from the first one on after a Gaussian, whose weights begin in its middle; `line` is room for one."""
    reach, cols = len(weights) - 1, values.shape[1]
    for i in range(len(smooth)):
        for left in range(0, cols, _SUMMED_PIXELS):
            right = min(left + _SUMMED_PIXELS, cols)
            sum_across(values, first + i, left, weights, line[reach + left : reach + right])
        extend_line(line, reach)
        for left in range(0, cols, _SUMMED_PIXELS):
            right = min(left + _SUMMED_PIXELS, cols)
            sum_along(line[left : right + 2 * reach], weights, smooth[i, left:right])


@compiled
def sum_across(lines: Array, at: int, first: int, weights: Array, total: Array) -> None:
    """Write the weighted sum of row `at` of lines, shape (N, K), and rows on both sides, into `total`, shape (M,).

    It begins with column `first`. Rows are taken one by one, and weights before the loop, else it uses no vectors.
    """
    end, last = first + len(total), len(lines) - 1
    here, weight = lines[at, first:end], weights[0]
    for j in range(len(total)):
        total[j] = here[j] * weight
    for k in range(len(weights) - 1, 0, -1):
        before, behind, weight = lines[max(at - k, 0), first:end], lines[min(at + k, last), first:end], weights[k]
        for j in range(len(total)):
            total[j] += (before[j] + behind[j]) * weight


@compiled
def extend_line(line: Array, reach: int) -> None:
    """Extend a line, shape (N,), at both ends, over `reach` entries, by its outermost inner values."""
    for k in range(reach):
        line[k], line[len(line) - 1 - k] = line[reach], line[len(line) - 1 - reach]


@compiled
def sum_along(line: Array, weights: Array, total: Array) -> None:
    """Write the weighted sums along a line, shape (N + 2 reach,), into `total`, shape (N,)."""
    reach = len(weights) - 1
    here, weight = line[reach:], weights[0]
    for j in range(len(total)):
        total[j] = here[j] * weight
    for k in range(reach, 0, -1):
        before, behind, weight = line[reach - k :], line[reach + k :], weights[k]
        for j in range(len(total)):
            total[j] += (before[j] + behind[j]) * weight
