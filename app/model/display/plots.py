"""Plots of a run over its steps, and their axes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from app.model.display.lengths import power_text, round_up, scientific_text
from app.model.text.language import tr, written
from cpm_core.model.equations import EPSILON
from cpm_core.numerics.types import Array

_DECADES = 8
"""Maximum number of powers of ten of a logarithmic axis."""


@dataclass(frozen=True, eq=False, slots=True)
class RunMetrics:
    """The run so far, for plots: arrays of equal length, one entry a step, NaN for what a method does not measure.

    Attributes
    ----------
    step : ndarray, shape (K,)
        Step.
    epsilon : ndarray, shape (K,)
        Eq. (23) [px of the scale]; NaN while it is not known.
    count, born, deleted : ndarray, shape (K,)
        Particles, and numbers of particles inserted and deleted in the step.
    kinetic, potential : ndarray, shape (K,)
        Energies of all particles [px^2 / unit of time^2]; the latter is measured every few steps and repeated in
        between; NaN before.
    scale : ndarray, shape (K,)
        Scale; 0 is the image itself.
    numbered : ndarray, shape (K,)
        Identity of the next particle.
    """

    step: Array
    epsilon: Array
    count: Array
    born: Array
    deleted: Array
    kinetic: Array
    potential: Array
    scale: Array
    numbered: Array


@dataclass(frozen=True, slots=True)
class Axis:
    """Scale of the values of a plot; if it is logarithmic, its ends are decimal logarithms."""

    low: float
    high: float
    logarithmic: bool = False

    def fractions(self, values: Array) -> Array:
        """Heights of values, from 0 to 1 inside the axis; not finite where a value is not known."""
        if self.logarithmic:
            with np.errstate(divide="ignore", invalid="ignore"):
                values = np.log10(values)
        return np.asarray((values - self.low) / (self.high - self.low))

    @property
    def labels(self) -> tuple[str, str]:
        """Its ends as text."""
        if self.logarithmic:
            return power_text(round(self.low)), power_text(round(self.high))
        return _figure(self.low), _figure(self.high)


@dataclass(frozen=True, slots=True)
class Series:
    """One curve: its title, its values, and its colors on a light background and on a dark one."""

    title: str
    of: Callable[[RunMetrics], Array]
    colors: tuple[str, str]


@dataclass(frozen=True, slots=True)
class Plot:
    """Curves on one axis; `line` is a value at which a line is drawn, `first` whether it is shown by default."""

    name: str
    title: str
    tip: str
    series: tuple[Series, ...]
    kind: Literal["logarithmic", "from zero", "free"] = "from zero"
    line: float | None = None
    first: bool = False

    def axis(self, metrics: RunMetrics | None) -> Axis:
        """Axis that shows all curves."""
        pieces = [series.of(metrics) for series in self.series] if metrics is not None else []
        values = np.concatenate([np.empty(0), *pieces])
        values = values[np.isfinite(values)]
        if self.kind == "logarithmic":
            return self._logarithmic(values[values > 0])
        if not len(values):
            return Axis(0.0, 1.0)
        low, high = float(values.min()), float(values.max())
        if self.kind == "from zero":
            return Axis(0.0, round_up(high) if high > 0 else 1.0)
        room = 0.05 * (high - low) or max(abs(high), 1.0)
        return Axis(low - room, high + room)

    def _logarithmic(self, values: Array) -> Axis:
        line = self.line
        if not len(values):
            return Axis(-4.0, 0.0, True)
        low, high = float(values.min()), float(values.max())
        if line is not None:
            low, high = min(low, line), max(high, 10.0 * line)
        top = math.ceil(math.log10(high))
        bottom = max(math.floor(math.log10(low)), top - _DECADES)
        return Axis(float(min(bottom, top - 1)), float(top), True)


# Hues after Okabe and Ito, each darkened for a light background and lightened for a dark one.
_BLUE, _ORANGE, _GREEN = ("#0072b2", "#56b4e9"), ("#c2410c", "#ff9d1e"), ("#00785a", "#2bd4a4")
_PURPLE, _PINK = ("#7c4fd6", "#b48cff"), ("#b5307f", "#ff7ac6")

PLOTS: tuple[Plot, ...] = (
    Plot(
        "epsilon",
        tr("ε"),
        tr("How much the particles still move (ε of eq. (23)); below the dashed line the run may come to rest."),
        (Series(tr("ε"), lambda metrics: metrics.epsilon, _ORANGE),),
        "logarithmic",
        EPSILON,
        True,
    ),
    Plot(
        "kinetic",
        tr("Kinetic"),
        tr("Kinetic energy of all particles."),
        (Series(tr("kinetic energy"), lambda metrics: metrics.kinetic, _GREEN),),
        "logarithmic",
    ),
    Plot(
        "potential",
        tr("Potential"),
        tr(
            "Potential energy of all particles: in the field of the edges and of placed charges, and of near pairs. "
            "Computed every 8 steps, on large images only while this is shown."
        ),
        (Series(tr("potential energy"), lambda metrics: metrics.potential, _PURPLE),),
        "free",
    ),
    Plot(
        "count",
        tr("Particles"),
        tr("Number of particles."),
        (Series(tr("particles"), lambda metrics: metrics.count, _BLUE),),
        first=True,
    ),
    Plot(
        "changes",
        tr("Changes"),
        tr("Particles inserted and deleted in each step."),
        (
            Series(tr("inserted"), lambda metrics: metrics.born, _BLUE),
            Series(tr("deleted"), lambda metrics: metrics.deleted, _PINK),
        ),
    ),
)
"""All plots, from top to bottom."""


def figure(value: float) -> str:
    """A value as text; a dash where it is not known."""
    if not math.isfinite(value):
        return "–"
    if value == round(value) and abs(value) < 1e6:
        return written(f"{value:.0f}")
    return scientific_text(value) if abs(value) < 1e-3 or abs(value) >= 1e6 else written(f"{value:.4g}")


def _figure(value: float) -> str:
    if abs(value) >= 1e6:
        return scientific_text(value)
    return written(f"{value / 1000:g}k") if abs(value) >= 1e4 else written(f"{value:.4g}")
