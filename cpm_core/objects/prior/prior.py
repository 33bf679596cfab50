"""Predictions in an image: the probability of each pixel to lie in the object that a prompt means.

The network sees square crops: first crops of several sizes around the prompt, ranked by the overlaps that it predicts;
then a crop around the answer so far.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy

from cpm_core.numerics.grids import true_bounds
from cpm_core.numerics.types import Array, Extent, Index, Mask, Numbers, Single, record
from cpm_core.objects.prior.network import Network, trained
from cpm_core.objects.prior.windows import (
    ANSWER_MARGIN,
    CROP_SIZE_RATIO,
    INSIDE_PROBABILITY,
    MAX_RELATIVE_SIDE,
    MIN_ANSWER_SIDE,
    MIN_FIRST_SIDE,
    Views,
    Window,
    holding,
)

_MIN_CROP_REFINEMENTS = 2
"""Number of crops around answers that refine a previous mask."""

_MAX_CROP_REFINEMENTS = 6
"""Largest number of crops around answers, while these reach the rim of their crop."""

_CROP_RIM_WIDTH = 2.0
"""Width of the rim of a crop [px of the crop]."""


_AREA_PENALTY = 0.2
"""Overlap that counts as much as a factor of e between the area of an answer and those of other objects."""

_MAX_DRAWN_RATIO = 40
"""Area of an object, in areas of what has been drawn in it, above which larger objects are less likely.

