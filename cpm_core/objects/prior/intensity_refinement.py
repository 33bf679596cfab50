"""Refinement by gray levels: how much likelier each is inside a body than outside it, as far as one can see around it.

To the logits of the slices the log likelihood ratio of gray levels is added, inside to outside, by the means and
deviations of both around the step (local regions: Lankton and Tannenbaum 2008, doi:10.1109/TIP.2008.2004611).
"""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.types import Single
from cpm_core.objects.prior.crops import CROP_SIDE, DEVIATION_OFFSET, average_blocks, resample_with_tent
from cpm_core.objects.prior.volume_slices import CropContext

POINT_LOGIT = 8.0
"""Contribution of a point at its place [logits]."""

_POINT_SIGMA = 1.5
"""Sigma of the Gaussian within which a point contributes [steps]."""

_SLICE_WEIGHT = 0.5
"""Weight of the logits of the slices."""

_INTENSITY_BLOCK = 4
"""Side of the blocks in which gray levels are measured [steps]."""

_INTENSITY_ROUNDS = 6
"""Number of rounds in which gray levels are measured again."""

_INTENSITY_SIGMA = 10.0
"""Sigma of the Gaussian that weights gray levels around a step [steps]."""

_EMPTY_SIDE_WEIGHT = np.float32(1e-3)
"""Weight of the gray levels of a side that is not near, as a share of their mean over the crop."""

_MAX_INTENSITY_LOGIT = 4.0
"""Largest contribution of gray levels [logits]."""


def refine_by_intensity(context: CropContext, slice_logits: Single) -> Single:
    """Refine the logits of the slices, shape (CROP_SIDE, CROP_SIDE, CROP_SIDE), by points and gray levels.

    Returns float32 of the same shape. What is inside is measured again in each round, on steps twice as long.
    """
    given = _SLICE_WEIGHT * slice_logits + _compute_point_logits(context)
    coarse_grays, coarse_given = (average_blocks(values, _INTENSITY_BLOCK // 2) for values in (context.grays, given))
    logits = coarse_given
    for _ in range(_INTENSITY_ROUNDS):
        rule = _fit_likelihood_ratio(coarse_grays, scipy.special.expit(logits))
        logits = coarse_given + _evaluate_likelihood_ratio(coarse_grays, rule, 2)
    return np.asarray(given + _evaluate_likelihood_ratio(context.grays, rule, _INTENSITY_BLOCK), np.float32)


def _compute_point_logits(context: CropContext) -> Single:
    """Compute what points contribute to the logits around them."""
    logits: Single = np.zeros_like(context.grays)
    for steps, sign in ((context.positive, 1.0), (context.negative, -1.0)):
        for step in steps:
            away = (np.arange(CROP_SIDE) - step[:, None]) / _POINT_SIGMA
            plane, row, col = np.exp(-0.5 * np.square(away)).astype(np.float32)
            logits += (sign * POINT_LOGIT * plane)[:, None, None] * np.multiply.outer(row, col)
    return logits


def _fit_likelihood_ratio(grays: Single, inside: Single) -> Single:
    """Fit the log likelihood ratio of gray levels, inside to outside, by normal distributions around each block.

    Returns the factors of the powers 0, 1 and 2 of the gray level.
    """
    rule: Single = np.zeros((3, *[len(grays) // 2] * 3), np.float32)
    for weight, sign in ((inside, -0.5), (1.0 - inside, 0.5)):
        blurred = [
            scipy.ndimage.gaussian_filter(
                average_blocks(weight * power, 2), _INTENSITY_SIGMA / _INTENSITY_BLOCK, truncate=2.5
            )
            for power in (1.0, grays, np.square(grays))
        ]
        few = [_EMPTY_SIDE_WEIGHT * moment.mean() / max(blurred[0].mean(), 1e-6) for moment in blurred]
        total, first, second = (moment + some for moment, some in zip(blurred, few, strict=True))
        mean = first / total
        variance = np.maximum(second / total - np.square(mean), 0.0) + DEVIATION_OFFSET**2
        rule += np.float32(sign) * np.stack(
            [np.square(mean) / variance + np.log(variance), -2.0 * mean / variance, 1.0 / variance]
        )
    return rule


def _evaluate_likelihood_ratio(grays: Single, rule: Single, times: int) -> Single:
    """Evaluate the log likelihood ratio of gray levels by a rule that is `times` coarser."""
    line = (np.arange(len(grays)) + 0.5) / times - 0.5
    level, slope, bend = (resample_with_tent(factor, [line] * 3, (1.0, 1.0, 1.0)) for factor in rule)
    return np.clip(level + grays * (slope + grays * bend), -_MAX_INTENSITY_LOGIT, _MAX_INTENSITY_LOGIT)
