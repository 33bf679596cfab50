"""Contact with a barrier: a particle whose step would cross one slides along it, or stays where it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cpm_core.image.barriers import BarrierMap, crosses
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.segments import meet, side
from cpm_core.numerics.types import Array
from cpm_core.particles.state import Particles


def held_back(barrier_map: BarrierMap, before: Particles, after: Particles) -> Particles:
    """Particles after a step, held back where they cross a barrier or the boundary of a region of interest.

    Such a particle keeps the part of its step and of its velocity that is along the barrier, if this part crosses no
    other barrier; otherwise it stays where it was before, at rest.
    """
    blocked = barrier_map.crossed(before.position, after.position)
    if not blocked.any():
        return after
    position, velocity = after.position.copy(), after.velocity.copy()
    _hold(barrier_map, np.flatnonzero(blocked), before.position, position, velocity)
    return replace(after, position=position, velocity=velocity)


@compiled
def _hold(barrier_map: BarrierMap, blocked: NDArray[np.int64], before: Array, position: Array, velocity: Array) -> None:
    """Let blocked particles slide along the barrier, in place."""
    for n in range(len(blocked)):
        i = blocked[n]
        first, barrier = np.inf, -1
        for s in range(len(barrier_map.segments)):
            if meet(barrier_map.segments[s], before[i], position[i]):
                here = side(barrier_map.segments[s, :2], barrier_map.segments[s, 2:], before[i])
                there = side(barrier_map.segments[s, :2], barrier_map.segments[s, 2:], position[i])
                way = here / (here - there) if here != there else 0.0
                if way < first:
                    first, barrier = way, s
        row = barrier_map.segments[barrier, 2] - barrier_map.segments[barrier, 0]
        col = barrier_map.segments[barrier, 3] - barrier_map.segments[barrier, 1]
        squared = row**2 + col**2
        slide = ((position[i, 0] - before[i, 0]) * row + (position[i, 1] - before[i, 1]) * col) / squared
        speed = (velocity[i, 0] * row + velocity[i, 1] * col) / squared
        position[i, 0], position[i, 1] = before[i, 0] + row * slide, before[i, 1] + col * slide
        velocity[i, 0], velocity[i, 1] = row * speed, col * speed
        if crosses(barrier_map, before[i], position[i]):
            position[i, 0], position[i, 1] = before[i, 0], before[i, 1]
            velocity[i, 0], velocity[i, 1] = 0.0, 0.0
