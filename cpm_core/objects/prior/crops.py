"""Crops: squares of an image and cubes of a volume that the network sees, sampled with a fixed number of steps.

The network sees a cube slice by slice.
"""

from __future__ import annotations

import threading
from collections.abc import Iterable
from functools import cached_property
from typing import Any, Self

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.numerics.grids import lie_inside
from cpm_core.numerics.parallel import limit_blas
from cpm_core.numerics.types import Array, Extent, Index, Mask, Single, record

CROP_SIDE = 96
"""Pixels along each side of what the network sees."""

NETWORK_LUMINANCE_WEIGHTS = np.array([0.299, 0.587, 0.114], np.float32)
"""Weights of red, green and blue in the brightness that the network sees (ITU-R BT.601)."""

CROP_SIZE_RATIO = 1.6
"""Ratio of the side of one crop to that of the next smaller one."""

MIN_FIRST_SIDE = 40.0
"""Least side of a crop around a click [px, or smallest sides of a voxel]."""

MAX_RELATIVE_SIDE = 1.1
"""Largest side of a crop, in sides of the image or of the volume."""

_ANSWER_MARGIN = 1.35
"""Side of a crop around an answer, as a multiple of the side of the answer."""

_MIN_ANSWER_SIDE = 24.0
"""Least side of a crop around an answer [px, or smallest sides of a voxel]."""

INSIDE_PROBABILITY = 0.5
"""Probability above which a pixel, or a step of a crop, lies in the object."""

_BLACK_PERCENTILE = 0.1
"""Percentile of the gray levels that becomes 0."""

_WHITE_PERCENTILE = 99.9
"""Percentile of the gray levels that becomes 255."""

DEVIATION_OFFSET = 8.0
"""Added to the standard deviation of gray levels in a crop, so that noise does not look like an object."""

_COLOR_WEIGHT = 0.5
"""Weight of the standard deviation of color differences where the brightness varies less."""

_GRAY_SAMPLE_COUNT = 100_000
"""Approximate number of pixels by which the gray levels of an image are measured."""

_MAX_FLAT_RANGE = 1e-6
"""Range of gray levels, as a fraction of the largest, up to which a volume is uniform."""

_level_lock = threading.RLock()
"""Held while a level of a pyramid is computed, which threads that need it would each compute."""


def measure_image_grays(values: NDArray[Any]) -> tuple[float, ...]:
    """Measure the gray levels that become 0 and 255, in a sample of an image, shape (H, W) or (H, W, 3)."""
    step = find_sample_step(values.shape[:2])
    return measure_gray_range(values[::step, ::step])


def find_sample_step(shape: Extent) -> int:
    """Find the distance along each axis of the pixels by which the gray levels of an image are measured."""
    return max(int(np.sqrt(shape[0] * shape[1] / _GRAY_SAMPLE_COUNT)), 1)


def measure_gray_range(sample: NDArray[Any]) -> tuple[float, ...]:
    """Measure the gray levels that become 0 and 255, in samples of any shape."""
    return tuple(np.percentile(sample, [_BLACK_PERCENTILE, _WHITE_PERCENTILE]).tolist())


@record
class Crop:
    """A square of an image, or a cube of a volume, with `CROP_SIDE` steps along each axis.

    Attributes
    ----------
    center : ndarray, shape (D,)
        Its center [px, or smallest sides of a voxel].
    side : float
        Length of its sides, in the same unit; it may extend beyond the image.
    """

    center: Array
    side: float

    @classmethod
    def from_bounds(cls, low: Array, high: Array) -> Self:
        """Crop around an answer between two corners, each of shape (D,), with a margin."""
        return cls(0.5 * (low + high), max(_ANSWER_MARGIN * float((high - low).max()), _MIN_ANSWER_SIDE))

    @property
    def step_size(self) -> float:
        """Distance between its steps."""
        return self.side / CROP_SIDE

    @property
    def axis_positions(self) -> list[Array]:
        """Positions of its steps along each axis, each of shape (CROP_SIDE,)."""
        return [middle + (np.arange(CROP_SIDE) - CROP_SIDE / 2) * self.step_size for middle in self.center.tolist()]

    def to_crop_steps(self, places: Array | Index) -> Array:
        """Convert points, shape (N, D), to steps of the crop, shape (N, D)."""
        return (places - self.center) / self.step_size + CROP_SIDE / 2

    def axes_to_crop_steps(self, lines: Iterable[Array | Index]) -> list[Array]:
        """Convert positions along each axis, each of shape (K,), to steps of the crop."""
        return [(line - m) / self.step_size + CROP_SIDE / 2 for line, m in zip(lines, self.center, strict=True)]


