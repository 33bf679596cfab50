"""The prior of an image: the probability of each pixel to lie in the object that a prompt means.

The network looks at square windows. At first at windows of several sizes around what has been given, of which the one
counts whose answer promises the largest overlap; then at one around the answer so far.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.numerics.types import Array, Index, Mask, Single
from cpm_core.objects.prior.network import Network, trained
from cpm_core.objects.prior.windows import Views, Window

_GROWS, _LEAST, _MOST = 1.6, 40.0, 1.1
"""Ratio of the sides of one window to those of the next smaller one; least side around a click [px]; and the largest,
in sides of the image."""

_AROUND, _CLOSEST = 1.35, 24.0
"""Side of a window around an answer, as a multiple of it, and the least one [px]."""

_LARGER = 0.1
"""Overlap that a window may promise less when its answer is larger by a factor of e: what the smallest windows show
lies in an object more often than it is one."""

_UNLIKE = 0.2
"""Overlap that counts as much as a factor of e between the area of an answer and those of other objects."""

_NO_AREAS = np.empty(0)

_FADES = 6.0
"""Distance over which a place counts [px of the window]."""


@dataclass(frozen=True, eq=False)
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


@dataclass(frozen=True, eq=False)
class Prior:
    """What the network makes of prompts on an image.

    Attributes
    ----------
    values : ndarray, shape (H, W) or (H, W, 3)
        Gray levels, or colors.
    network : Network
        The network.
    """

    values: NDArray[Any]
    network: Network = field(default_factory=trained)

    def probability(self, prompt: Prompt, areas: Array = _NO_AREAS) -> Single:
        """Probability of each pixel that it lies in the object.

        Parameters
        ----------
        prompt : Prompt
            What is known about the object.
        areas : ndarray, shape (N,)
            Areas of other objects of the image, of which it may be one more [px²].

        Returns
        -------
        ndarray of float32, shape (H, W)
            0 beyond the window that has been looked at last.
        """
        shape = self.values.shape[:2]
        former = None if prompt.former is None or not prompt.former.any() else prompt.former.astype(np.float32)
        rounds = 1
        if former is None:
            if prompt.box is not None:
                windows = [_around(np.array(prompt.box).reshape(2, 2).T, np.empty((0, 2)))]
            else:
                windows = list(self._first_windows(prompt))
            answers = [(window, *self._answer(window, prompt, None)) for window in windows]
            window, seen, _ = max(answers, key=lambda answer: _promise(*answer, areas))
            former = _spread(window, seen, shape)
            rounds = 2
        given = np.concatenate([prompt.inside, prompt.outside])
        for _ in range(rounds):
            found = np.argwhere(former > 0.5) if former.any() else given[:0]
            if not len(found):
                break
            window = _around(found, given)
            former = _spread(window, self._answer(window, prompt, former)[0], shape)
        return former

    def _first_windows(self, prompt: Prompt) -> Iterator[Window]:
        """Windows around a prompt, the smallest first, and one of the whole image."""
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

    def _answer(self, window: Window, prompt: Prompt, former: Single | None) -> tuple[Single, float]:
        """Probability in a window, shape (size, size), and its estimated overlap."""
        seen = self._views.through(window)
        slope = np.hypot(*(scipy.ndimage.sobel(seen[0], axis, mode="mirror") for axis in range(2)))
        inside, outside = window.holding(prompt.inside), window.holding(prompt.outside)
        drawn = np.zeros(seen.shape[1:], np.float32)
        if prompt.drawn is not None:
            drawn = window.of(prompt.drawn.astype(np.float32))
        elif prompt.box is not None:
            rows, cols = window.lines
            top, bottom, left, right = prompt.box
            drawn = -np.outer((rows >= top) & (rows <= bottom), (cols >= left) & (cols <= right)).astype(np.float32)
        sure = inside if inside.any() else drawn > 0.0
        like = np.zeros_like(drawn)
        if sure.any():
            like = np.exp(-np.abs(seen - np.median(seen[:, sure], axis=1)[:, None, None]).sum(axis=0))
        before = np.zeros_like(drawn) if former is None else window.of(former)
        maps = [*seen, 0.5 * slope, like, _nearness(inside), _nearness(outside), drawn, before]
        return self.network(np.stack(maps, dtype=np.float32))

    @cached_property
    def _views(self) -> Views:
        return Views(self.values)


def _promise(window: Window, seen: Single, overlap: float, areas: Array) -> float:
    """What the answer in a window is worth."""
    size = float(np.log(max(np.count_nonzero(seen > 0.5) * window.scale**2, 1.0)))
    if not len(areas):
        return overlap + _LARGER * size
    return overlap - _UNLIKE * float(np.abs(np.log(areas) - size).min())


def _around(found: Array | Index, given: Array | Index) -> Window:
    """A window around an answer and what has been given, pixels of shape (N, 2) and (M, 2)."""
    places = np.concatenate([found.min(axis=0)[None], found.max(axis=0)[None], given])
    low, high = places.min(axis=0), places.max(axis=0)
    return Window(0.5 * (low + high), max(_AROUND * float((high - low).max()), _CLOSEST))


def _spread(window: Window, seen: Single, shape: tuple[int, ...]) -> Single:
    """The map of a window in an image of this shape; zeros beyond."""
    out = np.zeros(shape, np.float32)
    box, part = window.back(seen, shape)
    out[box] = part
    return out


def _nearness(on: Mask) -> Single:
    """How near each pixel is to those that are on, 0 to 1."""
    if not on.any():
        return np.zeros(on.shape, np.float32)
    return np.asarray(np.exp(-scipy.ndimage.distance_transform_edt(~on) / _FADES), np.float32)