None of the objects that people outlined was 20 times as large as a disk of half the radius of its largest disk.
"""

_SAME_OBJECT_IOU = 0.7
"""Overlap of the answers to two crops above which they mean the same object."""

_MAX_PREDICTIONS = 4
"""Largest number of objects that one prompt may mean."""

_NO_AREAS = np.empty(0)

_POINT_FADING = 6.0
"""Distance over which the influence of a point fades [px of the crop]."""


@record
class Prompt:
    """The input of a user on an object.

    Attributes
    ----------
    inside, outside : ndarray of int64, shape (M, 2) and (K, 2)
        Pixels of positive and of negative points.
    drawn : ndarray of bool, shape (H, W), optional
        What has been drawn in it, or across its boundary, such as a disk.
    box : tuple of float, optional
        First and last row, first and last column of a box around it [px].
    former : ndarray of bool, shape (H, W), optional
        The previous mask that it corrects.
    """

    inside: Index
    outside: Index = field(default_factory=lambda: np.empty((0, 2), np.int64))
    drawn: Mask | None = None
    box: tuple[float, float, float, float] | None = None
    former: Mask | None = None

    @property
    def places_alone(self) -> bool:
        """Whether there are only positive points."""
        return not len(self.outside) and self.drawn is None and self.box is None and self.former is None


class Answer(NamedTuple):
    """Answer of the network in a crop.

    Attributes
    ----------
    window : Window
        The crop.
    seen : ndarray of float32, shape (SIDE, SIDE)
        Probability of each of its pixels to lie in the object.
    overlap : float
        Overlap with the object that the network predicts.
    """

    window: Window
    seen: Single
    overlap: float

    def any(self) -> bool:
        """Return whether any pixel is more likely in the object than not."""
        return bool((self.seen > INSIDE_PROBABILITY).any())

    @property
    def places(self) -> Array:
        """First and last row and column of the object in the image, shape (2, 2)."""
        on = true_bounds(self.seen > INSIDE_PROBABILITY)
        return np.stack([line[on[:, axis]] for axis, line in enumerate(self.window.lines)], axis=1)

    def touches(self, shape: Extent) -> bool:
        """Return whether the object reaches the rim of the crop inside an image of this shape."""
        near = _CROP_RIM_WIDTH * self.window.scale
        first, last = np.array([line[[0, -1]] for line in self.window.lines]).T
        low, high = self.places
        border = np.array(shape) - 1
        return bool(((low > 0) & (low <= first + near)).any() or ((high < border) & (high >= last - near)).any())

    def promise(self, areas: Array, drawn: Mask | None) -> float:
        """Compute the rank of the answer among those of other crops.

        `areas`, shape (N,) [px²], are those of other objects, and `drawn`, shape (H, W), is what has been drawn.
        """
        area = np.log(max(np.count_nonzero(self.seen > INSIDE_PROBABILITY) * self.window.scale**2, 1.0))
        off = float(np.abs(np.log(np.maximum(areas, 1.0)) - area).min()) if len(areas) else 0.0
        if drawn is not None:
            off += max(float(area - np.log(_MAX_DRAWN_RATIO * max(int(np.count_nonzero(drawn)), 1))), 0.0)
        return self.overlap - _AREA_PENALTY * off

    @property
    def clarity(self) -> float:
        """Overlap with the object that is expected from its probabilities, pixel by pixel."""
        likely = self.seen > INSIDE_PROBABILITY
        return float(self.seen[likely].sum()) / max(float(np.count_nonzero(likely) + self.seen[~likely].sum()), 1.0)

    def agreement(self, other: Answer) -> float:
        """Compute the overlap with the answer in another crop, as sampled in the larger one of the two."""
        small, large = (self, other) if self.window.side <= other.window.side else (other, self)
        return _overlap(large.seen, large.window.of_window(small.window, small.seen))


class Likely(NamedTuple):
    """A predicted object, with features of its confidence.

    Attributes
    ----------
    mask : ndarray of bool, shape (H, W)
        Its pixels.
    coarseness : float
        Side of a pixel of the last crop [px].
    overlap, clarity : float
        Overlap with the intended object that the network predicts, and that is expected from its probabilities.
    steadiness, agreement : float
        Overlap of the last answer with the one before, and of the first with the most similar one in another crop.
    """

    mask: Mask
    coarseness: float
    overlap: float
    clarity: float
    steadiness: float
    agreement: float


@record
class Prior:
    """Predictions of the network for prompts on an image.

    Attributes
    ----------
    values : ndarray, shape (H, W) or (H, W, 3)
        Gray levels, or colors.
    network : Network
        The network.
    grays : tuple of float, optional
        As of `Views`.
    """

    values: Numbers
    network: Network = field(default_factory=trained)
    grays: tuple[float, ...] = ()

    def objects_of(self, prompt: Prompt, areas: Array = _NO_AREAS) -> Iterator[Likely]:
        """Predict the objects that a prompt may mean, the most likely one first.

        Parameters
        ----------
        prompt : Prompt
            The prompt.
        areas : ndarray, shape (N,)
            Areas of other objects of the image, to which it may be similar [px²].
        """
        if prompt.former is not None and prompt.former.any():
            yield self._refined(
                self._answer(_around(true_bounds(prompt.former), prompt), prompt, None), prompt, 1.0, _MIN_CROP_REFINEMENTS
            )
            return
        answers = [self._answer(window, prompt, None) for window in self._first_windows(prompt)]
        answers.sort(key=lambda answer: -answer.promise(areas, prompt.drawn))
        distinct: list[Answer] = []
        for answer in answers:
            if distinct and (not answer.any() or any(answer.agreement(one) > _SAME_OBJECT_IOU for one in distinct)):
                continue
            distinct.append(answer)
            others = [one for one in answers if one is not answer]
            agreement = max((answer.agreement(other) for other in others), default=1.0)
            yield self._refined(answer, prompt, agreement, 0)
            if len(distinct) == _MAX_PREDICTIONS:
                return

    def judged(self, mask: Mask, inside: Index) -> Likely:
        """Evaluate an object, shape (H, W), that was found otherwise and holds pixels, shape (M, 2), by the network."""
        prompt = Prompt(inside, former=mask)
        answer = self._answer(_around(true_bounds(mask), prompt), prompt, None)
        return self._likely(answer, 1.0, answer.window.of(mask))

    def _refined(self, answer: Answer, prompt: Prompt, agreement: float, rounds: int) -> Likely:
        """Refine a prediction by further crops around its answer."""
        shape, before = self.values.shape[:2], answer
        while (
            rounds < _MAX_CROP_REFINEMENTS
            and answer.any()
            and (rounds < _MIN_CROP_REFINEMENTS or answer.touches(shape))
        ):
            answer, before = self._answer(_around(answer.places, prompt), prompt, answer), answer
            rounds += 1
        return self._likely(answer, agreement, answer.window.of_window(before.window, before.seen))

    def _likely(self, answer: Answer, agreement: float, before: Single) -> Likely:
        found = np.zeros(self.values.shape[:2], np.bool_)
        box, part = answer.window.back(answer.seen, found.shape)
        found[box] = part > INSIDE_PROBABILITY
        steadiness = _overlap(answer.seen, before)
        return Likely(found, answer.window.scale, answer.overlap, answer.clarity, steadiness, agreement)

    def _first_windows(self, prompt: Prompt) -> Iterator[Window]:
        """Propose crops around a prompt, the smallest first, and one of the whole image."""
        if prompt.box is not None:
            yield _around(np.array(prompt.box).reshape(2, 2).T, prompt)
            return
        shape = np.array(self.values.shape[:2])
        largest = MAX_RELATIVE_SIDE * float(shape.max())
        if prompt.drawn is None or not prompt.drawn.any():
            middle, side = (
                prompt.inside.mean(axis=0),
                max(MIN_FIRST_SIDE, 1.5 * float(np.ptp(prompt.inside, axis=0).max())),
            )
        else:
            place = np.argwhere(prompt.drawn)
            low, high = place.min(axis=0), place.max(axis=0)
            middle, side = 0.5 * (low + high), 1.5 * float((high - low).max()) + 8.0
        while side < largest / np.sqrt(CROP_SIZE_RATIO):
            yield Window(middle, side)
            side *= CROP_SIZE_RATIO
        yield Window(middle, largest)
        yield Window(0.5 * shape, largest)

    def _answer(self, window: Window, prompt: Prompt, former: Answer | None) -> Answer:
        """Predict the object in a crop, given a former answer or the previous mask of the prompt."""
        seen = self._views.through(window)
        inside, outside = (holding(window.steps(each)) for each in (prompt.inside, prompt.outside))
        drawn: Single = np.zeros(seen.shape[1:], np.float32)
        if prompt.drawn is not None:
            drawn = window.of(prompt.drawn)
        elif prompt.box is not None:
            rows, cols = window.lines
            top, bottom, left, right = prompt.box
            drawn = -np.outer((rows >= top) & (rows <= bottom), (cols >= left) & (cols <= right)).astype(np.float32)
        sure = inside if inside.any() else drawn > 0.0
        level = np.median(seen[:, sure], axis=1) if sure.any() else None
        before: Single = np.zeros_like(drawn)
        if former is not None:
            before = window.of_window(former.window, former.seen)
        elif prompt.former is not None:
            before = window.of(prompt.former)
        return Answer(window, *self.network(maps_of(seen, level, inside, outside, drawn, before)))

    @cached_property
    def _views(self) -> Views:
        return Views(self.values, self.grays)


def maps_of(
    seen: Single, level: Array | Single | None, inside: Mask, outside: Mask, drawn: Single, before: Single
) -> Single:
    """Build the input maps of the network for a crop, shape (9, SIDE, SIDE).

    Parameters
    ----------
    seen : ndarray of float32, shape (3, SIDE, SIDE)
        Brightness and two color differences, as `Views.through` samples them.
    level : ndarray, shape (3,), or None
        Their values in the object, where these are known.
    inside, outside : ndarray of bool, shape (SIDE, SIDE)
        Pixels that hold positive and negative points.
    drawn, before : ndarray of float32, shape (SIDE, SIDE)
        What has been drawn, and the previous mask.
    """
    slope = np.hypot(*(scipy.ndimage.sobel(seen[0], axis, mode="mirror") for axis in range(2)))
    like = np.zeros_like(drawn) if level is None else np.exp(-np.abs(seen - level[:, None, None]).sum(axis=0))
    maps = [*seen, 0.5 * slope, like, _nearness(inside), _nearness(outside), drawn, before]
    return np.stack(maps, dtype=np.float32)


def _around(found: Array | Index, prompt: Prompt) -> Window:
    """Crop around an answer, pixels of shape (N, 2), and all points."""
    places = np.concatenate([found, prompt.inside, prompt.outside])
    low, high = places.min(axis=0), places.max(axis=0)
    return Window(0.5 * (low + high), max(ANSWER_MARGIN * float((high - low).max()), MIN_ANSWER_SIDE))


def _overlap(seen: Single, other: Single) -> float:
    """Compute the overlap (intersection over union) of the objects in two probability maps of one crop."""
    one, two = seen > INSIDE_PROBABILITY, other > INSIDE_PROBABILITY
    return float(np.count_nonzero(one & two)) / max(int(np.count_nonzero(one | two)), 1)


def _nearness(on: Mask) -> Single:
    """Encode points as a map that is 1 at each of them and fades around it."""
    if not on.any():
        return np.zeros(on.shape, np.float32)
    return np.asarray(np.exp(-scipy.ndimage.distance_transform_edt(~on) / _POINT_FADING), np.float32)
