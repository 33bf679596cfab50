"""Filling up the crest of the edges between and around the particles.

Where an edge bends sharply the field's equilibrium lies beside the crest, in a notch by a pixel or two, and particles
leave its corner empty. Points for the reconstruction are added there, on the crest itself.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from cpm_core.field.interpolation import interpolate
from cpm_core.level import Level
from cpm_core.population import deletion
from cpm_core.reconstruction.refinement import crest

Array = NDArray[np.float64]

_ROUNDS = 6
"""Rounds at most: gaps wider than twice as many strides are the particles' business."""

_STRIDE, _ROOM = 0.8, 0.6
"""Distance, in d_min, at which a point looks for the crest to go on, and what a new one must keep from all others."""

_DIRECTIONS = 12

_FAINTEST = 0.35
"""Edge strength of a new point, as a fraction of that of the point it comes from."""


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
        faintest = np.repeat(np.maximum(level.floor, _FAINTEST * _strength(fresh, level)), _DIRECTIONS)
        tree = cKDTree(points)
        likely = (tree.query(places)[0] >= room) & (_strength(places, level) >= faintest)
        places, found = crest(places[likely], level)
        places, faintest = places[found], faintest[likely][found]
        strength = _strength(places, level)
        apart = (strength >= faintest) & (tree.query(places)[0] >= room) if len(places) else np.zeros(0, np.bool_)
        places, strength = places[apart], strength[apart]
        fresh = places[deletion(places, strength, level.shape, 2.0 * room)]
        points = np.concatenate([points, fresh])
    return points


def _strength(points: Array, level: Level) -> Array:
    return interpolate(level.edge_map[None], points)[:, 0]
