"""Filling up the crest of the edges between and around the particles.

Where an edge bends sharply the field's equilibrium lies beside the crest, in a notch by a pixel or two, and particles
leave its corner empty. Points for the reconstruction are added there, on the crest itself.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from cpm_core.level import FAINTEST, Level
from cpm_core.population import deletion
from cpm_core.reconstruction.refinement import crest

Array = NDArray[np.float64]

_ROUNDS = 6
"""Rounds at most: gaps wider than twice as many strides are the particles' business."""

_STRIDE, _ROOM = 0.8, 0.6
"""Distance, in d_min, at which a point looks for the crest to go on, and what a new one must keep from all others."""

_DIRECTIONS = 12


def fill(points: Array, level: Level, d_min: float) -> Array:
    """Add points where the crest goes on and there is none.

    Parameters
    ----------
    points : ndarray, shape (N, 2)
        Points on the crest [px].
    level : Level
        Fields of the scale.
    d_min : float
        Spacing of particles [px].

    Returns
    -------
    ndarray, shape (M, 2)
        The points and the added ones.
    """
    angle = 2.0 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    around = _STRIDE * d_min * np.stack([np.sin(angle), np.cos(angle)], axis=1)
    room = _ROOM * d_min
    fresh = points
    for _ in range(_ROUNDS):
        if not len(fresh):
            break
        places = (fresh[:, None] + around).reshape(-1, 2)
        origin = np.repeat(fresh, _DIRECTIONS, axis=0)
        faintest = np.repeat(np.maximum(level.floor, FAINTEST * level.strength(fresh)), _DIRECTIONS)
        tree = cKDTree(points)
        likely = (tree.query(places)[0] >= room) & (level.strength(places) >= faintest)
        places, found = crest(places[likely], level)
        found &= ~level.walls.crossed(origin[likely], places)
        places, faintest = places[found], faintest[likely][found]
        strength = level.strength(places)
        apart = (strength >= faintest) & (tree.query(places)[0] >= room) if len(places) else np.zeros(0, np.bool_)
        places, strength = places[apart], strength[apart]
        # deletion keeps half the spacing it is given between those that have been found twice
        fresh = places[deletion(places, strength, level.shape, 2.0 * room)]
        points = np.concatenate([points, fresh])
    return points
