"""The search for crops around a click: of which size, and where, by the three slices through it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
import scipy

from cpm_core.numerics.grids import compute_iou, label_parts, nearest_pixels
from cpm_core.numerics.types import Array, Mask, Single
from cpm_core.objects.prior.body_prediction import MAX_LOGIT, BodyPrediction
from cpm_core.objects.prior.crops import (
    CROP_SIDE,
    CROP_SIZE_RATIO,
    INSIDE_PROBABILITY,
    MIN_FIRST_SIDE,
    Crop3D,
    VolumeSampler,
)
from cpm_core.objects.prior.network import Network
from cpm_core.objects.prior.volume_slices import SLICE_AXES, predict_slices_through

_AGREEMENT_WEIGHT = 0.3
"""Weight of the agreement of slices along their shared lines, next to the predicted overlap."""

_MAX_CLARITY_LOSS = 0.2
"""How much less clear than the clearest crop another one may be [predicted overlap and weighted agreement]."""

_MIN_SAME_IOU = 0.7
"""Overlap in each slice through a point from which two answers are one body."""


def rank_crop_sizes(
    point: Array, sampler: VolumeSampler, network: Network, *, clear: bool
) -> list[tuple[Crop3D, list[Single]]]:
    """Rank crops of all sizes around a point, shape (3,), with the probabilities in their slices; the clearest first.

    Only those are returned that are `clear`, or only the others: these are much less clear than the first one, since a
    body there is cut off, or none is meant. The probabilities are those across each axis, each of shape (CROP_SIDE,
    CROP_SIDE).
    """
    largest = sampler.largest_crop_side
    count = max(int(np.ceil(np.log(largest / MIN_FIRST_SIDE) / np.log(CROP_SIZE_RATIO) - 0.5)), 0)
    crops = [Crop3D(point, side) for side in (*(MIN_FIRST_SIDE * CROP_SIZE_RATIO**k for k in range(count)), largest)]
    predictions = predict_slices_through(point, crops, [], sampler, network)
    ranked = []
    for number, crop in enumerate(crops):
        probabilities, predicted_ious = zip(*predictions[3 * number : 3 * number + 3], strict=True)
        score = np.mean(predicted_ious) + _AGREEMENT_WEIGHT * _measure_slice_agreement(probabilities)
        ranked.append((score, crop, list(probabilities)))
    ranked.sort(key=lambda each: -each[0])
    least = ranked[0][0] - _MAX_CLARITY_LOSS
    return [(crop, probabilities) for score, crop, probabilities in ranked if (score >= least) == clear]


def crop_closely(
    crop: Crop3D, probabilities: Sequence[Single], point: Array, sampler: VolumeSampler, network: Network
) -> tuple[Crop3D, list[Single]]:
    """Crop closely around the answers in the slices of a crop through a point, shape (3,), and predict again."""
    closer = _crop_around_slices(crop, probabilities, point)
    lines = crop.axes_to_crop_steps(closer.axis_positions)
    previous = []
    for axes, probability in zip(SLICE_AXES, probabilities, strict=True):
        steps = np.meshgrid(*(lines[axis] for axis in axes), indexing="ij")
        previous.append(np.asarray(scipy.ndimage.map_coordinates(probability, steps, order=1), np.float32))
    predictions = predict_slices_through(point, [closer], previous, sampler, network)
    return closer, [prediction.probability for prediction in predictions]


def agrees_in_slices(body: BodyPrediction, crop: Crop3D, probabilities: Sequence[Single], point: Array) -> bool:
    """Return whether the slices of a crop through a point, shape (3,), show what a body has there around the point."""
    step = crop.to_crop_steps(point)
    for axis, (axes, probability) in enumerate(zip(SLICE_AXES, probabilities, strict=True)):
        lines = body.crop.axes_to_crop_steps(crop.axis_positions)
        lines[axis] = body.crop.to_crop_steps(point)[axis : axis + 1]
        logits = scipy.ndimage.map_coordinates(
            body.logits, np.meshgrid(*lines, indexing="ij"), order=1, cval=-MAX_LOGIT
        )
        at = nearest_pixels(step[list(axes)], probability.shape)
        one, other = (
            _select_piece(mask, tuple(at.tolist()))
            for mask in (probability > INSIDE_PROBABILITY, logits.reshape(probability.shape) > 0.0)
        )
        if compute_iou(one, other) < _MIN_SAME_IOU:
            return False
    return True


def _select_piece(mask: Mask, at: tuple[int, ...]) -> Mask:
    """Select the connected piece of a mask that holds a pixel."""
    pieces, _ = label_parts(mask)
    return np.asarray((pieces == pieces[at]) & mask)


def _measure_slice_agreement(probabilities: Sequence[Single]) -> float:
    """Measure the mean overlap of three slices through the middle of a crop along the lines that they share."""
    overlaps = []
    for one, other in combinations(range(3), 2):
        first, second = (
            probabilities[across].take(CROP_SIDE // 2, SLICE_AXES[across].index(rest)) > INSIDE_PROBABILITY
            for across, rest in ((one, other), (other, one))
        )
        overlaps.append(np.count_nonzero(first & second) / max(int(np.count_nonzero(first | second)), 1))
    return float(np.mean(overlaps))


def _crop_around_slices(crop: Crop3D, probabilities: Sequence[Single], point: Array) -> Crop3D:
    """Crop around what three slices show, and a point."""
    low, high = point.copy(), point.copy()
    for axes, probability in zip(SLICE_AXES, probabilities, strict=True):
        for row, axis in enumerate(axes):
            on = np.flatnonzero((probability > INSIDE_PROBABILITY).any(axis=1 - row))
            if len(on):
                first, last = crop.axis_positions[axis][on[[0, -1]]]
                low[axis], high[axis] = min(low[axis], first), max(high[axis], last)
    return Crop3D.from_bounds(low, high)
