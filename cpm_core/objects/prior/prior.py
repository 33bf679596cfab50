"""The prior of an image: the probability of each pixel to lie in the object that a prompt means.

The network looks at square windows. At first at windows of several sizes around what has been given, of which the one
counts whose answer promises the largest overlap; then at one around the answer so far.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy

from cpm_core.numerics.grids import ends
from cpm_core.numerics.types import Array, Extent, Index, Mask, Numbers, Single, record
from cpm_core.objects.prior.network import Network, trained
from cpm_core.objects.prior.windows import Views, Window, holding

_GROWS, _LEAST, _MOST = 1.6, 40.0, 1.1
"""Ratio of the sides of one window to those of the next smaller one; least side around a click [px]; and the largest,
in sides of the image."""

_AROUND, _CLOSEST = 1.35, 24.0
"""Side of a window around an answer, as a multiple of it, and the least one [px]."""

_ROUNDS, _MOST_ROUNDS, _RIM = 2, 6, 2.0
"""Windows around answers; and at most, while they reach within so many pixels of the rim of the window."""

_LIKELY = 0.5
"""Probability above which a pixel is said to lie in the object."""

_UNLIKE = 0.2
"""Overlap that counts as much as a factor of e between the area of an answer and those of other objects."""

_MOST_TIMES = 40
"""Area of an object, in areas of what has been drawn in it, from which it is less likely the larger it is: of objects
that people outlined, none was 20 times as large as a disk of half the radius of the largest one in it."""

_DISTINCT = 0.7
"""Overlap of the answers of two windows from which they mean the same object."""

_MOST_OBJECTS = 4
"""Number of objects that one prompt may mean."""

_NO_AREAS = np.empty(0)

_FADES = 6.0
"""Distance over which a place counts [px of the window]."""


@record
class Prompt:
    """What is known about an object.

    Attributes
    ----------
    inside, outside : ndarray of int64, shape (M, 2) and (K, 2)
        Pixels that lie in it, and that do not.
    drawn : ndarray of bool, shape (H, W), optional
        What has been drawn in it, or across its boundary, such as a disk.
    box : tuple of float, optional
        First and last row, first and last column of a box around it [px].
    former : ndarray of bool, shape (H, W), optional
        The answer that it corrects.
    """

    inside: Index
    outside: Index = field(default_factory=lambda: np.empty((0, 2), np.int64))
    drawn: Mask | None = None
    box: tuple[float, float, float, float] | None = None
    former: Mask | None = None

    @property
    def places_alone(self) -> bool:
        """Whether nothing is known but places inside."""
        return not len(self.outside) and self.drawn is None and self.box is None and self.former is None


class Answer(NamedTuple):
    """What the network makes of a window.

    Attributes
    ----------
    window : Window
        The window.
    seen : ndarray of float32, shape (SIDE, SIDE)
        Probability of each of its pixels to lie in the object.
    overlap : float
        Overlap with the object that the network expects.
    """

    window: Window
    seen: Single
    overlap: float

    def any(self) -> bool:
        """Whether anything is more likely in the object than not."""
        return bool((self.seen > _LIKELY).any())

    @property
    def places(self) -> Array:
        """First and last row and column of the object in the image, shape (2, 2)."""
        on = ends(self.seen > _LIKELY)
        return np.stack([line[on[:, axis]] for axis, line in enumerate(self.window.lines)], axis=1)

    def touches(self, shape: Extent) -> bool:
        """Whether it reaches the rim of the window inside of an image of this shape."""
        near = _RIM * self.window.scale
        first, last = np.array([line[[0, -1]] for line in self.window.lines]).T
        low, high = self.places
        border = np.array(shape) - 1
        return bool(((low > 0) & (low <= first + near)).any() or ((high < border) & (high >= last - near)).any())

    def promise(self, areas: Array, drawn: Mask | None) -> float:
        """What it is worth among those of other windows, given areas of other objects, and what has been drawn."""
        area = np.log(max(np.count_nonzero(self.seen > _LIKELY) * self.window.scale**2, 1.0))
        off = float(np.abs(np.log(np.maximum(areas, 1.0)) - area).min()) if len(areas) else 0.0
        if drawn is not None:
            off += max(float(area - np.log(_MOST_TIMES * max(int(np.count_nonzero(drawn)), 1))), 0.0)
        return self.overlap - _UNLIKE * off

    @property
    def clarity(self) -> float:
        """Overlap with the object that its probabilities promise, pixel by pixel."""
        likely = self.seen > _LIKELY
        return float(self.seen[likely].sum()) / max(float(np.count_nonzero(likely) + self.seen[~likely].sum()), 1.0)

    def agreement(self, other: Answer) -> float:
        """Overlap with the answer to another window, as seen in the larger one of the two."""
        small, large = (self, other) if self.window.side <= other.window.side else (other, self)
        return _overlap(large.seen, large.window.of_window(small.window, small.seen))


class Likely(NamedTuple):
    """An object that a prompt may mean, and what speaks for it.

    Attributes
    ----------
    mask : ndarray of bool, shape (H, W)
        Its pixels.
    coarseness : float
        How many of them, along each axis, one pixel of what the network saw last stands for.
    overlap, clarity : float
        Overlap with what is meant that the network expects, and that its probabilities promise.
    steadiness, agreement : float
        Overlap of the last answer with the one before, and of the first one with the most similar to another window.
    """

    mask: Mask
    coarseness: float
    overlap: float
    clarity: float
    steadiness: float
    agreement: float


@record
class Prior:
    """What the network makes of prompts on an image.

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
        """The objects that a prompt may mean, of each what is more likely in it than not; the most likely one first.

        Parameters
        ----------
        prompt : Prompt
            What is known about the object.
        areas : ndarray, shape (N,)
            Areas of other objects of the image, of which it may be one more [px²].
        """
        if prompt.former is not None and prompt.former.any():
            yield self._refined(self._answer(_around(ends(prompt.former), prompt), prompt, None), prompt, 1.0, _ROUNDS)
            return
        answers = [self._answer(window, prompt, None) for window in self._first_windows(prompt)]
        answers.sort(key=lambda answer: -answer.promise(areas, prompt.drawn))
        distinct: list[Answer] = []
        for answer in answers:
            if distinct and (not answer.any() or any(answer.agreement(one) > _DISTINCT for one in distinct)):
                continue
            distinct.append(answer)
            others = [one for one in answers if one is not answer]
            agreement = max((answer.agreement(other) for other in others), default=1.0)
            yield self._refined(answer, prompt, agreement, 0)
            if len(distinct) == _MOST_OBJECTS:
                return

    def judged(self, mask: Mask, inside: Index) -> Likely:
        """What the network makes of an object, shape (H, W), that has been found otherwise and holds some pixels."""
        prompt = Prompt(inside, former=mask)
        answer = self._answer(_around(ends(mask), prompt), prompt, None)
        return self._likely(answer, 1.0, answer.window.of(mask))

    def _refined(self, answer: Answer, prompt: Prompt, agreement: float, rounds: int) -> Likely:
        """The object of an answer, after further ones to windows around it."""
        shape, before = self.values.shape[:2], answer
        while rounds < _MOST_ROUNDS and answer.any() and (rounds < _ROUNDS or answer.touches(shape)):
            answer, before = self._answer(_around(answer.places, prompt), prompt, answer), answer
            rounds += 1
        return self._likely(answer, agreement, answer.window.of_window(before.window, before.seen))

    def _likely(self, answer: Answer, agreement: float, before: Single) -> Likely:
        found = np.zeros(self.values.shape[:2], np.bool_)
        box, part = answer.window.back(answer.seen, found.shape)
        found[box] = part > _LIKELY
        steadiness = _overlap(answer.seen, before)
        return Likely(found, answer.window.scale, answer.overlap, answer.clarity, steadiness, agreement)

    def _first_windows(self, prompt: Prompt) -> Iterator[Window]:
        """Windows around a prompt, the smallest first, and one of the whole image."""
        if prompt.box is not None:
            yield _around(np.array(prompt.box).reshape(2, 2).T, prompt)
            return
        shape = np.array(self.values.shape[:2])
        largest = _MOST * float(shape.max())
        if prompt.drawn is None or not prompt.drawn.any():
            middle, side = prompt.inside.mean(axis=0), max(_LEAST, 1.5 * float(np.ptp(prompt.inside, axis=0).max()))
        else:
            place = np.argwhere(prompt.drawn)
            low, high = place.min(axis=0), place.max(axis=0)
            middle, side = 0.5 * (low + high), 1.5 * float((high - low).max()) + 8.0
        while side < largest / np.sqrt(_GROWS):
            yield Window(middle, side)
            side *= _GROWS
        yield Window(middle, largest)
        yield Window(0.5 * shape, largest)

    def _answer(self, window: Window, prompt: Prompt, former: Answer | None) -> Answer:
        """What the network makes of a window, after a former answer or that of the prompt."""
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
    """The maps that the network gets of a window.

    Parameters
    ----------
    seen : ndarray of float32, shape (3, SIDE, SIDE)
        Brightness and two differences of colors, as `windows.balanced` makes them.
    level : ndarray, shape (3,), or None
        The same of the object, where it is known.
    inside, outside : ndarray of bool, shape (SIDE, SIDE)
        Pixels that hold places inside and outside.
    drawn, before : ndarray of float32, shape (SIDE, SIDE)
        What has been drawn, and the answer before.
    """
    slope = np.hypot(*(scipy.ndimage.sobel(seen[0], axis, mode="mirror") for axis in range(2)))
    like = np.zeros_like(drawn) if level is None else np.exp(-np.abs(seen - level[:, None, None]).sum(axis=0))
    maps = [*seen, 0.5 * slope, like, _nearness(inside), _nearness(outside), drawn, before]
    return np.stack(maps, dtype=np.float32)


def _around(found: Array | Index, prompt: Prompt) -> Window:
    """A window around an answer, pixels of shape (N, 2), and what has been clicked."""
    places = np.concatenate([found, prompt.inside, prompt.outside])
    low, high = places.min(axis=0), places.max(axis=0)
    return Window(0.5 * (low + high), max(_AROUND * float((high - low).max()), _CLOSEST))


def _overlap(seen: Single, other: Single) -> float:
    """Overlap (intersection over union) of what is likely by two maps of one window."""
    one, two = seen > _LIKELY, other > _LIKELY
    return float(np.count_nonzero(one & two)) / max(int(np.count_nonzero(one | two)), 1)


def _nearness(on: Mask) -> Single:
    """How near each pixel is to those that are on, 0 to 1."""
    if not on.any():
        return np.zeros(on.shape, np.float32)
    return np.asarray(np.exp(-scipy.ndimage.distance_transform_edt(~on) / _FADES), np.float32)
