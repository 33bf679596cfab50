"""Slices of crops of a volume: what the network sees of them, and what it answers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from cpm_core.numerics.grids import measure_depth
from cpm_core.numerics.parallel import map_in_parallel
from cpm_core.numerics.types import Array, Index, Mask, Single
from cpm_core.objects.prior.crops import DEVIATION_OFFSET, INSIDE_PROBABILITY, Crop3D, VolumeSampler, mark_points
from cpm_core.objects.prior.network import Network
from cpm_core.objects.prior.object_predictor import build_input_maps

SLICE_AXES = ((1, 2), (0, 2), (0, 1))
"""The two axes of a slice across each axis."""


class CropContext(NamedTuple):
    """A crop with all that its slices are predicted from.

    Attributes
    ----------
    crop : Crop3D
        The crop.
    grays : ndarray of float32, shape (CROP_SIDE, CROP_SIDE, CROP_SIDE)
        Gray levels of its steps, from 0 to 255.
    inner_steps : ndarray of int64, shape (3, 2)
        Its first and last step in the volume, for each axis.
    object_gray : float
        Gray level of the object.
    positive, negative : ndarray, shape (M, 3) and (K, 3)
        Positive and negative points [steps].
    """

    crop: Crop3D
    grays: Single
    inner_steps: Index
    object_gray: float
    positive: Array
    negative: Array


class SliceQuery(NamedTuple):
    """A slice of a crop that the network is asked about.

    Attributes
    ----------
    axis, step : int
        The axis across it, and its step on that axis.
    previous : ndarray of float32, shape (CROP_SIDE, CROP_SIDE)
        Probabilities of the answer so far: those in the slice that the query comes from.
    direction : int
        Side on which slices follow, -1 or 1; 0 for both.
    added, removed : ndarray of bool, shape (CROP_SIDE, CROP_SIDE), optional
        What a correction has added or removed in the slice that the query comes from.
    """

    axis: int
    step: int
    previous: Single
    direction: int = 0
    added: Mask | None = None
    removed: Mask | None = None


class SlicePrediction(NamedTuple):
    """Answer of the network in a slice: probabilities, (CROP_SIDE, CROP_SIDE), and the overlap that it predicts."""

    probability: Single
    predicted_iou: float


def predict_slices_through(
    point: Array, crops: Sequence[Crop3D], previous: Sequence[Single], sampler: VolumeSampler, network: Network
) -> list[SlicePrediction]:
    """Predict the three slices of each crop through a positive point, shape (3,), from nothing but these slices.

    `previous` are probabilities of as many slices, shape (CROP_SIDE, CROP_SIDE), or nothing.
    """
    slices = [(crop, axis) for crop in crops for axis in range(3)]

    def build_maps(number: int) -> Single:
        crop, axis = slices[number]
        grays = sampler.sample_slice(crop, axis, float(point[axis]))
        positive = mark_points(crop.to_crop_steps(point[None])[:, SLICE_AXES[axis]])
        object_gray = float(np.median(grays[positive]))
        before = previous[number] if previous else np.zeros_like(grays)
        return _build_slice_maps(grays, object_gray, positive, np.zeros_like(positive), before)

    return _predict_in_parallel(build_maps, len(slices), network)


def predict_slices(queries: Sequence[SliceQuery], context: CropContext, network: Network) -> list[SlicePrediction]:
    """Predict slices of a crop, with the points near them."""
    return _predict_in_parallel(lambda number: _build_query_maps(queries[number], context), len(queries), network)


def _predict_in_parallel(build_maps: Callable[[int], Single], count: int, network: Network) -> list[SlicePrediction]:
    """Predict slices on all cores, each from the input maps that are built for its number."""

    def predict(number: int) -> SlicePrediction:
        probabilities, overlaps = network(build_maps(number))
        return SlicePrediction(probabilities[0], float(overlaps[0]))

    return map_in_parallel(predict, range(count))


def _build_query_maps(query: SliceQuery, context: CropContext) -> Single:
    """Build the input maps of a slice of a crop, with the points near it."""
    grays: Single = np.moveaxis(context.grays, query.axis, 0)[query.step]
    positive, negative = (
        mark_points(steps[np.abs(steps[:, query.axis] - query.step) <= 1.0][:, SLICE_AXES[query.axis]])
        if changed is None
        else _find_deepest(changed)
        for steps, changed in ((context.positive, query.added), (context.negative, query.removed))
    )
    if negative.any() and not positive.any():  # a negative point alone says little
        positive = _find_deepest((query.previous > INSIDE_PROBABILITY) & ~negative)
    return _build_slice_maps(grays, context.object_gray, positive, negative, query.previous)


def _find_deepest(mask: Mask) -> Mask:
    """Find the pixels that are farthest from the border of a mask."""
    depth = measure_depth(mask)
    return np.asarray((depth == depth.max()) & mask)


def _build_slice_maps(grays: Single, object_gray: float, positive: Mask, negative: Mask, previous: Single) -> Single:
    """Build the input maps of a slice; it has no colors."""
    mean, deviation = grays.mean(), grays.std() + DEVIATION_OFFSET
    channels = np.zeros((3, *grays.shape), np.float32)
    channels[0] = (grays - mean) / deviation
    level = np.array([(object_gray - mean) / deviation, 0.0, 0.0], np.float32)
    return build_input_maps(channels, level, positive, negative, np.zeros_like(grays), previous)
