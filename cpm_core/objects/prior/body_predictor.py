"""The network in a volume: the body that clicks mean, from predictions in slices across all three axes.

The network answers in the three slices through a click. Each answer is the previous mask of the next slice, on both
sides along each axis, as long as the predicted overlap is large enough. The mean of the logits of the three directions
is the slice logit of each step of a crop. To it the log likelihood ratio of gray levels is added, inside to outside, by
the means and deviations of both around the step (local regions: Lankton and Tannenbaum 2008,
doi:10.1109/TIP.2008.2004611).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import field
from functools import cached_property, lru_cache, partial
from itertools import combinations
from typing import NamedTuple

import numpy as np
import scipy
import skimage

from cpm_core.numerics.grids import true_bounds
from cpm_core.numerics.parallel import run_in_parallel
from cpm_core.numerics.types import Array, Mask, Single, record
from cpm_core.objects.prior.crops import (
    ANSWER_MARGIN,
    CROP_SIDE,
    CROP_SIZE_RATIO,
    DEVIATION_OFFSET,
    INSIDE_PROBABILITY,
    MAX_RELATIVE_SIDE,
    MIN_ANSWER_SIDE,
    MIN_FIRST_SIDE,
    Crop3D,
    VolumeSampler,
    mark_points,
    resample_with_tent,
)
from cpm_core.objects.prior.network import Network, load_trained_network
from cpm_core.objects.prior.object_predictor import build_input_maps

_CROP_WIDENING = 1.4
"""Factor by which a crop is widened whose sides a body touches."""

_MAX_WIDENINGS = 4
"""Largest number of times that a crop is widened."""

_DISTINCT_VOLUME_RATIO = 1.5
"""Ratio of volumes above which two bodies around a point are different ones."""

_GRAY_TOLERANCES = 8.0 * 1.25 ** np.arange(12)
"""Differences from the gray level of a point."""

_MAX_STABLE_GROWTH = 0.2
"""Largest growth of the logarithm of a volume from one tolerance to the next where it is stable."""

_SLICE_SPACING = 6
"""Distance between slices that the network is asked about; between them logits are interpolated [steps]."""

_MIN_PROPAGATED_IOU = 0.5
"""Predicted overlap below which the answer in a slice is not propagated."""


_AGREEMENT_WEIGHT = 0.3
"""Weight of the agreement of slices along their shared lines, next to the predicted overlap."""

MAX_LOGIT = 5.0
"""Largest logit; beyond the slices that were asked, its negative stands for outside."""

_INTENSITY_SIGMA = 10.0
"""Sigma of the Gaussian that weights gray levels around a step [steps]."""

_INTENSITY_ROUNDS = 6
"""Number of rounds in which gray levels are measured again."""

_SLICE_WEIGHT = 0.5
"""Weight of the logits of the slices."""

_MAX_INTENSITY_LOGIT = 4.0
"""Largest contribution of gray levels [logits]."""

_EMPTY_SIDE_WEIGHT = np.float32(1e-3)
"""Weight of the gray levels of a side that is not near, as a share of their mean over the crop."""

_CORRECTION_WEIGHT = 2.0
"""Weight of slice logits that a correction has led to, as a multiple of their first weight."""

_INTENSITY_BLOCK = 4
"""Side of the blocks in which gray levels are measured [steps]."""

_POINT_LOGIT = 8.0
"""Contribution of a point at its place [logits]."""

_POINT_SIGMA = 1.5
"""Sigma of the Gaussian within which a point contributes [steps]."""

_BOUNDARY_TOLERANCE = 1.5
"""Distance from the boundary up to which a point only moves the boundary [smallest sides of a voxel]."""

_POINT_NEIGHBORHOOD = 2
"""Distance from a point within which a change is due to it [steps]."""

_BODY_BASIN = 1
"""Number of the basin of the body."""

_OUTSIDE_BASIN = 2
"""Number of the basin outside."""

_MIN_ADDED_STRENGTH = 0.5
"""Least edge strength around an added part, as a fraction of that along the boundary of the body."""

_MAX_NECK_RADIUS = 3
"""Half the width of the widest neck [steps]."""

_SLICE_AXES = ((1, 2), (0, 2), (0, 1))
"""The two axes of a slice across each axis."""


@record
class BodyPrediction:
    """A predicted body.

    Attributes
    ----------
    crop : Cube
        The crop that it lies in.
    slice_logits, logits : ndarray of float32, shape (SIDE, SIDE, SIDE)
        Logits of the steps of the crop to lie in the body, by the slices alone, and in total.
    """

    crop: Crop3D
    slice_logits: Single
    logits: Single

    @property
    def volume(self) -> float:
        """Its volume [smallest sides of a voxel, cubed]."""
        return float(np.count_nonzero(self.logits > 0.0)) * self.crop.step_size**3

    def interpolate_logit(self, place: Array) -> float:
        """Interpolate the logit of a point, shape (3,): above 0 it lies in the body."""
        step = self.crop.to_crop_steps(place)[:, None]
        return float(scipy.ndimage.map_coordinates(self.logits, step, order=1, cval=-MAX_LOGIT)[0])


def is_different_body(size: float, other: float) -> bool:
    """Return whether two bodies around a point are different ones, by their volumes."""
    return max(size, other) > _DISTINCT_VOLUME_RATIO * min(size, other)


def body_from_mask(mask: Mask, size: Array) -> BodyPrediction:
    """Build the body of some voxels, shape (P, R, C), whose sides are given, shape (3,), the smallest being 1."""
    first, last = true_bounds(mask)
    low, high = (first - 0.5) * size, (last + 0.5) * size
    cube = Crop3D(0.5 * (low + high), max(ANSWER_MARGIN * float((high - low).max()), MIN_ANSWER_SIDE))
    logits = logits_from_mask(mask, size, cube)
    return BodyPrediction(cube, logits, logits)


def logits_from_mask(mask: Mask, size: Array, cube: Crop3D) -> Single:
    """Compute the logits of the steps of a crop to lie in some voxels, shape (P, R, C), whose sides are given.

    Returns float32, shape (SIDE, SIDE, SIDE).
    """
    lines = [line / side for line, side in zip(cube.axis_positions, size.tolist(), strict=True)]
    logits = (2.0 * resample_with_tent(mask, lines, tuple(cube.step_size / size)) - 1.0) * np.float32(MAX_LOGIT)
    for axis, line in enumerate(lines):
        np.moveaxis(logits, axis, 0)[(line < -0.5) | (line > mask.shape[axis] - 0.5)] = -MAX_LOGIT
    return logits


class _SliceQuery(NamedTuple):
    """A slice of a crop that the network is asked about: the axis across it, the step on that axis, the answer so far.

    What the next slice has added or removed is in `added` or `removed`.
    """

    axis: int
    step: int
    previous: Single
    added: Mask | None = None
    removed: Mask | None = None


class _SlicePredictions(NamedTuple):
    """Answers of the network in slices: probabilities, and predicted overlaps."""

    probability: list[Single]
    predicted_iou: list[float]


class _CropContext(NamedTuple):
    """A crop with its gray levels, the gray level of the object, and the steps of positive and negative points."""

    crop: Crop3D
    grays: Single
    object_gray: float
    positive: Array
    negative: Array


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

    def predict_bodies(self, place: Array) -> Iterator[BodyPrediction]:
        """Predict bodies of different sizes that a point, shape (3,), may lie in, the most plausible one first.

        Last come bodies that contain the point only because it is positive, such as a head around a point in its
        ventricles; and stable regions of similar gray levels, such as an organ in a head.
        """
        found: list[BodyPrediction] = []
        forced = []
        for cube, seen in self._rank_crop_sizes(place):
            body = self._grow_body(place, *self._recrop_around(cube, seen, place))
            if all(is_different_body(body.volume, one.volume) for one in found):
                found.append(body)
                if body.interpolate_logit(place) > _POINT_LOGIT:
                    yield body
                else:
                    forced.append(body)
        yield from forced
        yield from self._find_stable_regions(place, max(found, key=lambda body: body.crop.side).crop)

    def _find_stable_regions(self, place: Array, cube: Crop3D) -> Iterator[BodyPrediction]:
        """Find regions connected to a point whose gray levels differ from its own by less than a tolerance.

        Only those tolerances count at which the region hardly grows (maximally stable regions: Matas et al. 2004,
        doi:10.1016/j.imavis.2004.02.006). Bridges narrower than three steps are cut.
        """
        within = self._build_context(cube, place[None], np.empty((0, 3)))
        step = tuple(np.clip(np.rint(within.positive[0]), 0, CROP_SIDE - 1).astype(int).tolist())
        grays = scipy.ndimage.gaussian_filter(within.grays, 1.0)
        off = np.abs(grays - grays[step])
        for axis, (first, last) in enumerate(self._sampler.find_inner_steps(cube).tolist()):
            sides = np.moveaxis(off, axis, 0)
            sides[:first], sides[last + 1 :] = np.inf, np.inf
        parts: list[Mask] = []
        sizes: list[int] = []
        for tolerance in _GRAY_TOLERANCES:
            near = off < tolerance
            numbers, _ = scipy.ndimage.label(scipy.ndimage.binary_erosion(near, border_value=1))
            core = (numbers == numbers[step]) & (numbers[step] > 0)
            parts.append(scipy.ndimage.binary_dilation(core, iterations=2) & near)
            sizes.append(max(int(core.sum()), 1))
        growth = np.diff(np.log(sizes))
        beside = np.pad(growth, 1, constant_values=_MAX_STABLE_GROWTH)
        for k in np.flatnonzero((growth <= beside[:-2]) & (growth < beside[2:]) & (np.array(sizes[:-1]) > 1)).tolist():
            opinion = np.where(parts[k], MAX_LOGIT, -MAX_LOGIT).astype(np.float32)
            yield BodyPrediction(cube, opinion, self._refine_by_intensity(within, opinion))

    def _grow_body(self, place: Array, cube: Crop3D, seen: list[Single]) -> BodyPrediction:
        """Grow the body of a point from the answers in the slices through it, in a crop that is widened as needed."""
        for turn in range(_MAX_WIDENINGS):
            within = self._build_context(cube, place[None], np.empty((0, 3)))
            if turn == 0:
                opinion = self._propagate_slices(within, seen)
            body = BodyPrediction(cube, opinion, self._refine_by_intensity(within, opinion))
            if not self._touches_crop_sides(body) or cube.side >= MAX_RELATIVE_SIDE * self._sampler.longest_side:
                break
            cube, before = (
                Crop3D(cube.center, min(_CROP_WIDENING * cube.side, MAX_RELATIVE_SIDE * self._sampler.longest_side)),
                cube,
            )
            opinion = cube.resample_from(before, opinion, -MAX_LOGIT)
        return body

    def correct_body(
        self, body: BodyPrediction, place: Array, adds: bool, inside: Array, outside: Array
    ) -> BodyPrediction:
        """Correct a body by a point, shape (3,), that contradicts it, and `adds` to it or removes from it.

        `positive` and `negative` are all points so far, shape (M, 3) and (K, 3).
        """
        cube = self._widen_crop(body, place)
        while True:
            before = BodyPrediction(
                cube,
                cube.resample_from(body.crop, body.slice_logits, -MAX_LOGIT),
                cube.resample_from(body.crop, body.logits, -MAX_LOGIT),
            )
            within = self._build_context(cube, inside, outside)
            step = cube.to_crop_steps(place)
            near = _is_at_boundary(before, step)
            changed = (
                None
                if near
                else _add_by_watershed(within, before)
                if adds
                else _find_part_behind_neck(within, before, step)
            )
            if changed is not None:
                # at the rim of the change gray levels decide
                weight = np.where(changed, 1.0, 0.0) + (_CORRECTION_WEIGHT - 1.0) * scipy.ndimage.binary_erosion(
                    changed
                )
                sure = (MAX_LOGIT if adds else -MAX_LOGIT) * weight.astype(np.float32)
                opinion = np.where(changed, sure, before.slice_logits)
            else:
                opinion = before.slice_logits if near else self._propagate_change(within, before, step, adds)
            logits = self._refine_by_intensity(within, opinion)
            logits = np.maximum(logits, before.logits) if adds else np.minimum(logits, before.logits)
            after = BodyPrediction(cube, opinion, logits)
            if not adds or not self._touches_crop_sides(after) or cube.side > _CROP_WIDENING * body.crop.side:
                return after
            cube = Crop3D(cube.center, _CROP_WIDENING * cube.side)

    # Slices

    def _rank_crop_sizes(self, place: Array) -> list[tuple[Crop3D, list[Single]]]:
        """Rank crops of all sizes around a point, with the probabilities in their slices; the clearest first."""
        largest = MAX_RELATIVE_SIDE * self._sampler.longest_side
        count = max(int(np.ceil(np.log(largest / MIN_FIRST_SIDE) / np.log(CROP_SIZE_RATIO) - 0.5)), 0)
        cubes = [
            Crop3D(place, side) for side in (*(MIN_FIRST_SIDE * CROP_SIZE_RATIO**k for k in range(count)), largest)
        ]
        asked = [self._prepare_slices(cube, place, None) for cube in cubes]
        answers = self._predict_slices([maps for each in asked for maps in each])
        seen = [answers.probability[k : k + 3] for k in range(0, len(answers.probability), 3)]
        expected = np.mean(np.reshape(answers.predicted_iou, (-1, 3)), axis=1)
        ratings = [
            overlap + _AGREEMENT_WEIGHT * _measure_slice_agreement(slices)
            for overlap, slices in zip(expected, seen, strict=True)
        ]
        return [(cubes[k], seen[k]) for k in np.argsort(-np.array(ratings), kind="stable")]

    def _recrop_around(self, cube: Crop3D, found: list[Single], place: Array) -> tuple[Crop3D, list[Single]]:
        """Crop closely around the answers in the slices of a crop, and predict again."""
        wider = _crop_around_slices(cube, found, place)
        lines = cube.axes_to_crop_steps(wider.axis_positions)
        before = []
        for axis, seen in enumerate(found):
            places = np.meshgrid(*(lines[other] for other in _SLICE_AXES[axis]), indexing="ij")
            before.append(np.asarray(scipy.ndimage.map_coordinates(seen, places, order=1), np.float32))
        return wider, self._predict_slices(self._prepare_slices(wider, place, before)).probability

    def _prepare_slices(self, cube: Crop3D, place: Array, before: list[Single] | None) -> list[Callable[[], Single]]:
        """Prepare the input maps of the slices of a crop through a positive point, to be computed on demand."""
        step = cube.to_crop_steps(place[None])
        makers: list[Callable[[], Single]] = []
        for axis in range(3):
            grays = partial(self._sampler.sample_crop, cube, {axis: float(place[axis])})
            former = np.zeros((CROP_SIDE, CROP_SIDE), np.float32) if before is None else before[axis]
            makers.append(partial(_sample_slice_maps, grays, axis, step[:, _SLICE_AXES[axis]], former))
        return makers

    def _predict_slices(self, makers: Sequence[Callable[[], Single]]) -> _SlicePredictions:
        """Predict slices, in parallel on all cores."""
        seen: list[Single] = [np.empty(0, np.float32)] * len(makers)
        overlap = [0.0] * len(makers)

        def predict_range(first: int, end: int) -> None:
            for k in range(first, end):
                seen[k], overlap[k] = self.network(makers[k]())

        run_in_parallel(predict_range, len(makers), 1)
        return _SlicePredictions(seen, overlap)

    def _predict_crop_slices(self, within: _CropContext, slices: Sequence[_SliceQuery]) -> _SlicePredictions:
        return self._predict_slices([partial(_build_slice_maps, within, each) for each in slices])

    def _propagate_slices(self, within: _CropContext, seen: list[Single]) -> Single:
        """Propagate answers from slice to slice, `_SLICE_SPACING` steps apart, from those through the first point."""
        start = np.clip(np.rint(within.positive[0]).astype(int), 0, CROP_SIDE - 1).tolist()
        ends = self._sampler.find_inner_steps(within.crop)
        known = [{start[axis]: _clipped_logit(seen[axis])} for axis in range(3)]
        heads = [(_SliceQuery(axis, start[axis], seen[axis]), way) for axis in range(3) for way in (-1, 1)]
        while heads:
            heads = [(head._replace(step=head.step + way * _SLICE_SPACING), way) for head, way in heads]
            heads = [(head, way) for head, way in heads if ends[head.axis, 0] <= head.step <= ends[head.axis, 1]]
            answers = self._predict_crop_slices(within, [head for head, _ in heads])
            left = []
            for (head, way), found, overlap in zip(heads, *answers, strict=True):
                sure = (
                    overlap >= _MIN_PROPAGATED_IOU
                    and ((found > INSIDE_PROBABILITY) & (head.previous > INSIDE_PROBABILITY)).any()
                )
                known[head.axis][head.step] = _clipped_logit(found)
                if sure:
                    left.append((head._replace(previous=found), way))
                else:
                    known[head.axis][head.step] = np.minimum(known[head.axis][head.step], -MAX_LOGIT)
            heads = left
        return np.mean(
            [_interpolate_slices(known[axis], axis, -MAX_LOGIT)[0] for axis in range(3)], axis=0, dtype=np.float32
        )

    def _propagate_change(self, within: _CropContext, body: BodyPrediction, step: Array, adds: bool) -> Single:
        """Propagate a correction from the slices through its point, as long as more than a rim changes."""
        start = np.clip(np.rint(step).astype(int), 0, CROP_SIDE - 1).tolist()
        ends = self._sampler.find_inner_steps(within.crop)
        now = scipy.special.expit(body.logits)
        heads = [(_SliceQuery(axis, start[axis], now.take(start[axis], axis)), 0) for axis in range(3)]
        known: list[dict[int, Single]] = [{}, {}, {}]
        while heads:
            answers = self._predict_crop_slices(within, [head for head, _ in heads])
            left = []
            for (head, way), found, overlap in zip(heads, *answers, strict=True):
                known[head.axis][head.step] = _clipped_logit(found)
                before = now.take(head.step, head.axis)
                on, was = found > INSIDE_PROBABILITY, before > INSIDE_PROBABILITY
                other = on & ~was if adds else was & ~on
                if (
                    overlap < _MIN_PROPAGATED_IOU
                    or not scipy.ndimage.binary_erosion(other).any()
                    or len(known[head.axis]) > 6
                ):
                    continue
                for turn in (way,) if way else (-1, 1):
                    at = head.step + turn * 2 * _SLICE_SPACING
                    if ends[head.axis, 0] <= at <= ends[head.axis, 1]:
                        there = np.where(other, found, now.take(at, head.axis))
                        sides = (other, None) if adds else (None, other)
                        left.append((_SliceQuery(head.axis, at, there, *sides), turn))
            heads = left
        opinions, weights = zip(*(_interpolate_slices(known[axis], axis, 0.0) for axis in range(3)), strict=True)
        total = np.maximum(np.sum(weights, axis=0), 1e-6)
        mean = np.sum([one * weight for one, weight in zip(opinions, weights, strict=True)], axis=0) / total
        blend = np.max(weights, axis=0)
        anew = np.clip(
            _CORRECTION_WEIGHT * _CORRECTION_WEIGHT * mean,
            -_CORRECTION_WEIGHT * MAX_LOGIT,
            _CORRECTION_WEIGHT * MAX_LOGIT,
        )
        return np.asarray(blend * anew + (1.0 - blend) * body.slice_logits, np.float32)

    # Gray levels

    def _refine_by_intensity(self, within: _CropContext, opinion: Single) -> Single:
        """Refine the logits of the slices by points and gray levels.

        Gray levels add how much likelier each is inside than outside, by the means and deviations of both around it;
        the rule is fitted again in each round.
        """
        places = np.zeros_like(opinion)
        for steps, sign in ((within.positive, 1.0), (within.negative, -1.0)):
            for step in steps:
                plane, row, col = np.exp(
                    -0.5 * np.square((np.arange(CROP_SIDE) - step[:, None]) / _POINT_SIGMA)
                ).astype(np.float32)
                places += (sign * _POINT_LOGIT * plane)[:, None, None] * np.multiply.outer(row, col)
        given = _SLICE_WEIGHT * opinion + places
        half, coarse = (
            _average_blocks(within.grays, _INTENSITY_BLOCK // 2),
            _average_blocks(given, _INTENSITY_BLOCK // 2),
        )
        logits = coarse
        for _ in range(_INTENSITY_ROUNDS):
            rule = _fit_likelihood_ratio(half, scipy.special.expit(logits))
            logits = coarse + _evaluate_likelihood_ratio(half, rule, 2)
        return np.asarray(given + _evaluate_likelihood_ratio(within.grays, rule, _INTENSITY_BLOCK), np.float32)

    # Cubes

    def _build_context(self, cube: Crop3D, inside: Array, outside: Array) -> _CropContext:
        """Build the context of a crop: its gray levels and the steps of points."""
        grays = self._sample_cached(cube)
        within, beyond = cube.to_crop_steps(inside), cube.to_crop_steps(outside)
        level = float(np.median(scipy.ndimage.map_coordinates(grays, within.T, order=1, mode="nearest")))
        return _CropContext(cube, grays, level, within, beyond)

    def _touches_crop_sides(self, body: BodyPrediction) -> bool:
        """Return whether a body reaches the sides of its crop that lie inside the volume."""
        likely = body.logits > 0.0
        for axis, (first, last) in enumerate(self._sampler.find_inner_steps(body.crop).tolist()):
            sides = np.moveaxis(likely, axis, 0)
            if (first == 0 and sides[:2].any()) or (last == CROP_SIDE - 1 and sides[-2:].any()):
                return True
        return False

    def _widen_crop(self, body: BodyPrediction, place: Array) -> Crop3D:
        """Return the crop of a body, widened if a point lies at its sides or beyond."""
        off = np.abs(body.crop.to_crop_steps(place) - CROP_SIDE / 2).max()
        most = CROP_SIDE / 2 - _SLICE_SPACING
        return body.crop if off <= most else Crop3D(body.crop.center, body.crop.side * float(off / most))

    @cached_property
    def _sample_cached(self) -> Callable[[Crop3D], Single]:
        """Gray levels at the steps of a crop; those of the last crop are kept, as corrections need them again."""
        return lru_cache(1)(self._sampler.sample_crop)

    @cached_property
    def _sampler(self) -> VolumeSampler:
        return VolumeSampler(self.values, self.voxel_sides)


def _sample_slice_maps(grays: Callable[[], Single], axis: int, inside: Array, before: Single) -> Single:
    """Build the input maps of a slice through positive points, whose gray levels are sampled first."""
    there: Single = np.moveaxis(grays(), axis, 0)[0]
    on = mark_points(inside)
    return _build_maps(there, float(np.median(there[on])), on, np.zeros_like(on), before)


def _build_slice_maps(within: _CropContext, asked: _SliceQuery) -> Single:
    """Build the input maps of a slice of a crop, with the points near it."""
    there: Single = np.moveaxis(within.grays, asked.axis, 0)[asked.step]
    inside, outside = (
        mark_points(steps[np.abs(steps[:, asked.axis] - asked.step) <= 1.0][:, _SLICE_AXES[asked.axis]])
        if changed is None
        else _find_deepest(changed)
        for steps, changed in ((within.positive, asked.added), (within.negative, asked.removed))
    )
    if outside.any() and not inside.any():  # a negative point alone says little
        inside = _find_deepest((asked.previous > INSIDE_PROBABILITY) & ~outside)
    return _build_maps(there, within.object_gray, inside, outside, asked.previous)


def _find_deepest(mask: Mask) -> Mask:
    """Find the pixels that are farthest from the border of a mask."""
    depth = scipy.ndimage.distance_transform_edt(np.pad(mask, 1))[1:-1, 1:-1]
    return np.asarray((depth == depth.max()) & mask)


def _build_maps(grays: Single, level: float, inside: Mask, outside: Mask, before: Single) -> Single:
    mean, deviation = grays.mean(), grays.std() + DEVIATION_OFFSET
    seen = np.zeros((3, CROP_SIDE, CROP_SIDE), np.float32)
    seen[0] = (grays - mean) / deviation
    like = np.array([(level - mean) / deviation, 0.0, 0.0], np.float32)
    return build_input_maps(seen, like, inside, outside, np.zeros_like(grays), before)


def _measure_slice_agreement(slices: Sequence[Single]) -> float:
    """Measure the mean overlap of three slices through the middle of a crop along the lines that they share."""
    found = []
    for one, other in combinations(range(3), 2):
        first, second = (
            slices[across].take(CROP_SIDE // 2, _SLICE_AXES[across].index(rest)) > INSIDE_PROBABILITY
            for across, rest in ((one, other), (other, one))
        )
        found.append(np.count_nonzero(first & second) / max(int(np.count_nonzero(first | second)), 1))
    return float(np.mean(found))


def _crop_around_slices(cube: Crop3D, slices: Sequence[Single], place: Array) -> Crop3D:
    """Crop around what three slices show, and a point."""
    low, high = place.copy(), place.copy()
    for axis, seen in enumerate(slices):
        for row, other in enumerate(_SLICE_AXES[axis]):
            on = np.flatnonzero((seen > INSIDE_PROBABILITY).any(axis=1 - row))
            if len(on):
                ends = cube.axis_positions[other][on[[0, -1]]]
                low[other], high[other] = min(low[other], ends[0]), max(high[other], ends[1])
    return Crop3D(0.5 * (low + high), max(ANSWER_MARGIN * float((high - low).max()), MIN_ANSWER_SIDE))


def _interpolate_slices(known: dict[int, Single], axis: int, beyond: float) -> tuple[Single, Single]:
    """Interpolate slices across an axis between the known ones; return them and their weights from 0 to 1.

    From the outermost slices on, values fall to `beyond` over one slice distance.
    """
    steps = sorted(known)
    at = [steps[0] - _SLICE_SPACING, *steps, steps[-1] + _SLICE_SPACING]
    maps = np.stack([known[steps[0]], *(known[step] for step in steps), known[steps[-1]]])
    weight = np.array([0.0, *[1.0] * len(steps), 0.0])
    if beyond:
        maps[0], maps[-1] = beyond, beyond
    line = np.clip(np.arange(CROP_SIDE), at[0], at[-1])
    low = np.clip(np.searchsorted(at, line, side="right") - 1, 0, len(at) - 2)
    part = ((line - np.take(at, low)) / (np.take(at, low + 1) - np.take(at, low))).astype(np.float32)
    share_of = part[:, None, None]
    found = maps[low] * (1.0 - share_of) + maps[low + 1] * share_of
    counts = np.asarray(weight[low] * (1.0 - part) + weight[low + 1] * part, np.float32)
    return np.moveaxis(found, 0, axis), np.moveaxis(np.broadcast_to(counts[:, None, None], found.shape), 0, axis)


def find_changes_near(before: BodyPrediction, after: BodyPrediction, place: Array) -> Mask:
    """Find the steps of a body that a point, shape (3,), has changed, without a rim that leads away from it.

    Returns a mask, shape (SIDE, SIDE, SIDE).
    """
    changed = (after.crop.resample_from(before.crop, before.logits, -MAX_LOGIT) > 0.0) != (after.logits > 0.0)
    parts, _ = scipy.ndimage.label(scipy.ndimage.binary_erosion(changed))
    near = np.zeros_like(changed)
    near[
        tuple(
            slice(max(at - _POINT_NEIGHBORHOOD, 0), at + _POINT_NEIGHBORHOOD + 1)
            for at in np.rint(after.crop.to_crop_steps(place)).astype(int)
        )
    ] = True
    held = np.isin(parts, np.setdiff1d(parts[near], 0))
    return np.asarray((scipy.ndimage.binary_dilation(held, iterations=2) | near) & changed)


def _is_at_boundary(body: BodyPrediction, step: Array) -> bool:
    """Return whether a step lies so near to the boundary of a body that its point only moves the boundary."""
    ways = np.concatenate([np.eye(3), -np.eye(3)]) * (_BOUNDARY_TOLERANCE / body.crop.step_size)
    near = scipy.ndimage.map_coordinates(body.logits, (step + ways).T, order=1, mode="nearest") > 0.0
    return bool(near.any() and not near.all())


def _add_by_watershed(within: _CropContext, body: BodyPrediction) -> Mask | None:
    """Find the part that edges enclose together with points that a body lacks.

    Basins of the edge map are flooded from the body and its points, and from the sides of the crop and negative points
    (watershed from markers: Meyer 1994, doi:10.1016/0165-1684(94)90060-4). None unless the boundary of the new part is
    about as strong as that of the body.
    """
    before = _average_blocks(body.logits, 2) > 0.0
    edges = scipy.ndimage.gaussian_gradient_magnitude(_average_blocks(within.grays, 2), 1.0)
    markers = np.where(before, _BODY_BASIN, 0).astype(np.int32)
    for axis in range(3):
        np.moveaxis(markers, axis, 0)[[0, -1]] = _OUTSIDE_BASIN
    for steps, number in ((within.negative, _OUTSIDE_BASIN), (within.positive, _BODY_BASIN)):
        place = np.clip(np.rint((steps - 0.5) / 2.0), 0, len(before) - 1).astype(np.int64)
        markers[tuple(place.T)] = number
    changed = (skimage.segmentation.watershed(edges, markers) == _BODY_BASIN) & ~before  # type: ignore[no-untyped-call]
    along = scipy.ndimage.binary_dilation(changed) & ~changed & ~scipy.ndimage.binary_dilation(before, iterations=2)
    around = before & ~scipy.ndimage.binary_erosion(before)
    if not along.any() or not around.any() or np.median(edges[along]) < _MIN_ADDED_STRENGTH * np.median(edges[around]):
        return None
    return np.asarray(changed.repeat(2, axis=0).repeat(2, axis=1).repeat(2, axis=2))


def _find_part_behind_neck(within: _CropContext, body: BodyPrediction, step: Array) -> Mask | None:
    """Find the part of a body that holds a step and lies behind a neck, seen from the positive points; else None."""
    whole = body.logits > 0.0
    if not whole.any():
        return None
    box = scipy.ndimage.find_objects(whole.astype(np.int8))[0]
    before, changed = whole[box], np.zeros_like(whole)
    depth = scipy.ndimage.distance_transform_edt(np.pad(before, 1))[1:-1, 1:-1, 1:-1]
    first, last = np.array([side.start for side in box]), np.array(before.shape) - 1
    inner = tuple(np.clip(np.rint(within.positive) - first, 0, last).astype(np.int64).T)
    outer = tuple(np.clip(np.rint(step) - first, 0, last).astype(np.int64))
    for radius in range(1, _MAX_NECK_RADIUS + 1):
        parts, _ = scipy.ndimage.label(depth > radius)
        held = np.setdiff1d(parts[inner], 0)
        if not len(held):
            return None
        if parts[outer] in held:
            continue
        kept = scipy.ndimage.distance_transform_edt(~np.isin(parts, held)) <= radius + 1.0
        rest, _ = scipy.ndimage.label(before & ~kept, np.ones((3, 3, 3)))
        if rest[outer]:
            changed[box] = rest == rest[outer]
            return changed
    return None


def _clipped_logit(seen: Single) -> Single:
    return np.clip(scipy.special.logit(seen), -MAX_LOGIT, MAX_LOGIT)


def _average_blocks(values: Single, side: int) -> Single:
    """Average blocks of steps."""
    for _ in range(3):
        values = np.moveaxis(np.sum([values[k::side] for k in range(side)], axis=0), 0, -1)
    return values / np.float32(side**3)


def _fit_likelihood_ratio(grays: Single, inside: Single) -> Single:
    """Fit the log likelihood ratio of gray levels, inside to outside, by normal distributions around each block.

    Returns the factors of the powers 0, 1 and 2 of the gray level.
    """
    rule: Single = np.zeros((3, *[len(grays) // 2] * 3), np.float32)
    for weight, sign in ((inside, -0.5), (1.0 - inside, 0.5)):
        blurred = [
            scipy.ndimage.gaussian_filter(
                _average_blocks(weight * part, 2), _INTENSITY_SIGMA / _INTENSITY_BLOCK, truncate=2.5
            )
            for part in (1.0, grays, np.square(grays))
        ]
        few = [_EMPTY_SIDE_WEIGHT * part.mean() / max(blurred[0].mean(), 1e-6) for part in blurred]
        total, first, second = (part + some for part, some in zip(blurred, few, strict=True))
        mean = first / total
        variance = np.maximum(second / total - np.square(mean), 0.0) + DEVIATION_OFFSET**2
        rule += np.float32(sign) * np.stack(
            [np.square(mean) / variance + np.log(variance), -2.0 * mean / variance, 1.0 / variance]
        )
    return rule


def _evaluate_likelihood_ratio(grays: Single, rule: Single, times: int) -> Single:
    """Evaluate the log likelihood ratio of gray levels by a rule that is `times` coarser."""
    line = (np.arange(len(grays)) + 0.5) / times - 0.5
    level, slope, bend = (resample_with_tent(part, [line] * 3, (1.0, 1.0, 1.0)) for part in rule)
    return np.clip(level + grays * (slope + grays * bend), -_MAX_INTENSITY_LOGIT, _MAX_INTENSITY_LOGIT)