def mark_points(steps: Array) -> Mask:
    """Mark the pixels, shape (CROP_SIDE, CROP_SIDE), of a crop or a slice of it that hold points, shape (N, 2)."""
    on = np.zeros((CROP_SIDE, CROP_SIDE), np.bool_)
    place = np.rint(steps).astype(np.int64)
    on[tuple(place[lie_inside(place, CROP_SIDE)].T)] = True
    return on


@record
class Crop2D(Crop):
    """A square of an image; its steps are its pixels."""

    def sample_map(self, values: Mask | Single) -> Single:
        """Sample a map of the image, shape (H, W), in the crop, shape (CROP_SIDE, CROP_SIDE); zeros beyond it."""
        return _sample_within(values, *self.axis_positions)

    def sample_from(self, other: Crop2D, seen: Single) -> Single:
        """Sample the map of another crop in this one, both of shape (CROP_SIDE, CROP_SIDE); zeros beyond it."""
        return _sample_within(seen, *other.axes_to_crop_steps(self.axis_positions))

    def map_back(self, seen: Single, shape: Extent) -> tuple[tuple[slice, slice], Single]:
        """Return the rows and columns of an image of this shape in the crop, and its map sampled there."""
        lines = [np.arange(n) for n in shape]
        lines = [line[(line >= of[0]) & (line <= of[-1])] for line, of in zip(lines, self.axis_positions, strict=True)]
        rows, cols = (slice(int(line[0]), int(line[-1]) + 1) if len(line) else slice(0, 0) for line in lines)
        return (rows, cols), sample_bilinear(seen[..., None], *self.axes_to_crop_steps(lines))[..., 0]


@record
class ImageSampler:
    """An image as the network sees it, sampled in crops.

    Attributes
    ----------
    values : ndarray, shape (H, W) or (H, W, 3)
        Gray levels, or colors.
    gray_range : tuple of float, optional
        Gray levels that become 0 and 255, if those of a larger image are used.
    """

    values: NDArray[Any]
    gray_range: tuple[float, ...] = ()

    def sample_crop(self, window: Crop2D) -> Single:
        """Sample brightness and two color differences, shape (3, CROP_SIDE, CROP_SIDE), of about unit variance."""
        coarsest = max(int(np.log2(min(self.values.shape[:2]) / CROP_SIDE)), 0)
        number = int(np.clip(np.log2(max(window.step_size, 1.0)), 0, coarsest))
        level, coarseness = self._pyramid_level(number), window.step_size / 2**number
        rows, cols = ((line + 0.5) / 2**number - 0.5 for line in window.axis_positions)
        top, left = (max(int(line[0]) - 3, 0) for line in (rows, cols))
        part = level[top : max(int(rows[-1]) + 5, top + 1), left : max(int(cols[-1]) + 5, left + 1)]
        if not part.size:
            return np.zeros((3, CROP_SIDE, CROP_SIDE), np.float32)
        if number == 0:
            part = self._normalize_grays(part)
        if coarseness > 1.6:
            part = scipy.ndimage.gaussian_filter(part, (0.4 * coarseness, 0.4 * coarseness, 0), mode="nearest")
        seen = sample_bilinear(part, rows - top, cols - left)
        red, green, blue = np.moveaxis(np.broadcast_to(seen, (*seen.shape[:2], 3)), -1, 0)
        gray = np.asarray(np.tensordot(NETWORK_LUMINANCE_WEIGHTS, [red, green, blue], 1))
        colors = red - green, 0.5 * (red + green) - blue
        deviation = max(gray.std() + DEVIATION_OFFSET, *(_COLOR_WEIGHT * color.std() for color in colors))
        return np.stack([gray - gray.mean(), *colors]) / deviation

    def _pyramid_level(self, number: int) -> NDArray[Any]:
        """Return the image for 0, shape (H, W, C); else normalized means of 2 x 2 pixels of the level before."""
        if number == 0:
            return self.values.reshape(*self.values.shape[:2], -1)
        with _level_lock:
            if number not in self._cached_levels:
                finer = self._pyramid_level(number - 1)
                height, width = finer.shape[0] // 2 * 2, finer.shape[1] // 2 * 2
                rows = np.add(finer[:height:2], finer[1:height:2], dtype=np.float64 if number == 1 else np.float32)
                mean = 0.25 * (rows[:, :width:2] + rows[:, 1:width:2])
                self._cached_levels[number] = self._normalize_grays(mean) if number == 1 else mean
            return self._cached_levels[number]

    def _normalize_grays(self, values: NDArray[Any]) -> Single:
        """Scale gray levels to the range from 0 to 255."""
        low, high = self._gray_range
        return np.asarray((values - low) * (255.0 / max(high - low, 1e-300)), np.float32)

    @cached_property
    def _gray_range(self) -> tuple[float, ...]:
        """Gray levels that become 0 and 255."""
        return self.gray_range or measure_image_grays(self.values)

    @cached_property
    def _cached_levels(self) -> dict[int, Single]:
        """Levels of the pyramid that have been computed."""
        return {}


