"""Coloring of particles: a number for each particle, and the range in which it is shown."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cpm_app.model.display.lengths import round_up
from cpm_app.model.display.plots import RunMetrics
from cpm_app.model.text.language import tr
from cpm_core.numerics import Array
from cpm_core.numerics.types import Pixels, frozen
from cpm_core.segmentation import MethodState

SHADE_COUNT = 32
"""Number of colors of a palette; one more stands for unknown values."""

_RANGE_PERCENTILE = 99.0
"""Percentage of the particles in the range: a single fast one must not make all others look alike."""


def particle_speed(state: MethodState, _: RunMetrics) -> Array:
    """Return the speed of each particle, shape (N,) [px of the image / unit of time]."""
    return np.linalg.norm(state.particles.velocity, axis=1) * 2.0**state.scale


def particle_force(state: MethodState, _: RunMetrics) -> Array:
    """Return the force on each particle without damping at the last step, shape (N,).

    It is in the unit of its scale, in which the Lorentz force is at most 1.
    """
    return np.linalg.norm(state.particles.force[:, 0], axis=1)


def particle_age(state: MethodState, metrics: RunMetrics) -> Array:
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
    measure : callable
        Function of a state and the metrics of its run that gives its values, shape (N,).
    """

    title: str
    tip: str
    measure: Callable[[MethodState, RunMetrics], Array]


QUANTITIES = {
    "speed": Quantity(tr("Speed"), tr("How fast each particle is [px / unit of time]."), particle_speed),
    "force": Quantity(tr("Force"), tr("Coulomb and Lorentz force on each particle, without damping."), particle_force),
    "age": Quantity(tr("Age"), tr("Steps since each particle was inserted, or since its scale began."), particle_age),
}


def color_particles(quantity: Quantity, state: MethodState, metrics: RunMetrics) -> tuple[Pixels, float]:
    """Color all particles of a state; a larger quantity never has a lower color.

    Returns
    -------
    color_indices : ndarray of uint8, shape (N,)
        Color of each particle, from 0 to `SHADE_COUNT` - 1; `SHADE_COUNT` where the value is not known.
    high : float
        Value of the last color; the first one is 0.
    """
    values = quantity.measure(state, metrics)
    unknown = np.isnan(values)
    end = float(np.nanpercentile(values, _RANGE_PERCENTILE)) if not unknown.all() else 0.0
    high = round_up(end) if end > 0.0 else 1.0
    fraction = values / high
    fraction[unknown] = 0.0
    marks = np.clip(np.rint(fraction * (SHADE_COUNT - 1)), 0, SHADE_COUNT - 1).astype(np.uint8)
    marks[unknown] = SHADE_COUNT
    return marks, high
