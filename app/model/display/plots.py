"""Plots of a run over its steps, and their axes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from app.model.text.language import tr
from cpm_core.model import EPSILON
from cpm_core.numerics import Array


@dataclass(frozen=True, eq=False)
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


@dataclass(frozen=True)
class Series:
    """One curve: its title, its values, and its colors on a light background and on a dark one."""

    title: str
    of: Callable[[RunMetrics], Array]
    colors: tuple[str, str]


@dataclass(frozen=True)
class Plot:
    """Curves on one axis, what they mean, and a value at which a line is drawn."""

    tip: str
    series: tuple[Series, ...]
    kind: Literal["logarithmic", "from zero", "free"] = "from zero"
    line: float | None = None


# Hues after Okabe and Ito, each darkened for a light background and lightened for a dark one.
_BLUE, _ORANGE, _GREEN = ("#0072b2", "#56b4e9"), ("#c2410c", "#ff9d1e"), ("#00785a", "#2bd4a4")
_PURPLE, _PINK = ("#7c4fd6", "#b48cff"), ("#b5307f", "#ff7ac6")

PLOTS = (
    Plot(
        tr("How much the particles still move (ε of eq. (23)); below the dashed line the run may come to rest."),
        (Series(tr("ε"), lambda metrics: metrics.epsilon, _ORANGE),),
        "logarithmic",
        EPSILON,
    ),
    Plot(
        tr("Kinetic energy of all particles."),
        (Series(tr("kinetic energy"), lambda metrics: metrics.kinetic, _GREEN),),
        "logarithmic",
    ),
    Plot(
        tr(
            "Potential energy of all particles: in the field of the edges and of placed charges, and of near pairs. "
            "Computed every 8 steps, on large images only while the plots are unfolded."
        ),
        (Series(tr("potential energy"), lambda metrics: metrics.potential, _PURPLE),),
        "free",
    ),
    Plot(
        tr("Number of particles."),
        (Series(tr("particles"), lambda metrics: metrics.count, _BLUE),),
    ),
    Plot(
        tr("Particles inserted and deleted in each step."),
        (
            Series(tr("inserted"), lambda metrics: metrics.born, _BLUE),
            Series(tr("deleted"), lambda metrics: metrics.deleted, _PINK),
        ),
    ),
)
"""All plots, from top to bottom."""