def _sample_within(values: Mask | Single, rows: Array, cols: Array) -> Single:
    """Interpolate (H, W) at the crossings of rows and columns, bilinear; zeros beyond the border."""
    seen = sample_bilinear(values[..., None], rows, cols)[..., 0]
    for axis, line in enumerate((rows, cols)):
        within = (line >= -0.5) & (line <= values.shape[axis] - 0.5)
        seen = seen * np.expand_dims(within, 1 - axis)
    return seen


def sample_bilinear(values: Mask | Single, rows: Array, cols: Array) -> Single:
    """Interpolate (H, W, C) at the crossings of rows and columns, bilinear; beyond the border as at the border."""
    seen = np.asarray(values)
    for axis, line in enumerate((rows, cols)):
        last = values.shape[axis] - 1
        inner = np.clip(line, 0, last)
        low = np.minimum(inner.astype(np.int64), max(last - 1, 0))
        part = (inner - low).astype(np.float32).reshape(-1, *[1] * (2 - axis))
        seen = seen.take(low, axis) * (1 - part) + seen.take(np.minimum(low + 1, last), axis) * part
    return np.asarray(seen)


@record
class Crop3D(Crop):
    """A cube of a volume."""

    def to_positions(self, steps: Array) -> Array:
        """Convert steps of the crop, shape (N, 3), to points: the inverse of `to_crop_steps`."""
        return (steps - CROP_SIDE / 2) * self.step_size + self.center

    def resample_from(self, other: Crop3D, values: Single, beyond: float) -> Single:
        """Resample values of another crop in this one, trilinear; `beyond` outside it.

        Both have the shape (CROP_SIDE, CROP_SIDE, CROP_SIDE).
        """
        if other is self:
            return values
        lines = other.axes_to_crop_steps(self.axis_positions)
        found = resample_with_tent(values, lines, (1.0, 1.0, 1.0))
        for axis, line in enumerate(lines):
            np.moveaxis(found, axis, 0)[(line < 0) | (line > CROP_SIDE - 1)] = beyond
        return found


