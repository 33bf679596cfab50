"""Insertion of particles (section 3.6): two rules by which an edge is covered.

Between: two particles on edges at ``d_min < d <= d_min + d_max`` with nothing between them get one at their midpoint,
as in section 3.6, if the edge goes on there and its ridge is free beside the midpoint. Ahead: a particle on an edge
that sees the edge go on within one spacing, with no other on it, gets one there. Annealing ends the first rule; the
second one does not depend on it and carries a front along every edge that is connected to the one it is on, through
bends and junctions. Neither of them reaches across a barrier.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.parameters import Parameters

STRIDE, STRIDE_ROOM = 0.9, 0.8
"""Distance, in d_min, of a place ahead of a particle, and what it must keep from all others."""

CROWD_RANGE, CROWD = 1.5, 3
"""Distance, in d_min, within which a place may have at most so many particles: more are two rows on one edge."""


@dataclass(frozen=True, eq=False, slots=True)
class Births:
    """New particles, shape (M, D), and the two between which each is (the same twice for a place ahead of one)."""

    position: Array
    parent: Index
    other: Index


class Search(NamedTuple):
    """Which particles look for places in a step; all of shape (N,).

    Attributes
    ----------
    present : ndarray of bool
        Which of them are still there.
    looking : ndarray of bool
        Which of them look for places in this step.
    thorough : ndarray of bool
        Which of those do so even if they have others on both sides along their edge.
    ahead : ndarray of bool
        Which of those look ahead as well.
    """

    present: Mask
    looking: Mask
    thorough: Mask
    ahead: Mask


class Rule(NamedTuple):
    """What a place must fulfil.

    Attributes
    ----------
    floor : float
        Weakest edge strength that counts.
    d_min, reach : float
        Spacing, and annealed distance up to which two get one between them [px].
    range : float
        How far off particles are looked at [px].
    """

    floor: float
    d_min: float
    reach: float
    range: float


def search_range(parameters: Parameters) -> float:
    """Distance up to which a step looks at the particles around one [px]."""
    d_min, reach = parameters.d_min, parameters.d_min + parameters.d_max
    return max(reach, 0.5 * reach + CROWD_RANGE * d_min, (STRIDE + CROWD_RANGE) * d_min)
