"""How the particles of a step stand: on an edge or not, and who is near whom."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from cpm_core.field.interpolation import between, component
from cpm_core.kernels import compiled
from cpm_core.level import GATE, Level
from cpm_core.neighbors import Cells, build_cells
from cpm_core.threads import share

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Single = NDArray[np.float32]

_WORTH_A_THREAD = 10_000
"""Particles from which on a second thread makes the survey faster."""


@dataclass(frozen=True, eq=False, slots=True)
class Standing:
    """How the particles of a step stand.

    Attributes
    ----------
    strength : ndarray, shape (N,)
        Edge strength at each.
    seated : ndarray of bool, shape (N,)
        Which sit on an edge: where the interpolated unit field has fallen below the gate and the edge is strong enough.
    cells : Cells
        The particles sorted into cells, for neighbours up to a distance.
    """

    strength: Array
    seated: Mask
    cells: Cells


def survey(positions: Array, level: Level, distance: float) -> Standing:
    """Tell how particles stand.

    Parameters
    ----------
    positions : ndarray, shape (N, 2)
        The particles [px].
    level : Level
        Fields of the scale.
    distance : float
        Up to what distance neighbours will be looked for [px].
    """
    strength, seated = np.empty(len(positions)), np.empty(len(positions), np.bool_)
    share(partial(_survey, level.felt, level.floor, positions, strength, seated), len(positions), _WORTH_A_THREAD)
    height, width = level.shape
    return Standing(strength, seated, build_cells(positions, height, width, distance))


def is_seated(positions: Array, level: Level) -> Mask:
    """Which particles, shape (N, 2), sit on an edge."""
    strength, seated = np.empty(len(positions)), np.empty(len(positions), np.bool_)
    _survey(level.felt, level.floor, positions, strength, seated, 0, len(positions))
    return seated


@compiled
def _survey(felt: Single, floor: float, position: Array, strength: Array, seated: Mask, first: int, last: int) -> None:
    for i in range(first, last):
        strength[i], seated[i] = seat(felt, position[i, 0], position[i, 1], floor)


@compiled
def seat(felt: Single, y: float, x: float, floor: float) -> tuple[float, bool]:
    """Edge strength at a place, and whether a particle sits on an edge there.

    It does where the interpolated unit field has fallen below the gate and the edge is strong enough.
    """
    place = between(felt, y, x)
    f_y, f_x, strength = component(felt, 0, place), component(felt, 1, place), component(felt, 4, place)
    return strength, f_y**2 + f_x**2 < GATE**2 and strength >= floor
