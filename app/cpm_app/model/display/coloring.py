"""Coloring of particles: a number for each particle, and the range in which it is shown."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cpm_app.model.display.lengths import round_up
from cpm_app.model.display.plots import RunMetrics
from cpm_app.model.text.language import tr
from cpm_core.numerics import Array
from cpm_core.numerics.types import Pixels, frozen, record
from cpm_core.segmentation import MethodState

SHADES = 32
"""Number of colors of a palette; one more stands for unknown values."""

_RANGE_PERCENTILE = 99.0
"""Percentage of the particles in the range: a single fast one must not make all others look alike."""


def speed(state: MethodState, _: RunMetrics) -> Array:
    """Return the speed of each particle, shape (N,) [px of the image / unit of time]."""
    return np.linalg.norm(state.particles.velocity, axis=1) * 2.0**state.scale


def force(state: MethodState, _: RunMetrics) -> Array:
    """Return the force on each particle without damping at the last step, shape (N,).

    It is in the unit of its scale, in which the Lorentz force is at most 1.
    """
    return np.linalg.norm(state.particles.force[:, 0], axis=1)


def age(state: MethodState, metrics: RunMetrics) -> Array:
    """Return the steps since each particle was inserted, shape (N,).

    For the first particles of a scale they count from its start; NaN where that is not recorded.
    """
    first = np.searchsorted(metrics.numbered, state.particles.identity, side="right")
    known = first < len(metrics.step)
    steps = np.full(state.count, np.nan)
    steps[known] = state.step - metrics.step[first[known]]
    return steps


@frozen
class Quantity:
    """A quantity by which particles can be colored.

    Attributes
    ----------
    title, tip : str
        Its name, and a sentence on it.
    of : callable
        Function of a state and the metrics of its run that gives its values, shape (N,).
    """

    title: str
    tip: str
    of: Callable[[MethodState, RunMetrics], Array]


QUANTITIES = {
    "speed": Quantity(tr("Speed"), tr("How fast each particle is [px / unit of time]."), speed),
    "force": Quantity(tr("Force"), tr("Coulomb and Lorentz force on each particle, without damping."), force),
    "age": Quantity(tr("Age"), tr("Steps since each particle was inserted, or since its scale began."), age),
}


@record
class Colored:
    """Colors of particles.

    Attributes
    ----------
    marks : ndarray of uint8, shape (N,)
        Color of each particle, from 0 to `SHADES` - 1; `SHADES` where the value is not known.
    high : float
        Value of the last color; the first one is 0.
    """

    marks: Pixels
    high: float


def colored(quantity: Quantity, state: MethodState, metrics: RunMetrics) -> Colored:
    """Return the colors of all particles of a state; a larger quantity never has a lower color."""
    values = quantity.of(state, metrics)
    unknown = np.isnan(values)
    end = float(np.nanpercentile(values, _RANGE_PERCENTILE)) if not unknown.all() else 0.0
    high = round_up(end) if end > 0.0 else 1.0
    fraction = values / high
    fraction[unknown] = 0.0
    marks = np.clip(np.rint(fraction * (SHADES - 1)), 0, SHADES - 1).astype(np.uint8)
    marks[unknown] = SHADES
    return Colored(marks, high)
