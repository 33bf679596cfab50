"""Propagation from slice to slice: each answer is the previous mask of the next slice, along all three axes.

It goes on as long as the predicted overlap is large enough. Between slices that were asked, logits are interpolated.
"""

from __future__ import annotations

from functools import reduce

import numpy as np
import scipy

from cpm_core.numerics.grids import nearest_pixels
from cpm_core.numerics.types import Array, Single
from cpm_core.objects.prior.body_prediction import MAX_LOGIT, BodyPrediction
from cpm_core.objects.prior.crops import CROP_SIDE, INSIDE_PROBABILITY
from cpm_core.objects.prior.network import Network
from cpm_core.objects.prior.volume_slices import CropContext, SliceQuery, predict_slices

SLICE_SPACING = 6
"""Distance between slices that the network is asked about; between them logits are interpolated [steps]."""

_MIN_PROPAGATED_IOU = 0.5
"""Predicted overlap below which the answer in a slice is not propagated."""

_MAX_CORRECTED_SLICES = 7
"""Number of slices across an axis after which a correction is not propagated further."""


def propagate_slices(context: CropContext, probabilities: list[Single], network: Network) -> Single:
    """Propagate the answers in the slices through the first positive point.

    Parameters
    ----------
    context : CropContext
        The crop.
    probabilities : list of ndarray of float32, shape (CROP_SIDE, CROP_SIDE)
        Probabilities in the slices through the point across each axis.
    network : Network
        The network.

    Returns
    -------
    ndarray of float32, shape (CROP_SIDE, CROP_SIDE, CROP_SIDE)
        Mean of the logits of the slices across the three axes.
    """
    start = nearest_pixels(context.positive[0], context.grays.shape).tolist()
    known = [{start[axis]: _clip_logits(probabilities[axis])} for axis in range(3)]
    outside: Single = np.full((CROP_SIDE, CROP_SIDE), -MAX_LOGIT, np.float32)
    sure = [SliceQuery(axis, start[axis], probabilities[axis], way) for axis in range(3) for way in (-1, 1)]
    while sure:
        moved = [query._replace(step=query.step + query.direction * SLICE_SPACING) for query in sure]
        queries = [query for query in moved if _is_in_volume(query.step, query.axis, context)]
        sure = []
        for query, (probability, iou) in zip(queries, predict_slices(queries, context, network), strict=True):
            both = (probability > INSIDE_PROBABILITY) & (query.previous > INSIDE_PROBABILITY)
            if iou >= _MIN_PROPAGATED_IOU and both.any():
                known[query.axis][query.step] = _clip_logits(probability)
                sure.append(query._replace(previous=probability))
            else:
                known[query.axis][query.step] = outside
    logits = [_interpolate_slices(known[axis], axis, outside, outside) for axis in range(3)]
    return np.mean(logits, axis=0, dtype=np.float32)


def propagate_correction(
    context: CropContext, body: BodyPrediction, step: Array, adds: bool, network: Network
) -> tuple[Single, Single]:
    """Propagate a correction from the slices through its point, as long as more than a rim changes.

    Parameters
    ----------
    context : CropContext
        The crop, with the point.
    body : BodyPrediction
        The body before, in this crop.
    step : ndarray, shape (3,)
        The point [steps].
    adds : bool
        Whether the point adds to the body; else it removes from it.
    network : Network
        The network.

    Returns
    -------
    tuple of ndarray of float32, shape (CROP_SIDE, CROP_SIDE, CROP_SIDE)
        Mean of the logits of the slices that were asked across the three axes, and its weight: 1 from the first to the
        last of these slices across an axis, falling to 0 over one slice spacing beyond.
    """
    start = nearest_pixels(step, context.grays.shape).tolist()
    probabilities = scipy.special.expit(body.logits)
    before: list[Single] = [np.moveaxis(probabilities, axis, 0) for axis in range(3)]
    queries = [SliceQuery(axis, start[axis], before[axis][start[axis]]) for axis in range(3)]
    known: list[dict[int, Single]] = [{}, {}, {}]
    while queries:
        following = []
        for query, (probability, iou) in zip(queries, predict_slices(queries, context, network), strict=True):
            axis = query.axis
            known[axis][query.step] = _clip_logits(probability)
            is_on, was_on = probability > INSIDE_PROBABILITY, before[axis][query.step] > INSIDE_PROBABILITY
            changed = is_on & ~was_on if adds else was_on & ~is_on
            if (
                iou < _MIN_PROPAGATED_IOU
                or not scipy.ndimage.binary_erosion(changed).any()
                or len(known[axis]) >= _MAX_CORRECTED_SLICES
            ):
                continue
            added, removed = (changed, None) if adds else (None, changed)
            for way in (query.direction,) if query.direction else (-1, 1):
                at = query.step + way * 2 * SLICE_SPACING
                if _is_in_volume(at, axis, context):
                    previous = np.where(changed, probability, before[axis][at])
                    following.append(SliceQuery(axis, at, previous, way, added, removed))
        queries = following
    slices, weights = [], []
    on, off = np.ones((1, 1), np.float32), np.zeros((1, 1), np.float32)
    for axis in range(3):
        first, last = known[axis][min(known[axis])], known[axis][max(known[axis])]
        slices.append(_interpolate_slices(known[axis], axis, first, last))
        weights.append(_interpolate_slices(dict.fromkeys(known[axis], on), axis, off, off))
    total = np.maximum(sum(weights), 1e-6)
    logits = np.sum([each * weight for each, weight in zip(slices, weights, strict=True)], axis=0) / total
    return logits, reduce(np.maximum, weights)


def _is_in_volume(step: int, axis: int, context: CropContext) -> bool:
    """Return whether a slice of a crop lies in the volume."""
    first, last = context.inner_steps[axis]
    return bool(first <= step <= last)


def _clip_logits(probability: Single) -> Single:
    """Compute the logits of probabilities, clipped."""
    return np.clip(scipy.special.logit(probability), -MAX_LOGIT, MAX_LOGIT)


def _interpolate_slices(known: dict[int, Single], axis: int, first: Single, last: Single) -> Single:
    """Interpolate slices across an axis, by their steps; the crop begins with `first` and ends with `last`.

    These are reached within one slice spacing from the outermost slices.
    """
    inner = sorted(known)
    steps = [inner[0] - SLICE_SPACING, *inner, inner[-1] + SLICE_SPACING]
    slices = np.stack([first, *(known[step] for step in inner), last])
    line = np.clip(np.arange(CROP_SIDE), steps[0], steps[-1])
    low = np.clip(np.searchsorted(steps, line, side="right") - 1, 0, len(steps) - 2)
    part = ((line - np.take(steps, low)) / (np.take(steps, low + 1) - np.take(steps, low))).astype(np.float32)
    share = part[:, None, None]
    return np.moveaxis(slices[low] * (1.0 - share) + slices[low + 1] * share, 0, axis)
