"""The search for crops around a click: of which size, and where, by the three slices through it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
import scipy

from cpm_core.numerics.types import Array, Single
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


def rank_crop_sizes(point: Array, sampler: VolumeSampler, network: Network) -> list[tuple[Crop3D, list[Single]]]:
    """Rank crops of all sizes around a point, shape (3,), with the probabilities in their slices; the clearest first.

    The probabilities are those across each axis, each of shape (CROP_SIDE, CROP_SIDE).
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
    return [(crop, probabilities) for _, crop, probabilities in ranked]


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
