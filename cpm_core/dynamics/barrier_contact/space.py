"""Contact with a wall of a volume."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np

from cpm_core.image.volume_barriers import Walls
from cpm_core.numerics.types import Array
from cpm_core.particles.state import Particles


def held_back(walls: Walls, before: Particles, after: Particles) -> Particles:
    """Particles after a step, held back where they would cross a wall.

    Such a particle keeps the part of its step and of its velocity along the plane that it would cross, or along the
    faces of painted voxels: the first of these parts that crosses no wall. Otherwise it stays where it was, at rest.
    """
    blocked = np.flatnonzero(walls.crossed(before.position, after.position))
    if not len(blocked):
        return after
    position, velocity = after.position.copy(), after.velocity.copy()
    for along in _ways(walls):
        step = position[blocked] - before.position[blocked]
        ends = before.position[blocked] + step @ along
        free = ~walls.crossed(before.position[blocked], ends)
        chosen = blocked[free]
        position[chosen], velocity[chosen] = ends[free], velocity[chosen] @ along
        blocked = blocked[~free]
    position[blocked], velocity[blocked] = before.position[blocked], 0.0
    return replace(after, position=position, velocity=velocity)


def _ways(walls: Walls) -> list[Array]:
    """Projections, shape (3, 3), of a step: on each plane, then on the faces of voxels, then on their edges."""
    across = walls.planes[:, :3] * walls.size
    across = across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300)
    on_planes = [np.eye(3) - np.outer(normal, normal) for normal in across]
    axes = np.eye(3)
    return [*on_planes, *(np.diag(axes[list(kept)].sum(axis=0)) for n in (2, 1) for kept in combinations(range(3), n))]
