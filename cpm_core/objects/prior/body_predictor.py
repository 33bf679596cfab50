"""The network in a volume: the body that clicks mean, from predictions in slices across all three axes.

The network answers in the three slices through a click, and from there in slices along each axis. The mean of the
logits of the three directions, refined by gray levels, is the logit of each step of a crop.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import field
from functools import cached_property, lru_cache

import numpy as np
import scipy

from cpm_core.numerics.grids import compute_iou, true_bounds
from cpm_core.numerics.parallel import map_in_parallel
from cpm_core.numerics.types import Array, Single, record
from cpm_core.objects.prior.body_corrections import correct_in_crop, find_part_at_necks, lies_at_boundary
from cpm_core.objects.prior.body_prediction import MAX_LOGIT, BodyPrediction, is_different_body
from cpm_core.objects.prior.crop_search import agrees_in_slices, crop_closely, rank_crop_sizes
from cpm_core.objects.prior.crops import CROP_SIDE, Crop3D, VolumeSampler
from cpm_core.objects.prior.intensity_refinement import refine_by_intensity
from cpm_core.objects.prior.network import Network, load_trained_network
from cpm_core.objects.prior.slice_propagation import propagate_slices
from cpm_core.objects.prior.stable_regions import find_stable_regions, predict_opened_body
from cpm_core.objects.prior.volume_slices import CropContext

_CROP_WIDENING = 1.4
"""Factor by which a crop is widened whose sides a body touches."""

_MAX_WIDENINGS = 3
"""Number of times that a crop is widened before it becomes the largest."""

_REPEATED_IOU = 0.96
"""Overlap from which a stable region is a body found before."""

_NO_NEGATIVE_POINTS = np.empty((0, 3))
"""The negative points of a first click."""


@record
class BodyPredictor:
    """Predictions of the network for clicks in a volume.

    Attributes
    ----------
    values : ndarray, shape (P, R, C)
        Gray levels.
    voxel_sides : ndarray, shape (3,)
        Sides of a voxel; the smallest is 1. Points are in the same unit.
    network : Network
        The network.
    """

    values: Array
    voxel_sides: Array
    network: Network = field(default_factory=load_trained_network)

    def predict_bodies(self, point: Array) -> Iterator[BodyPrediction]:
        """Predict bodies that a point, shape (3,), may lie in.

        First come those predicted in crops of several sizes, then stable regions of similar gray levels, such as an
        organ in a head, and last the parts into which necks divide all of these. A crop is left out in whose slices
        lies the same as in those of a body before.
        """
        found = list(self.grow_bodies(point, clear=True))
        largest = max((body.crop for body in found), key=lambda crop: crop.side)
        context = self._build_context(largest, point[None])
        others = map_in_parallel(
            lambda region: _refine_body(context, np.where(region, MAX_LOGIT, -MAX_LOGIT).astype(np.float32)),
            list(find_stable_regions(context)),
        )
        known = [body.resample_in(largest).logits > 0.0 for body in found]
        for body in filter(None, (*others, predict_opened_body(context))):
            inside = body.logits > 0.0
            if all(compute_iou(inside, other) < _REPEATED_IOU for other in known):
                found.append(body)
                known.append(inside)
        yield from found
        yield from filter(None, (find_part_at_necks(body, point) for body in found))

    def grow_bodies(self, point: Array, *, clear: bool) -> Iterator[BodyPrediction]:
        """Grow the different bodies of a point, shape (3,), in crops that are `clear`, or in all others."""
        found: list[BodyPrediction] = []
        for wide, answers in rank_crop_sizes(point, self._sampler, self.network, clear=clear):
            crop, probabilities = crop_closely(wide, answers, point, self._sampler, self.network)
            if not any(agrees_in_slices(body, crop, probabilities, point) for body in found):
                body = self._grow_body(point, crop, probabilities)
                if all(is_different_body(body.volume, other.volume) for other in found):
                    found.append(body)
                    yield body

    def _grow_body(self, point: Array, crop: Crop3D, probabilities: list[Single]) -> BodyPrediction:
        """Grow the body of a point from the answers in the slices through it, in a crop that is widened as needed."""
        context = self._build_context(crop, point[None])
        body = _refine_body(context, propagate_slices(context, probabilities, self.network))
        largest = self._sampler.largest_crop_side
        for factor in (*[_CROP_WIDENING] * _MAX_WIDENINGS, np.inf):
            if not _touches_crop_sides(body, context) or body.crop.side >= largest:
                break
            wider = self._sampler.widen_crop(body.crop, factor * body.crop.side)
            context = self._build_context(wider, point[None])
            body = _refine_body(context, wider.resample_from(body.crop, body.slice_logits, -MAX_LOGIT))
        return body

    def correct_body(
        self,
        body: BodyPrediction,
        point: Array,
        adds: bool,
        positive: Array,
        negative: Array,
        find_other: Callable[[], BodyPrediction | None],
    ) -> BodyPrediction:
        """Correct a body by a point, shape (3,), that contradicts it, and `adds` to it or removes from it.

        `positive` and `negative` are all points so far, shape (M, 3) and (K, 3). A crop whose sides the new body
        touches is widened. `find_other` is that of `correct_in_crop`.
        """
        crop = self._widen_to_part(body, point) if adds else body.crop
        widest = _CROP_WIDENING * (_CROP_WIDENING * crop.side)  # rounded like the side of a crop widened twice
        while True:
            context = self._build_context(crop, positive, negative)
            after = correct_in_crop(body, context, point, adds, self.network, find_other)
            wider = self._sampler.widen_crop(crop, _CROP_WIDENING * crop.side)
            may_widen = adds and crop.side < wider.side <= widest
            if not may_widen or not _touches_crop_sides(after, context):
                return after
            crop = wider

    def _build_context(self, crop: Crop3D, positive: Array, negative: Array = _NO_NEGATIVE_POINTS) -> CropContext:
        """Sample a crop, where positive points, shape (M, 3), tell the gray level of the object."""
        grays, steps = self._sample_crop(crop), crop.to_crop_steps(positive)
        object_gray = float(np.median(scipy.ndimage.map_coordinates(grays, steps.T, order=1, mode="nearest")))
        inner_steps = self._sampler.find_inner_steps(crop)
        return CropContext(crop, grays, inner_steps, object_gray, steps, crop.to_crop_steps(negative))

    def _widen_to_part(self, body: BodyPrediction, point: Array) -> Crop3D:
        """Widen the crop of a body to hold a part of the same size around a point, shape (3,), beyond its boundary."""
        inside = body.logits > 0.0
        if not inside.any() or lies_at_boundary(body, point):
            return body.crop
        low, high = map(body.crop.to_positions, true_bounds(inside))
        reach = 0.5 * float((high - low).max())
        crop = Crop3D.from_bounds(np.minimum(low, point - reach), np.maximum(high, point + reach))
        return self._sampler.widen_crop(crop, crop.side)

    @cached_property
    def _sample_crop(self) -> Callable[[Crop3D], Single]:
        """Gray levels at the steps of a crop; those of the last crop are kept, as corrections need them again."""
        return lru_cache(1)(self._sampler.sample_crop)

    @cached_property
    def _sampler(self) -> VolumeSampler:
        return VolumeSampler(self.values, self.voxel_sides)


def _refine_body(context: CropContext, slice_logits: Single) -> BodyPrediction:
    """Build the body of logits of slices, refined by gray levels."""
    return BodyPrediction(context.crop, slice_logits, refine_by_intensity(context, slice_logits))


def _touches_crop_sides(body: BodyPrediction, context: CropContext) -> bool:
    """Return whether a body reaches the sides of its crop that lie inside the volume."""
    inside = body.logits > 0.0
    for axis, (first, last) in enumerate(context.inner_steps.tolist()):
        slices = np.moveaxis(inside, axis, 0)
        if (first == 0 and slices[:2].any()) or (last == CROP_SIDE - 1 and slices[-2:].any()):
            return True
    return False
