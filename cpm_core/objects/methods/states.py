"""States of the runs of methods: closed curves, and functions on the pixels whose level is the contour."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
import skimage
from numpy.typing import NDArray

from cpm_core.contours.contour import Contour
from cpm_core.contours.surface import Surface
from cpm_core.numerics.grids import zero_surface
from cpm_core.numerics.types import Array

_NONE = np.empty((0, 2))
_LEAST_CORNERS = 3


@dataclass(frozen=True, eq=False)
class Stoppable:
    """Step and end of a run; no particles.

    Attributes
    ----------
    step : int
        Number of steps so far.
    stop_reason : str
        Why the run ended, in words; empty while it continues.
    converged : bool
        Whether it ended because nothing moved any more.
    """

    step: int = 0
    stop_reason: str = ""
    converged: bool = False

    @property
    def surface(self) -> Surface | None:
        """No surface."""
        return None

    @property
    def points(self) -> Array:
        """No particles, shape (0, 2)."""
        return _NONE


@dataclass(frozen=True, eq=False)
class CurveState(Stoppable):
    """Closed curves: `curves`, each of shape (K, 2) [px]."""

    curves: tuple[Array, ...] = ()

    @cached_property
    def contours(self) -> tuple[Contour, ...]:
        """The curves."""
        return tuple(Contour(curve, closed=True) for curve in self.curves)


class RegionState(Stoppable):
    """A function on the pixels: the contours run where it crosses a level, and it is higher inside."""

    @abstractmethod
    def function(self) -> tuple[NDArray[Any], float]:
        """The function, shape (H, W) or (P, H, W), and the level."""

    @property
    def inside(self) -> NDArray[np.bool_]:
        """The pixels inside, shape (H, W)."""
        values, level = self.function()
        return np.asarray(values, dtype=float) > level

    @property
    def sides(self) -> tuple[bool, bool]:
        """Whether there are pixels inside and outside."""
        inside = self.inside
        return bool(inside.any()), not inside.all()

    @cached_property
    def contours(self) -> tuple[Contour, ...]:
        """Closed contours, the longest first; those of a region at the border of the image run along the border."""
        return level_contours(*self.function()) if self.inside.ndim == 2 else ()

    @cached_property
    def surface(self) -> Surface | None:
        """In a volume the closed surface around the voxels inside, with voxels of sides 1."""
        return None if self.inside.ndim == 2 else level_surface(*self.function())


@dataclass(frozen=True, eq=False)
class LevelSetState(RegionState):
    """A function that is given on all pixels."""

    values: NDArray[Any] = field(default_factory=lambda: np.zeros((0, 0)))
    level: float = 0.0

    def function(self) -> tuple[NDArray[Any], float]:
        """The function, shape (H, W) or (P, H, W), and the level."""
        return self.values, self.level


def level_contours(values: NDArray[np.generic], level: float) -> tuple[Contour, ...]:
    """Closed contours around the pixels of a function, shape (H, W), that lie above a level, the longest first."""
    found = skimage.measure.find_contours(_rimmed(values, level), 0.0)  # type: ignore[no-untyped-call]
    lines = [np.clip(line[:-1] - 1.0, -0.5, np.array(values.shape) - 0.5) for line in found]
    made = (Contour(line, closed=True) for line in lines if len(line) >= _LEAST_CORNERS)
    return tuple(sorted(made, key=lambda contour: -contour.length))


def level_surface(values: NDArray[np.generic], level: float) -> Surface:
    """The closed surface around the voxels of a function, shape (P, H, W), that lie above a level."""
    vertices, faces = zero_surface(_rimmed(values, level).astype(np.float32))
    return Surface(np.clip(vertices - 1.0, -0.5, np.array(values.shape) - 0.5), faces)


def _rimmed(values: NDArray[np.generic], level: float) -> Array:
    """A function above a level, with a rim as far below it as the function is above it or below it anywhere."""
    inside = np.asarray(values, dtype=float) - level
    return np.pad(inside, 1, constant_values=-max(float(np.abs(inside).max(initial=0.0)), 1e-9))


Region = TypeVar("Region", bound=RegionState)


def until_at_rest(states: Iterator[Region], every: int, least: float, most_steps: int) -> Iterator[Region]:
    """States of a front until it is at rest, vanishes, or has done `most_steps`.

    It is at rest when within `every` steps the pixels that have changed sides are fewer than `least` of those on the
    front.
    """
    before: NDArray[np.bool_] | None = None
    for state in states:
        if not all(state.sides):
            reason = "nothing is left" if state.sides[1] else "the contour has left the image"
            yield replace(state, stop_reason=reason)
            return
        if state.step >= most_steps:
            yield replace(state, stop_reason=f"stopped after {state.step} steps")
            return
        if state.step % every == 0:
            inside = state.inside
            if before is not None and (inside != before).sum() <= least * _front(inside):
                yield replace(state, stop_reason="the contour is at rest", converged=True)
                return
            before = inside
        yield state


def _front(inside: NDArray[np.bool_]) -> int:
    """Number of pairs of neighboring pixels of which one is inside."""
    return int(sum(np.diff(inside, axis=axis).sum() for axis in range(inside.ndim)))
