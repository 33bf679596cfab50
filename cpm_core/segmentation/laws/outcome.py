"""What is told of a state, in any dimension."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpm_core.contours.result import Result
from cpm_core.dynamics.forces import Forces
from cpm_core.image.image import Image
from cpm_core.numerics.types import Array, Index
from cpm_core.parameters import Parameters
from cpm_core.particles.state import State


def result_of(state: State, image: Image, parameters: Parameters, **found: Any) -> Result:
    """The result of a run at a state, with what has been found: contours and bridges, or a surface."""
    return Result(
        particles=state.position,
        steps=state.step,
        converged=state.converged,
        stop_reason=state.stop_reason,
        shape=image.shape,
        spacing=image.spacing,
        unit=image.unit,
        source=image.source,
        image=image,
        regions=state.regions,
        channel=image.channel(parameters.channel),
        **found,
    )


def forces_asked(state: State, changed: State, asked: Index, of: Callable[[Index], Forces]) -> Forces:
    """Forces on some particles of a state, of which `changed` is the one with which a step begins.

    `of` gives those on particles of `changed`; they are NaN for particles that it has no more.
    """
    row = _places(state.particles.identity, changed.particles.identity)[asked]
    there = row >= 0
    found = of(row[there])
    return found if there.all() else Forces(*(_spread(getattr(found, f.name), there) for f in fields(Forces)))


def _places(before: Index, after: Index) -> Index:
    """For each earlier identity its index among the later ones, which keep their order; -1 where it is gone."""
    stays = np.isin(before, after)
    return np.where(stays, np.cumsum(stays) - 1, -1)


def _spread(rows: Array, there: NDArray[np.bool_]) -> Array:
    """Rows, shape (K, D), at the positions where `there`, shape (M,), is true; NaN elsewhere."""
    spread = np.full((len(there), rows.shape[1]), np.nan)
    spread[there] = rows
    return spread
