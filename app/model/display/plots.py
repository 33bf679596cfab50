"""Plots of a run over its steps, and their axes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

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
    kinetic : ndarray, shape (K,)
        Kinetic energy of all particles [px^2 / unit of time^2].
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
    """Curves on one axis, which begins at zero unless it is logarithmic.

    `line` is a value at which a line is drawn, `first` whether it is shown by default.
    """

    name: str
    title: str
    tip: str
    series: tuple[Series, ...]
    logarithmic: bool = False
    line: float | None = None
    first: bool = False


# Hues after Okabe and Ito, each darkened for a light background and lightened for a dark one.
_BLUE, _ORANGE, _GREEN = ("#0072b2", "#56b4e9"), ("#c2410c", "#ff9d1e"), ("#00785a", "#2bd4a4")
_PINK = ("#b5307f", "#ff7ac6")

PLOTS = (
    Plot(
        "epsilon",
        tr("ε"),
        tr("How much the particles still move (ε of eq. (23)); below the dashed line the run may come to rest."),
        (Series(tr("ε"), lambda metrics: metrics.epsilon, _ORANGE),),
        True,
        EPSILON,
        True,
    ),
    Plot(
        "kinetic",
        tr("Kinetic"),
        tr("Kinetic energy of all particles."),
        (Series(tr("kinetic energy"), lambda metrics: metrics.kinetic, _GREEN),),
        True,
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
