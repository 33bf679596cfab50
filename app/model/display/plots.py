"""What of a run is plotted over its steps, and on which axis."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from app.model.display.round_numbers import round_up
from app.model.text.language import tr
from cpm_core.dynamics.equilibrium import EPSILON
from cpm_core.numerics.types import Array

_DECADES = 8
"""Powers of ten that a logarithmic axis shows at most."""


class Record(Protocol):
    """What a run has recorded, one entry a step."""

    @property
    def epsilon(self) -> Array:
        """Eq. (23)."""

    @property
    def count(self) -> Array:
        """Particles."""

    @property
    def born(self) -> Array:
        """Particles inserted."""

    @property
    def deleted(self) -> Array:
        """Particles deleted."""

    @property
    def kinetic(self) -> Array:
        """Kinetic energy."""

    @property
    def potential(self) -> Array:
        """Potential energy."""


@dataclass(frozen=True, slots=True)
class Axis:
    """How values become heights.

    Attributes
    ----------
    low, high : float
        Values at its ends, or their decimal logarithms.
    logarithmic : bool
        Which of the two.
    """

    low: float
    high: float
    logarithmic: bool = False

    def fractions(self, values: Array) -> Array:
        """Heights from 0 to 1 of values; outside of that what the axis does not show, not finite what is not known."""
        if self.logarithmic:
            with np.errstate(divide="ignore", invalid="ignore"):
                values = np.log10(values)
        return np.asarray((values - self.low) / (self.high - self.low))

    @property
    def labels(self) -> tuple[str, str]:
        """Its ends in figures."""
        if self.logarithmic:
            return tuple("1" if end == 0 else f"1e{end:.0f}" for end in (self.low, self.high))  # type: ignore[return-value]
        return _figure(self.low), _figure(self.high)


@dataclass(frozen=True, slots=True)
class Series:
    """One curve.

    Attributes
    ----------
    title : str
        What it is called.
    of : callable
        Its values in a record.
    colors : tuple of str
        Its color on a light ground and on a dark one.
    """

    title: str
    of: Callable[[Record], Array]
    colors: tuple[str, str]


@dataclass(frozen=True, slots=True)
class Plot:
    """Curves on one axis.

    Attributes
    ----------
    name : str
        What it is called in code.
    title, tip : str
        What it is called, and what it shows, in a sentence.
    series : tuple of Series
        Curves.
    kind : {"logarithmic", "from zero", "free"}
        Kind of its axis.
    line : float, optional
        Value at which a line is drawn.
    first : bool
        Whether it is shown at first.
    """

    name: str
    title: str
    tip: str
    series: tuple[Series, ...]
    kind: Literal["logarithmic", "from zero", "free"] = "from zero"
    line: float | None = None
    first: bool = False

    def axis(self, record: Record | None) -> Axis:
        """Axis that shows all curves."""
        pieces = [series.of(record) for series in self.series] if record is not None else []
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


# Hues after Okabe and Ito, each darkened for a light ground and lightened for a dark one.
_BLUE, _ORANGE, _GREEN = ("#0072b2", "#56b4e9"), ("#c2410c", "#ff9d1e"), ("#00785a", "#2bd4a4")
_PURPLE, _PINK = ("#7c4fd6", "#b48cff"), ("#b5307f", "#ff7ac6")

PLOTS: tuple[Plot, ...] = (
    Plot(
        "epsilon",
        tr("ε"),
        tr("ε of eq. (23), with the line under which a run may come to rest."),
        (Series(tr("ε"), lambda record: record.epsilon, _ORANGE),),
        "logarithmic",
        EPSILON,
        True,
    ),
    Plot(
        "kinetic",
        tr("Kinetic"),
        tr("Kinetic energy of all particles."),
        (Series(tr("kinetic energy"), lambda record: record.kinetic, _GREEN),),
        "logarithmic",
    ),
    Plot(
        "potential",
        tr("Potential"),
        tr(
            "Potential energy of all particles: in the field of the edges and of placed charges, and of near pairs. "
            "Worked out every 8 steps, on large images only while this is shown."
        ),
        (Series(tr("potential energy"), lambda record: record.potential, _PURPLE),),
        "free",
    ),
    Plot(
        "count",
        tr("Particles"),
        tr("Number of particles."),
        (Series(tr("particles"), lambda record: record.count, _BLUE),),
        first=True,
    ),
    Plot(
        "changes",
        tr("In and out"),
        tr("Particles inserted and deleted in each step."),
        (
            Series(tr("inserted"), lambda record: record.born, _BLUE),
            Series(tr("deleted"), lambda record: record.deleted, _PINK),
        ),
    ),
)
"""All there is to be plotted, from above."""


def figure(value: float) -> str:
    """A value for people; a dash where it is not known."""
    if not math.isfinite(value):
        return "–"
    if value == round(value) and abs(value) < 1e6:
        return f"{value:.0f}"
    return f"{value:.2e}" if abs(value) < 1e-3 or abs(value) >= 1e6 else f"{value:.4g}"


def _figure(value: float) -> str:
    return f"{value:.0e}".replace("e+0", "e").replace("e+", "e") if abs(value) >= 1e5 else f"{value:.4g}"
