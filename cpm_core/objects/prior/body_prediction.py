"""A predicted body: a crop of a volume with the logit of each of its steps to lie in the body."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.grids import nearest_pixels, true_bounds
from cpm_core.numerics.types import Array, Mask, Single, record
from cpm_core.objects.prior.crops import Crop3D, resample_with_tent

MAX_LOGIT = 5.0
"""Largest logit of a slice; its negative stands for outside where nothing is known."""

EXCLUDED_LOGIT = -3.0 * MAX_LOGIT
"""Logit of a slice for what stays outside, wherever gray levels and corrections lead."""

_DISTINCT_VOLUME_RATIO = 1.5
"""Ratio of volumes above which two bodies around a point are different ones."""


@record
class BodyPrediction:
    """A predicted body.

    Attributes
    ----------
    crop : Crop3D
        The crop that it lies in.
    slice_logits, logits : ndarray of float32, shape (CROP_SIDE, CROP_SIDE, CROP_SIDE)
        Logits of the steps of the crop to lie in the body, by the slices alone, and in total.
    """

    crop: Crop3D
    slice_logits: Single
    logits: Single

    @property
    def volume(self) -> float:
        """Its volume [smallest sides of a voxel, cubed]."""
        return float(np.count_nonzero(self.logits > 0.0)) * self.crop.step_size**3

    def measure_volume_around(self, point: Array) -> float:
        """Measure the volume of its part around a point, shape (3,), on steps twice as long; 0 where there is none."""
        inside = self.logits[::2, ::2, ::2] > 0.0
        step = nearest_pixels(0.5 * self.crop.to_crop_steps(point), inside.shape)
        parts, _ = scipy.ndimage.label(inside)
        number = parts[tuple(step)]
        return float(np.count_nonzero(parts == number)) * (2.0 * self.crop.step_size) ** 3 if number else 0.0

    def holds(self, point: Array) -> bool:
        """Return whether a point, shape (3,), lies in the body."""
        step = self.crop.to_crop_steps(point)[:, None]
        return bool(scipy.ndimage.map_coordinates(self.logits, step, order=1, cval=-MAX_LOGIT) > 0.0)

    def resample_in(self, crop: Crop3D) -> BodyPrediction:
        """Resample the body in another crop; beyond its own crop is outside."""
        slice_logits, logits = (
            crop.resample_from(self.crop, values, -MAX_LOGIT) for values in (self.slice_logits, self.logits)
        )
        return BodyPrediction(crop, slice_logits, logits)


def is_different_body(volume: float, other: float) -> bool:
    """Return whether two bodies around a point are different ones, by their volumes."""
    return max(volume, other) > _DISTINCT_VOLUME_RATIO * min(volume, other)


def body_from_mask(mask: Mask, voxel_sides: Array) -> BodyPrediction:
    """Build the body of some voxels, shape (P, R, C), whose sides are given, shape (3,), the smallest being 1."""
    first, last = true_bounds(mask)
    crop = Crop3D.from_bounds((first - 0.5) * voxel_sides, (last + 0.5) * voxel_sides)
    logits = logits_from_mask(mask, voxel_sides, crop)
    return BodyPrediction(crop, logits, logits)


def logits_from_mask(mask: Mask, voxel_sides: Array, crop: Crop3D) -> Single:
    """Compute the logits of the steps of a crop to lie in some voxels, shape (P, R, C), whose sides are given.

    Returns float32, shape (CROP_SIDE, CROP_SIDE, CROP_SIDE).
    """
    lines = [line / side for line, side in zip(crop.axis_positions, voxel_sides.tolist(), strict=True)]
    share = resample_with_tent(mask, lines, tuple(crop.step_size / voxel_sides))
    logits = (2.0 * share - 1.0) * np.float32(MAX_LOGIT)
    for axis, line in enumerate(lines):
        np.moveaxis(logits, axis, 0)[(line < -0.5) | (line > mask.shape[axis] - 0.5)] = -MAX_LOGIT
    return logits
