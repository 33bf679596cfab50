"""Insertion of particles (section 3.6): two rules by which particles cover an edge.

Between: two particles on edges at ``d_min < d <= d_min + d_max`` with nothing between them get one at their midpoint,
as in section 3.6, if the edge continues there and its ridge is free beside the midpoint. Ahead: a particle on an edge
that continues within one spacing, without other particles there, gets one there. Annealing ends the first rule; the
second one does not depend on it and moves a front along every edge that is connected to its own, through bends and
junctions. Neither of them reaches across a barrier.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.parameters import Parameters

STRIDE, STRIDE_ROOM = 0.9, 0.8
"""Distance, in d_min, of a position ahead of a particle, and its distance from all others."""

CROWD_RANGE, CROWD = 1.5, 3
"""Distance, in d_min, and the largest number of particles within it around a position: more are two rows on one
edge."""


@dataclass(frozen=True, eq=False, slots=True)
class Births:
    """New particles, shape (M, D), and the two parents of each (the same twice for a position ahead of one)."""

    position: Array
    parent: Index
    other: Index


class Search(NamedTuple):
    """Which particles search for positions in a step; all of shape (N,).

    Attributes
    ----------
    present : ndarray of bool
        Which have not been deleted.
    looking : ndarray of bool
        Which of them search in this step.
    thorough : ndarray of bool
        Which of those search even if they have others on both sides along their edge.
    ahead : ndarray of bool
        Which of those also search ahead.
    """

    present: Mask
    looking: Mask
    thorough: Mask
    ahead: Mask


class Rule(NamedTuple):
    """Conditions on a position.

    Attributes
    ----------
    floor : float
        Least edge strength.
    d_min, reach : float
        Spacing, and annealed distance up to which two particles get one between them [px].
    range : float
        Distance up to which other particles are examined [px].
    """

    floor: float
    d_min: float
    reach: float
    range: float


def search_range(parameters: Parameters) -> float:
    """Distance up to which a step examines the particles around one [px]."""
    d_min, reach = parameters.d_min, parameters.d_min + parameters.d_max
    return max(reach, 0.5 * reach + CROWD_RANGE * d_min, (STRIDE + CROWD_RANGE) * d_min)
