"""Threads: vessels so thin and faint that no particle stays on them, between parts of the inside that particles found.

The way between two parts along which the volume stays brightest runs along such a vessel. It is told from a chance way
through noise by its contrast against what is around it, all along, in units of the noise, and from the blur between
two objects by its length: blur does not reach that far.
"""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.field.interpolation import interpolate
from cpm_core.numerics.grids import Parts, parts_of
from cpm_core.numerics.types import Array, Index, Mask, Single
from cpm_core.reconstruction.surface.iso.joints import RAISED, meetings_of, root, way_between
from cpm_core.reconstruction.surface.iso.necks import Surroundings
from cpm_core.reconstruction.surface.iso.sides import FAR

_FEWEST = 12
"""Least number of particles on a part that a thread begins at."""

_QUARTILE = 0.6744897501960817
"""Distance from the mean [standard deviations] within which half of normal noise lies."""

_SIGNIFICANT = 3.0
"""Least contrast of a thread, in standard deviations of the noise, everywhere along it."""

_SHARE = 0.2
"""The same, as a share of the contrast at which the edges of the two parts lie."""

_SHORTEST, _LONGEST = 3.5, 18.0
"""Length of a thread [widths of a smoothed step]: the blur of two edges farther apart adds up to less than `_SHARE`."""

_RING, _DIRECTIONS = 2.5, 8
"""Distance at which one looks around a thread [widths of a smoothed step], and in how many directions."""

_ASKEW = 1e-3
"""Sine of the angle from which two directions differ."""

_FALLS = 0.5
"""Least fall of the gray level in each direction, as a share of the mean of all."""

_ALONG = 3
"""Voxels along a way over which its contrast is averaged."""

_APART = 6
"""Distance between saddles of the same two parts that are looked at [voxels]."""

_SAMPLE = 200_000
"""Voxels of the background from which the noise is estimated."""

_FAINT = 0.05
"""Share of the particles that lie on edges so faint that no thread is sought for them alone."""

_NEAR = 4.0
"""Distance from the ends of a way within which particles tell the gray level of the edges [smallest sides]."""


def spin(height: Single, begin: Index, surroundings: Surroundings, width: float) -> int:
    """Raise the voxels of threads in a height just above zero, and return the number of threads.

    `begin` is the first voxel of the height in the volume, and `width` that of a smoothed step [smallest sides].
    """
    inner, low = height[1:-1, 1:-1, 1:-1], begin + 1
    parts = parts_of(inner > 0.0, corners=True)
    wanted = _with_particles(parts, surroundings, low)
    if wanted.sum() < 2:
        return 0
    gray = surroundings.volume[tuple(slice(a, a + n) for a, n in zip(low, inner.shape, strict=True))]
    gray = gray if surroundings.sign > 0.0 else -gray
    background, noise = _level_and_noise(gray[inner <= -FAR])
    edges = surroundings.sign * interpolate(surroundings.volume[None], surroundings.points)[:, 0]
    floor = background + max(_SIGNIFICANT * noise, _SHARE * (float(np.quantile(edges, _FAINT)) - background))
    group, count = np.arange(parts.count), 0
    looked_at: dict[tuple[int, int], list[Index]] = {}
    reach = int(np.ceil(_LONGEST * width / 2.0 / surroundings.size.min())) + 2
    for p, r, c, one, other in meetings_of(gray, gray > floor, parts, wanted):
        a, b = root(group, one), root(group, other)
        saddle, pair = np.array([p, r, c]), (min(one, other), max(one, other))
        tried = looked_at.setdefault(pair, [])
        if a == b or any((np.abs(saddle - before) < _APART).all() for before in tried):
            continue
        tried.append(saddle)
        way = way_between(gray, parts, saddle, one, other, reach)
        if way is None or not _is_thread(
            way[parts.part_at(way) < 0] + low.astype(float), surroundings, width, background, noise
        ):
            continue
        group[max(a, b)] = min(a, b)
        count += 1
        inner[tuple(way.T)] = np.maximum(inner[tuple(way.T)], RAISED)
    return count


def _with_particles(parts: Parts, surroundings: Surroundings, low: Index) -> Mask:
    """Which parts have enough particles on their sides to begin a thread."""
    just_inside = surroundings.points - surroundings.normals / surroundings.size
    voxels = np.clip(np.rint(just_inside).astype(np.int64) - low, 0, np.array(parts.labels.shape) - 1)
    part = parts.part_at(voxels)
    return np.asarray(np.bincount(part[part >= 0], minlength=parts.count) >= _FEWEST)


def _level_and_noise(background: Single) -> tuple[float, float]:
    """Typical gray level of the background, and the standard deviation of its noise; outliers do not count."""
    some = background[:: max(len(background) // _SAMPLE, 1)]
    if not len(some):
        return 0.0, np.inf
    level = float(np.median(some))
    return level, float(np.median(np.abs(some - np.median(some))) / _QUARTILE)


def _is_thread(outside: Array, surroundings: Surroundings, width: float, background: float, noise: float) -> bool:
    """Whether gray levels fall to all sides of a way, shape (K, 3), all along, by more than noise would."""
    size = surroundings.size
    steps = np.linalg.norm(np.diff(outside * size, axis=0), axis=1)
    if len(outside) <= _ALONG or not _SHORTEST * width <= steps.sum() <= _LONGEST * width:
        return False
    falls = surroundings.sign * falls_around(outside, surroundings, width)
    near = np.asarray(scipy.spatial.KDTree(outside[[0, -1]] * size).query(surroundings.points * size)[0]) < _NEAR
    if not near.any():
        return False
    at_edges = surroundings.sign * interpolate(surroundings.volume[None], surroundings.points[near])[:, 0].mean()
    contrast = scipy.ndimage.uniform_filter1d(falls.mean(1), _ALONG)[_ALONG // 2 : -(_ALONG // 2)]
    least = max(_SIGNIFICANT * noise, _SHARE * (at_edges - background))
    return bool(contrast.min() >= least and (falls.mean(0) >= _FALLS * falls.mean()).all())


def falls_around(way: Array, surroundings: Surroundings, width: float) -> Array:
    """How much higher the volume is on a way, shape (K, 3), than around it, shape (K, directions)."""
    size = surroundings.size
    places = way * size
    along = scipy.ndimage.uniform_filter1d(np.gradient(places, axis=0), _ALONG, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    helper = np.eye(3)[np.abs(places[-1] - places[0]).argmin()]
    one = np.cross(along, helper)
    askew = np.linalg.norm(one, axis=1) < _ASKEW  # a bend of the way runs along the axis that the whole way avoids
    one[askew] = np.cross(along[askew], np.roll(helper, 1))
    one /= np.linalg.norm(one, axis=1)[:, None]
    other = np.cross(along, one)
    angles = 2.0 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    away = np.cos(angles)[:, None] * one[:, None] + np.sin(angles)[:, None] * other[:, None]
    around = (places[:, None] + _RING * width * away) / size
    values = interpolate(surroundings.volume[None], np.concatenate([way, around.reshape(-1, 3)]))[:, 0]
    return np.asarray(values[: len(way), None] - values[len(way) :].reshape(len(way), _DIRECTIONS))
