"""Necks and gaps: whether two parts of the inside hang together where they come close.

At a saddle between two parts the gray levels rise toward both. Across that way they fall on all sides along a neck,
as steeply as they rise along it; in a gap between two objects they hardly change. And where objects are truly apart,
edges face each other: particles sit on both banks with normals that point across, while along a neck they sit beside
the way and their normals point away from it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from cpm_core.field.interpolation import interpolate
from cpm_core.numerics.types import Array, Index, Single

DEEPEST = 1.5
"""How far a saddle may lie below the threshold at most [steps of the slope of the edges around]."""

_SHALLOW = 0.85
"""The same where no ridge tells a neck."""

_RIDGE, _STEEP = 0.7, 0.2
"""Least curvature across a neck: as a share of that along it, and of the slope of the edges around [1 / side]."""

_FACING = 0.55
"""Cosine of the angle between a way and the normals on both banks above which it crosses a gap."""

_AROUND = 3.0
"""Distance from a saddle up to which particles tell of it [smallest sides of a voxel]."""

_BANK = 0.3
"""How far beyond a saddle the particles of a bank may lie, likewise."""


@dataclass(frozen=True, eq=False)
class Surroundings:
    """What is known around saddles: gray levels that are higher inside than outside, and particles on the edges.

    Attributes
    ----------
    volume : ndarray of float32, shape (P, R, C)
        Smoothed volume.
    sign : float
        1, or -1 where the inside is darker.
    points, normals : ndarray, shape (N, 3)
        Positions [voxels] of the particles, and unit vectors away from the inside.
    slopes : ndarray, shape (N,)
        Steepness of the edges at the particles.
    size : ndarray, shape (3,)
        Sides of a voxel; the smallest is 1.
    """

    volume: Single
    sign: float
    points: Array
    normals: Array
    slopes: Array
    size: Array

    @cached_property
    def _places(self) -> scipy.spatial.KDTree:
        return scipy.spatial.KDTree(self.points * self.size)

    def on_a_ridge(self, way: Index, saddle: Index) -> bool:
        """Whether gray levels fall to all sides of a way, shape (K, 3), nearly as much as they rise along it.

        The curvature is the mean over its voxels without both ends, which lie inside. At the saddle alone noise
        decides, and where a thin vessel ends in a thick one the saddle lies on the flank of the thick one.
        """
        near = self._places.query_ball_point(saddle * self.size, _AROUND)
        if not near:
            return False
        curvature = np.mean([self._second_derivatives(voxel) for voxel in way[1:-1]], axis=0)
        _, middle, most = np.linalg.eigvalsh(self.sign * curvature)
        return bool(-middle >= max(_RIDGE * most, _STEEP * self.slopes[near].mean()))

    def faces_across(self, way: Index, saddle: Index) -> bool:
        """Whether edges face each other across a way, shape (K, 3), at its lowest voxel."""
        at, across = saddle * self.size, (way[-1] - way[0]) * self.size
        across = across / np.linalg.norm(across)
        near = self._places.query_ball_point(at, _AROUND)
        along, toward = (self._places.data[near] - at) @ across, self.normals[near] @ across
        one_bank, other_bank = toward[along < _BANK], -toward[along > -_BANK]
        return bool((one_bank > _FACING).any() and (other_bank > _FACING).any())

    def is_neck(self, way: Index, saddle: Index, depth: float) -> bool:
        """Whether two parts hang together along a way over a saddle so far below the threshold."""
        return self.on_a_ridge(way, saddle) or (depth < _SHALLOW and not self.faces_across(way, saddle))

    def _second_derivatives(self, at: Index) -> Array:
        steps = np.eye(3)
        ways = [s * steps[a] + t * steps[b] for a in range(3) for b in range(a + 1) for s in (1, -1) for t in (1, -1)]
        values = interpolate(self.volume[None], at + np.array(ways))[:, 0].reshape(-1, 4)
        found = np.empty((3, 3))
        pairs = [(a, b) for a in range(3) for b in range(a + 1)]
        for (a, b), (both, one, other, none) in zip(pairs, values, strict=True):
            found[a, b] = found[b, a] = (both - one - other + none) / (4.0 * self.size[a] * self.size[b])
        return found
