"""Solids of known surface and topology in small volumes, and particles on their edges."""

from typing import NamedTuple

import numpy as np
from scipy.ndimage import gaussian_filter
from scipy.spatial import KDTree

from cpm_core.field.edge_map import volume_edge_map
from cpm_core.numerics.grids import zero_surface
from cpm_core.reconstruction.surface.pipeline import find_surface

SIDE = 40.0
MIDDLE = np.full(3, (SIDE - 1.0) / 2.0)


def ball(radius, center=MIDDLE):
    return lambda p: radius - np.linalg.norm(p - center, axis=-1)


def ring(radius, tube, axis=0, center=MIDDLE):
    def signed(p):
        q = p - center
        around = np.sqrt(np.maximum((q**2).sum(-1) - q[..., axis] ** 2, 0.0))
        return tube - np.hypot(around - radius, q[..., axis])

    return signed


def brick(*half, center=MIDDLE):
    def signed(p):
        q = np.abs(p - center) - np.array(half)
        return -np.linalg.norm(np.maximum(q, 0.0), axis=-1) - np.minimum(q.max(-1), 0.0)

    return signed


def rod(one, other, radius):
    one, other = np.array(one, float), np.array(other, float)

    def signed(p):
        along = np.clip((p - one) @ (other - one) / ((other - one) @ (other - one)), 0.0, 1.0)
        return radius - np.linalg.norm(p - one - along[..., None] * (other - one), axis=-1)

    return signed


def union(*solids):
    return lambda p: np.max([solid(p) for solid in solids], axis=0)


def without(one, other):
    return lambda p: np.minimum(one(p), -other(p))


def grid(spacing=(1.0, 1.0, 1.0), side=SIDE):
    """Places of the voxels, in the unit of the spacing."""
    return np.stack(np.meshgrid(*[np.arange(round(side / s)) * s for s in spacing], indexing="ij"), -1)


class Scene(NamedTuple):
    """A volume, smoothed, with its edge map and particles [voxels]."""

    volume: np.ndarray
    edges: np.ndarray
    points: np.ndarray
    spacing: tuple


def scene(solid, spacing=(1.0, 1.0, 1.0), noise=0.0, dark=False, apart=1.8, found=None):
    """A solid of contrast 200 with antialiased sides, and one particle every `apart` on its surface.

    `found` is the part of the solid that particles have found, the whole without it.
    """
    gray = 200.0 * np.clip(0.5 + solid(grid(spacing)) / max(spacing), 0.0, 1.0)
    gray += np.random.default_rng(0).normal(0.0, noise, gray.shape)
    if dark:
        gray = 200.0 - gray
    size = np.array(spacing) / min(spacing)
    smooth = gaussian_filter(gray, 1.0 / size).astype(np.float32)
    edges = volume_edge_map(smooth, tuple(size))
    points = thinned(zero_surface((found or solid)(grid()).astype(np.float32))[0], apart) / np.array(spacing)
    inside = ((points >= 0.0) & (points <= np.array(gray.shape) - 1.0)).all(1)
    return Scene(smooth, edges, points[inside], spacing)


def thinned(points, apart):
    """Points of which no two are nearer than a distance."""
    free = np.ones(len(points), bool)
    for one, near in enumerate(KDTree(points).query_ball_point(points, apart)):
        if free[one]:
            free[[other for other in near if other != one]] = False
    return points[free]


def surface_of(seen):
    return find_surface(seen.volume, seen.edges, seen.points, seen.spacing, "mm")
