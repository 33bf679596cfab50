"""Predictions in an image: the probability of each pixel to lie in the object that a prompt means.

The network sees square crops: first crops of several sizes around the prompt, ranked by the overlaps that it predicts;
then a crop around the answer so far.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import field, replace
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
import scipy

from cpm_core.numerics.grids import Window, compute_iou, true_bounds
from cpm_core.numerics.parallel import map_in_parallel
from cpm_core.numerics.types import NO_PIXELS, Array, Extent, Index, Mask, Numbers, Single, record
from cpm_core.objects.prior.crops import (
    CROP_SIZE_RATIO,
    INSIDE_PROBABILITY,
    MAX_RELATIVE_SIDE,
    MIN_FIRST_SIDE,
    Crop2D,
    ImageSampler,
    mark_points,
)
from cpm_core.objects.prior.network import Network, load_trained_network

_MIN_CROP_REFINEMENTS = 2
"""Number of crops around answers that refine a previous mask."""

_MAX_CROP_REFINEMENTS = 6
"""Largest number of crops around answers, while these reach the rim of their crop."""

_CORRECTION_ROUNDS = 3
"""Number of crops around a correction; the first shows only what a crop around the object has found of it."""

_MAX_CORRECTION_SHARE = 0.6
"""Side of a crop around a correction, as a share of that around the object, up to which it shows more."""

_CROP_RIM_WIDTH = 2.0
"""Width of the rim of a crop [px of the crop]."""

_MIN_CUT_SHARE = 0.25
"""Share of a side of a crop that an answer covers from which the side has cut it.

None of 266 first answers to clicks in objects that people outlined covered any of its sides.
"""


AREA_PENALTY = 0.2
"""Overlap that counts as much as a factor of e between the area of an answer and the one that is known."""

_MAX_DRAWN_RATIO = 40
"""Area of an object, in areas of what has been drawn in it, above which larger objects are less likely.

None of the objects that people outlined was 20 times as large as a disk of half the radius of its largest disk.
"""

_MAX_IMAGE_SHARE = 0.5
"""Share of the image above which an answer to points is rather what surrounds an object than the object."""

SAME_OBJECT_IOU = 0.7
"""Overlap of the answers to two crops above which they mean the same object."""

_CLOSE_LIKELIHOOD = 0.05
"""Difference in predicted overlaps up to which answers are ranked once more when they are refined.