@record
class VolumeSampler:
    """A volume as the network sees it, sampled in crops.

    Attributes
    ----------
    values : ndarray, shape (P, R, C)
        Gray levels.
    voxel_sides : ndarray, shape (3,)
        Sides of a voxel; the smallest is 1.
    """

    values: Array
    voxel_sides: Array

    def sample_crop(self, crop: Crop3D) -> Single:
        """Sample gray levels from 0 to 255 at the steps of a crop, shape (CROP_SIDE, CROP_SIDE, CROP_SIDE)."""
        return self._sample_grid(crop.axis_positions, crop.step_size)

    def sample_slice(self, crop: Crop3D, axis: int, position: float) -> Single:
        """Sample gray levels, 0 to 255, in the slice of a crop across an axis, shape (CROP_SIDE, CROP_SIDE)."""
        lines = crop.axis_positions
        lines[axis] = np.array([position])
        grays: Single = np.moveaxis(self._sample_grid(lines, crop.step_size), axis, 0)[0]
        return grays

    def _sample_grid(self, lines: list[Array], step_size: float) -> Single:
        """Sample gray levels from 0 to 255 at the crossings of lines along each axis, each of shape (K,)."""
        low, high = self._gray_range
        voxels = [line / side for line, side in zip(lines, self.voxel_sides.tolist(), strict=True)]
        factor = 255.0 / (high - low) if high - low > _MAX_FLAT_RANGE * max(abs(low), abs(high)) else 0.0
        return (resample_with_tent(self.values, voxels, tuple(step_size / self.voxel_sides)) - low) * factor

    def find_inner_steps(self, crop: Crop3D) -> Index:
        """Find for each axis the first and the last step of a crop in the volume, shape (3, 2)."""
        found = []
        for line, side, count in zip(crop.axis_positions, self.voxel_sides.tolist(), self.values.shape, strict=True):
            there = np.flatnonzero((line >= -0.5 * side) & (line <= (count - 0.5) * side))
            found.append((there[0], there[-1]) if len(there) else (0, 0))
        return np.array(found)

    def widen_crop(self, crop: Crop3D, side: float) -> Crop3D:
        """Widen a crop to a side, at most that of the largest crop, and move it so that little lies beyond the volume.

        What it held of the volume it still holds.
        """
        side = min(side, max(self.largest_crop_side, crop.side))
        ends = np.array(self.values.shape) * self.voxel_sides
        low, high = 0.5 * (side - self.voxel_sides), ends - 0.5 * (side + self.voxel_sides)
        center = np.where(low < high, np.clip(crop.center, low, high), 0.5 * (low + high))
        return Crop3D(center, side)

    @cached_property
    def largest_crop_side(self) -> float:
        """Side of the largest crop, by the longest side of the volume."""
        return MAX_RELATIVE_SIDE * float((self.voxel_sides * self.values.shape).max())

    @cached_property
    def _gray_range(self) -> tuple[float, ...]:
        step = max(int(np.cbrt(self.values.size / _GRAY_SAMPLE_COUNT)), 1)
        return measure_gray_range(self.values[::step, ::step, ::step])


@limit_blas()
def resample_with_tent(values: Array | Single | Mask, lines: list[Array], widths: tuple[float, ...]) -> Single:
    """Resample values at the crossings of lines along each axis, each of shape (K,) [voxels], as float32.

    Each value is the mean under a tent as wide as the steps are long (`widths`). Beyond the border values are as at the
    border.
    """
    weights, box = [], []
    for line, width, count in zip(lines, widths, values.shape, strict=True):
        reach = max(width, 1.0)
        first = int(np.clip(np.floor(line[0] - reach), 0, count - 1))
        end = int(np.clip(np.ceil(line[-1] + reach) + 1, first + 1, count))
        near = np.clip(line, 0, count - 1)[:, None] - np.arange(first, end)
        tent = np.maximum(1.0 - np.abs(near) / reach, 0.0)
        weights.append((tent / tent.sum(axis=1, keepdims=True)).astype(np.float32))
        box.append(slice(first, end))
    found = values[tuple(box)].astype(np.float32)
    for axis in np.argsort([len(tent) / tent.shape[1] for tent in weights]).tolist():
        tent, before, behind = weights[axis], found.shape[:axis], found.shape[axis + 1 :]
        if behind:
            found = (tent @ found.reshape(*before, tent.shape[1], -1)).reshape(*before, len(tent), *behind)
        else:  # one product instead of one for each line
            found = found @ tent.T
    return found


def average_blocks(values: Single, side: int) -> Single:
    """Average blocks of `side` steps along each axis of a cube whose sides are divisible by it."""
    for _ in range(3):
        values = np.moveaxis(np.sum([values[k::side] for k in range(side)], axis=0), 0, -1)
    return values / np.float32(side**3)


def repeat_blocks(values: NDArray[Any], side: int) -> NDArray[Any]:
    """Repeat the steps of a cube in blocks of `side` steps along each axis."""
    return values.repeat(side, axis=0).repeat(side, axis=1).repeat(side, axis=2)