For 380 first clicks in objects of 44 kinds that people outlined, the answer overlaps by 0.645 with it, by 0.635 with
none, and by 0.624 with twice as much.
"""

MAX_PREDICTIONS = 6
"""Largest number of objects that one prompt may mean."""

_POINT_FADING = 6.0
"""Distance over which the influence of a point fades [px of the crop]."""


@record
class Prompt:
    """The input of a user on an object.

    Attributes
    ----------
    positive, negative : ndarray of int64, shape (M, 2) and (K, 2)
        Pixels of positive and of negative points.
    drawn_area : ndarray of bool, shape (H, W), optional
        What has been drawn in it, or across its boundary, such as a disk.
    box : tuple of float, optional
        First and last row, first and last column of a box around it [px].
    previous_mask : ndarray of bool, shape (H, W), optional
        The previous mask that it corrects.
    """

    positive: Index
    negative: Index = field(default_factory=lambda: NO_PIXELS)
    drawn_area: Mask | None = None
    box: tuple[float, float, float, float] | None = None
    previous_mask: Mask | None = None

    def find_contradictions(self, mask: Mask) -> Index:
        """Find the points that contradict a mask, shape (H, W), as shape (N, 2)."""
        missing, surplus = ~mask[tuple(self.positive.T)], mask[tuple(self.negative.T)]
        return np.concatenate([self.positive[missing], self.negative[surplus]])

    @property
    def point_count(self) -> int:
        """Number of points; what has been drawn counts as one."""
        return len(self.positive) + len(self.negative) + (self.drawn_area is not None)

    @property
    def has_only_positive(self) -> bool:
        """Whether there are only positive points."""
        return not len(self.negative) and self.drawn_area is None and self.box is None and self.previous_mask is None


class CropPrediction(NamedTuple):
    """Answer of the network in a crop.

    Attributes
    ----------
    crop : Window
        The crop.
    probability : ndarray of float32, shape (CROP_SIDE, CROP_SIDE)
        Probability of each of its pixels to lie in the object.
    predicted_iou : float
        Overlap with the object that the network predicts.
    """

    crop: Crop2D
    probability: Single
    predicted_iou: float

    def has_object(self) -> bool:
        """Return whether any pixel is more likely in the object than not."""
        return bool((self.probability > INSIDE_PROBABILITY).any())

    @property
    def object_bounds(self) -> Array:
        """First and last row and column of the object in the image, shape (2, 2)."""
        on = true_bounds(self.probability > INSIDE_PROBABILITY)
        return np.stack([line[on[:, axis]] for axis, line in enumerate(self.crop.axis_positions)], axis=1)

    def reaches_rim(self, shape: Extent) -> bool:
        """Return whether the object reaches the rim of the crop inside an image of this shape."""
        near = _CROP_RIM_WIDTH * self.crop.step_size
        first, last = np.array([line[[0, -1]] for line in self.crop.axis_positions]).T
        low, high = self.object_bounds
        border = np.array(shape) - 1
        return bool(((low > 0) & (low <= first + near)).any() or ((high < border) & (high >= last - near)).any())

    def is_cut(self, shape: Extent) -> bool:
        """Return whether a side of the crop inside an image of this shape has cut the object straight."""
        inside = self.probability > INSIDE_PROBABILITY
        for axis, (line, count) in enumerate(zip(self.crop.axis_positions, shape, strict=True)):
            shares = inside.take([0, -1], axis).mean(axis=1 - axis)
            if (shares[[line[0] > 0.0, line[-1] < count - 1.0]] >= _MIN_CUT_SHARE).any():
                return True
        return False

    def compute_penalty(self, known_area: float | None, drawn: Mask | None) -> float:
        """Compute how much the size of the answer speaks against it, as a difference in overlap.

        `known_area` [px²] is that of the object, and `drawn`, shape (H, W), is what has been drawn.
        """
        area = np.log(max(np.count_nonzero(self.probability > INSIDE_PROBABILITY) * self.crop.step_size**2, 1.0))
        off = 0.0 if known_area is None else abs(float(np.log(max(known_area, 1.0)) - area))
        if drawn is not None:
            off += max(float(area - np.log(_MAX_DRAWN_RATIO * max(int(np.count_nonzero(drawn)), 1))), 0.0)
        return AREA_PENALTY * off

    @property
    def mean_certainty(self) -> float:
        """Overlap with the object that is expected from its probabilities, pixel by pixel."""
        likely = self.probability > INSIDE_PROBABILITY
        return float(self.probability[likely].sum()) / max(
            float(np.count_nonzero(likely) + self.probability[~likely].sum()), 1.0
        )

    def compute_iou_with(self, other: CropPrediction) -> float:
        """Compute the overlap with the answer in another crop, as sampled in the larger one of the two."""
        small, large = (self, other) if self.crop.side <= other.crop.side else (other, self)
        return _compute_probability_iou(large.probability, large.crop.sample_from(small.crop, small.probability))


class Prediction(NamedTuple):
    """A predicted object, with features of its confidence.

    Attributes
    ----------
    mask : ndarray of bool, shape (H, W)
        Its pixels.
    downsampling : float
        Side of a pixel of the last crop [px].
    predicted_iou, mean_certainty : float
        Overlap with the intended object that the network predicts, and that is expected from its probabilities.
    iou_to_previous, iou_to_other_crop : float
        Overlap of the last answer with the one before, and of the first with the most similar one in another crop.
    """

    mask: Mask
    downsampling: float
    predicted_iou: float
    mean_certainty: float
    iou_to_previous: float
    iou_to_other_crop: float


class Predictor(Protocol):
    """What answers prompts on an image: the network, or a larger model."""

    def predict_objects(self, prompt: Prompt, known_area: float | None = None) -> Iterator[Prediction]:
        """Predict the objects that a prompt may mean, the most likely one first.

        What covers most of the image comes after smaller objects that hold the points, if there are only positive ones.

        Parameters
        ----------
        prompt : Prompt
            The prompt.
        known_area : float, optional
            Area that the object has, about [px²].
        """
        ...


@record
class ObjectPredictor:
    """Predictions of the network for prompts on an image.

    Attributes
    ----------
    values : ndarray, shape (H, W) or (H, W, 3)
        Gray levels, or colors.
    network : Network
        The network.
    gray_range : tuple of float, optional
        As of `ImageSampler`.
    """

    values: Numbers
    network: Network = field(default_factory=load_trained_network)
    gray_range: tuple[float, ...] = ()

    def predict_objects(self, prompt: Prompt, known_area: float | None = None) -> Iterator[Prediction]:
        """Predict the objects that a prompt may mean, as `Predictor.predict_objects`; last those cut by their crop."""
        if prompt.previous_mask is not None and prompt.previous_mask.any():
            answer = self._predict_crop(_crop_around(true_bounds(prompt.previous_mask), prompt), prompt)
            found, _ = self._refine_prediction(answer, prompt, 1.0, _MIN_CROP_REFINEMENTS)
            yield self._refine_corrections(found, prompt, prompt.previous_mask)
            return
        yield from put_surroundings_last(self._rank_predictions(prompt, known_area), prompt)

    def _rank_predictions(self, prompt: Prompt, known_area: float | None) -> Iterator[Prediction]:
        """Predict different objects that a prompt may mean, the likeliest first, and last those cut.

        Those that are about as likely are ranked once more when they are refined, then by their certainty as well:
        before, one of several answers in a crop may be certain only because it differs from the others.
        """

        def likelihood(answer: CropPrediction) -> float:
            return answer.predicted_iou - answer.compute_penalty(known_area, prompt.drawn_area)

        def score(answer: CropPrediction) -> float:
            return likelihood(answer) + 0.5 * (answer.mean_certainty - answer.predicted_iou)

        def refine(answer: CropPrediction) -> tuple[Prediction, CropPrediction]:
            others = (one for one in answers if one.crop is not answer.crop)
            agreement = max((answer.compute_iou_with(one) for one in others), default=1.0)
            return self._refine_prediction(answer, prompt, agreement, 0)

        crops = map_in_parallel(lambda window: self._predict_in_crop(window, prompt), [*self._propose_crops(prompt)])
        answers = sorted(itertools.chain.from_iterable(crops), key=likelihood, reverse=True)
        distinct = _choose_distinct(answers)
        close = sum(likelihood(answer) > likelihood(distinct[0]) - _CLOSE_LIKELIHOOD for answer in distinct)
        cut: list[Prediction] = []
        for group in (distinct[:close], *([answer] for answer in distinct[close:])):
            refined: list[tuple[float, Prediction]] = []
            for found, last in map_in_parallel(refine, group):
                if last.is_cut(self.values.shape[:2]):
                    cut.append(found)
                else:
                    refined.append((score(last), found))
            yield from (found for _, found in sorted(refined, key=lambda one: -one[0]))
        yield from cut

    def predict_near(self, pixel: Index, window: Window) -> Iterator[Prediction]:
        """Predict the objects that a pixel may mean, in a crop around a window; none that the crop cuts."""
        prompt = Prompt(pixel[None])
        low, high = np.array([[side.start, side.stop - 1] for side in window]).T
        for answer in self._predict_in_crop(Crop2D.from_bounds(low, high), prompt):
            if answer.has_object() and not answer.is_cut(self.values.shape[:2]):
                yield self._build_prediction(answer, 1.0, answer.probability)

    def evaluate_mask(self, mask: Mask, inside: Index) -> Prediction:
        """Evaluate an object, shape (H, W), that was found otherwise and holds pixels, shape (M, 2), by the network."""
        prompt = Prompt(inside, previous_mask=mask)
        answer = self._predict_crop(_crop_around(true_bounds(mask), prompt), prompt)
        return self._build_prediction(answer, 1.0, answer.crop.sample_map(mask))

    def _refine_prediction(
        self, answer: CropPrediction, prompt: Prompt, agreement: float, rounds: int
    ) -> tuple[Prediction, CropPrediction]:
        """Refine a prediction by further crops around its answer; return the answer in the last of them, too."""
        shape, before = self.values.shape[:2], answer
        while (
            rounds < _MAX_CROP_REFINEMENTS
            and answer.has_object()
            and (rounds < _MIN_CROP_REFINEMENTS or answer.reaches_rim(shape))
        ):
            answer, before = self._predict_crop(_crop_around(answer.object_bounds, prompt), prompt, answer), answer
            rounds += 1
        steady = answer.crop.sample_from(before.crop, before.probability)
        return self._build_prediction(answer, agreement, steady), answer

    def _refine_corrections(self, found: Prediction, prompt: Prompt, previous: Mask) -> Prediction:
        """Refine what points that contradict a previous mask, shape (H, W), have changed, each in crops of its own.

        A small change to a large object is a few steps wide in a crop around all of it.
        """
        mask = found.mask
        for place in prompt.find_contradictions(previous).repeat(_CORRECTION_ROUNDS, axis=0):
            parts, _ = scipy.ndimage.label(mask != previous)
            number = parts[tuple(place)]
            low, high = true_bounds(parts == number) if number else (place, place)
            crop = Crop2D.from_bounds(low, high)
            if crop.step_size > _MAX_CORRECTION_SHARE * found.downsampling:
                continue
            answer = self._predict_crop(crop, replace(prompt, previous_mask=mask))
            box, part = crop.map_back(answer.probability, mask.shape)
            mask = mask.copy()
            mask[box] = part > INSIDE_PROBABILITY
        return found._replace(mask=mask)

    def _build_prediction(self, answer: CropPrediction, agreement: float, before: Single) -> Prediction:
        found = np.zeros(self.values.shape[:2], np.bool_)
        box, part = answer.crop.map_back(answer.probability, found.shape)
        found[box] = part > INSIDE_PROBABILITY
        steadiness = _compute_probability_iou(answer.probability, before)
        return Prediction(
            found, answer.crop.step_size, answer.predicted_iou, answer.mean_certainty, steadiness, agreement
        )

    def _propose_crops(self, prompt: Prompt) -> Iterator[Crop2D]:
        """Propose crops around a prompt, the smallest first, and one of the whole image."""
        if prompt.box is not None:
            yield _crop_around(np.array(prompt.box).reshape(2, 2).T, prompt)
            return
        shape = np.array(self.values.shape[:2])
        largest = MAX_RELATIVE_SIDE * float(shape.max())
        if prompt.drawn_area is None or not prompt.drawn_area.any():
            middle = prompt.positive.mean(axis=0)
            side = max(MIN_FIRST_SIDE, 1.5 * float(np.ptp(prompt.positive, axis=0).max()))
        else:
            low, high = true_bounds(prompt.drawn_area)
            middle, side = 0.5 * (low + high), 1.5 * float((high - low).max()) + 8.0
        while side < largest / np.sqrt(CROP_SIZE_RATIO):
            yield Crop2D(middle, side)
            side *= CROP_SIZE_RATIO
        yield Crop2D(middle, largest)
        yield Crop2D(0.5 * shape, largest)

    def _predict_crop(self, window: Crop2D, prompt: Prompt, former: CropPrediction | None = None) -> CropPrediction:
        """Predict the likeliest object in a crop, given an earlier answer or the previous mask of the prompt."""
        return self._predict_in_crop(window, prompt, former)[0]

    def _predict_in_crop(
        self, window: Crop2D, prompt: Prompt, former: CropPrediction | None = None
    ) -> list[CropPrediction]:
        """Predict the objects that a prompt may mean in a crop, the likeliest one first."""
        seen = self._sampler.sample_crop(window)
        inside, outside = (mark_points(window.to_crop_steps(each)) for each in (prompt.positive, prompt.negative))
        drawn: Single = np.zeros(seen.shape[1:], np.float32)
        if prompt.drawn_area is not None:
            drawn = window.sample_map(prompt.drawn_area)
        elif prompt.box is not None:
            rows, cols = window.axis_positions
            top, bottom, left, right = prompt.box
            drawn = -np.outer((rows >= top) & (rows <= bottom), (cols >= left) & (cols <= right)).astype(np.float32)
        sure = inside if inside.any() else drawn > 0.0
        level = np.median(seen[:, sure], axis=1) if sure.any() else None
        before: Single = np.zeros_like(drawn)
        if former is not None:
            before = window.sample_from(former.crop, former.probability)
        elif prompt.previous_mask is not None:
            before = window.sample_map(prompt.previous_mask)
        probabilities, overlaps = self.network(build_input_maps(seen, level, inside, outside, drawn, before))
        return [CropPrediction(window, *answer) for answer in zip(probabilities, overlaps.tolist(), strict=True)]

    @cached_property
    def _sampler(self) -> ImageSampler:
        return ImageSampler(self.values, self.gray_range)


def _choose_distinct(answers: Iterable[CropPrediction]) -> list[CropPrediction]:
    """Choose the first answers that differ from one another; the first of all may be empty."""
    distinct: list[CropPrediction] = []
    for answer in answers:
        if not distinct or (
            answer.has_object() and all(answer.compute_iou_with(one) <= SAME_OBJECT_IOU for one in distinct)
        ):
            distinct.append(answer)
        if len(distinct) == MAX_PREDICTIONS:
            break
    return distinct


def put_surroundings_last(ranked: Iterable[Prediction], prompt: Prompt) -> Iterator[Prediction]:
    """Yield predictions in their order, except that what surrounds an object comes after it."""
    surrounding: list[Prediction] = []
    for found in ranked:
        is_large = prompt.has_only_positive and found.mask.mean() > _MAX_IMAGE_SHARE
        if is_large or (surrounding and not found.mask[tuple(prompt.positive.T)].all()):
            surrounding.append(found)
        else:
            yield found
    yield from surrounding


def build_input_maps(
    channels: Single, level: Array | Single | None, inside: Mask, outside: Mask, drawn: Single, previous: Single
) -> Single:
    """Build the input maps of the network for a crop, shape (9, CROP_SIDE, CROP_SIDE).

    Parameters
    ----------
    channels : ndarray of float32, shape (3, CROP_SIDE, CROP_SIDE)
        Brightness and two color differences, as `ImageSampler.sample_crop` samples them.
    level : ndarray, shape (3,), or None
        Their values in the object, where these are known.
    inside, outside : ndarray of bool, shape (CROP_SIDE, CROP_SIDE)
        Pixels that hold positive and negative points.
    drawn, previous : ndarray of float32, shape (CROP_SIDE, CROP_SIDE)
        What has been drawn, and the previous mask.
    """
    slope = np.hypot(*(scipy.ndimage.sobel(channels[0], axis, mode="mirror") for axis in range(2)))
    like = np.zeros_like(drawn) if level is None else np.exp(-np.abs(channels - level[:, None, None]).sum(axis=0))
    maps = [*channels, 0.5 * slope, like, _encode_points(inside), _encode_points(outside), drawn, previous]
    return np.stack(maps, dtype=np.float32)


def _crop_around(found: Array | Index, prompt: Prompt) -> Crop2D:
    """Crop around an answer, pixels of shape (N, 2), and all points."""
    places = np.concatenate([found, prompt.positive, prompt.negative])
    return Crop2D.from_bounds(places.min(axis=0), places.max(axis=0))


def _compute_probability_iou(seen: Single, other: Single) -> float:
    """Compute the overlap (intersection over union) of the objects in two probability maps of one crop."""
    return compute_iou(seen > INSIDE_PROBABILITY, other > INSIDE_PROBABILITY)


def _encode_points(on: Mask) -> Single:
    """Encode points as a map that is 1 at each of them and fades around it."""
    if not on.any():
        return np.zeros(on.shape, np.float32)
    return np.asarray(np.exp(-scipy.ndimage.distance_transform_edt(~on) / _POINT_FADING), np.float32)
