"""Connections between parts of the inside: necks thinner than the voxels, and thin vessels.

Where a vessel is about as thin as a voxel, the smoothed volume may sink below the local threshold although the vessel
continues. The path between two parts along which the volume stays highest passes a saddle; if the saddle lies in a
neck, the voxels of the path are raised. The paths form no loop, since each joins two parts that were separate.

At a saddle the gray levels rise toward both parts. Across the path they fall: in a neck on all sides, as steeply as
they rise along it; in a gap between two objects they hardly change. Where objects are truly separate, edges face each
other: particles sit on both banks with normals that point across, while in a neck they sit next to the path and their
normals point away from it.

Thin vessels are so thin and faint that no particle stays on them. The path between two parts along which the volume
stays brightest runs along such a vessel. It differs from a chance path through noise by its contrast against its
surroundings, whose significance grows with its length, and from the blur between two objects by what is left of it in
the middle: blur does not reach that far.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cached_property

import numpy as np
import scipy
import skimage

from cpm_core.numerics.grids import ConnectedParts, Labels, find_connected_parts, find_root, window_at
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.polyline import step_lengths
from cpm_core.numerics.types import Array, Index, Mask, Single, record
from cpm_core.reconstruction.surface.blur_correction import interpolate_gray
from cpm_core.reconstruction.surface.components import HEIGHT_AWAY_FROM_PARTICLES

MAX_SADDLE_DEPTH = 1.5
"""Largest depth of a saddle below the threshold [steps of the slope of the edges around]."""

_MAX_DEPTH_WITHOUT_RIDGE = 0.85
"""Largest depth of a saddle where no ridge marks a neck [steps of the slope of the edges around]."""

_MIN_NECK_CURVATURE = 0.7
"""Least curvature across a neck, as a share of that along it."""

_MIN_NECK_STEEPNESS = 0.2
"""Least curvature across a neck, as a share of the slope of the edges around [1 / side]."""

_FACING_COSINE = 0.55
"""Cosine of the angle between a path and the normals on both banks above which it crosses a gap."""

_SADDLE_RADIUS = 3.0
"""Distance from a saddle up to which particles are considered [smallest sides of a voxel]."""

_BANK_OVERLAP = 0.3
"""Distance beyond a saddle up to which particles still belong to a bank [smallest sides of a voxel]."""


@record
class SaddleSurroundings:
    """Volume and particles around saddles, where gray levels are higher inside than outside.

    Attributes
    ----------
    volume : ndarray of float32, shape (P, R, C)
        Smoothed volume.
    sign : float
        1, or -1 where the inside is darker.
    points : ndarray, shape (N, 3)
        Particles on the edges [voxels].
    normals : ndarray, shape (N, 3)
        Unit vectors away from the inside.
    slopes : ndarray, shape (N,)
        Steepness of the edges [gray levels / smallest side of a voxel].
    size : ndarray, shape (3,)
        Sides of a voxel [smallest sides].
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

    def lies_on_ridge(self, path: Index, saddle: Index) -> bool:
        """Return whether gray levels fall on all sides of a path, shape (K, 3), nearly as much as they rise along it.

        The curvature is the mean over its voxels without both ends, which lie inside. At the saddle alone noise
        decides, and where a thin vessel ends in a thick one the saddle lies on the flank of the thick one.
        """
        near = self._places.query_ball_point(saddle * self.size, _SADDLE_RADIUS)
        if not near:
            return False
        curvature = np.mean([self._second_derivatives(voxel) for voxel in path[1:-1]], axis=0)
        _, middle, most = np.linalg.eigvalsh(self.sign * curvature)
        return bool(-middle >= max(_MIN_NECK_CURVATURE * most, _MIN_NECK_STEEPNESS * self.slopes[near].mean()))

    def faces_across(self, path: Index, saddle: Index) -> bool:
        """Return whether edges face each other across a path, shape (K, 3), at its lowest voxel."""
        at, across = saddle * self.size, (path[-1] - path[0]) * self.size
        across = across / np.linalg.norm(across)
        near = self._places.query_ball_point(at, _SADDLE_RADIUS)
        along, toward = (self._places.data[near] - at) @ across, self.normals[near] @ across
        one_bank, other_bank = toward[along < _BANK_OVERLAP], -toward[along > -_BANK_OVERLAP]
        return bool((one_bank > _FACING_COSINE).any() and (other_bank > _FACING_COSINE).any())

    def _second_derivatives(self, at: Index) -> Array:
        found, steps = np.empty((3, 3)), np.eye(3)
        for a in range(3):
            for b in range(a + 1):
                ways = np.array([s * steps[a] + t * steps[b] for s in (1, -1) for t in (1, -1)])
                both, one, other, none = interpolate_gray(self.volume, at + ways)
                found[a, b] = found[b, a] = (both - one - other + none) / (4.0 * self.size[a] * self.size[b])
        return found


_NECKS_APART = 3
"""Distance between saddles of the same two parts that are examined [voxels]."""

_NECK_SEARCH_RADIUS = 6
"""Distance from a saddle up to which the path through it is searched [voxels]."""

RAISED_HEIGHT = 0.25
"""Height given to the voxels of a path: just inside."""

_MAX_MEETINGS = 4
"""Largest number of parts that may meet another one in a voxel."""


def bridge_necks(height: Single, begin: Index, surroundings: SaddleSurroundings) -> list[Index]:
    """Raise the voxels of necks in a height, shape (P, R, C), just above zero; return those of each in the volume.

    `begin` is the first voxel of the height in the volume.
    """
    parts = find_connected_parts(height > 0.0, corners=True)
    passable, every = (height <= 0.0) & (height > -MAX_SADDLE_DEPTH), np.ones(parts.count, bool)

    def is_neck(way: Index, saddle: Index) -> bool:
        """Return whether a path, shape (K, 3), leads through a neck at its saddle, shape (3,)."""
        if height[tuple(way[[0, -1]].T)].max() >= HEIGHT_AWAY_FROM_PARTICLES:
            return False  # the wall on its far side is no edge: one part lies in the other
        depth = -float(height[tuple(saddle)])
        there = way + begin, saddle + begin
        return surroundings.lies_on_ridge(*there) or (
            depth < _MAX_DEPTH_WITHOUT_RIDGE and not surroundings.faces_across(*there)
        )

    ways = find_saddle_paths(height, passable, parts, every, _NECKS_APART, _NECK_SEARCH_RADIUS, is_neck)
    return [_raise_voxels(height, way) + begin for way in ways]


def _raise_voxels(height: Single, path: Index) -> Index:
    voxels = tuple(path.T)
    height[voxels] = np.maximum(height[voxels], RAISED_HEIGHT)
    return path


def find_saddle_paths(
    values: Single,
    passable: Mask,
    parts: ConnectedParts,
    wanted_parts: Mask,
    min_separation: int,
    reach: int,
    joins: Callable[[Index, Index], bool],
) -> Iterator[Index]:
    """Find paths between wanted parts over passable voxels, the highest first; they make no loop.

    They keep the values as high as possible, which may be changed between one path and the next. Of saddles of the same
    two parts nearer than `min_separation` one is examined, and the path is searched in the voxels up to `reach` around
    it. `joins` tells of a path, shape (K, 3), and its saddle, shape (3,), whether it connects two parts.
    """
    if wanted_parts.sum() < 2:
        return
    group = np.arange(parts.count)
    looked_at: dict[tuple[int, int], list[Index]] = {}
    for p, r, c, one, other in find_meetings(values, passable, parts, wanted_parts):
        a, b = find_root(group, one), find_root(group, other)
        saddle, pair = np.array([p, r, c]), (min(one, other), max(one, other))
        tried = looked_at.setdefault(pair, [])
        if a == b or any((np.abs(saddle - before) < min_separation).all() for before in tried):
            continue
        tried.append(saddle)
        way = find_path_through_saddle(values, parts, saddle, one, other, reach)
        if way is not None and joins(way, saddle):
            group[max(a, b)] = min(a, b)
            yield way


def find_meetings(values: Single, passable: Mask, parts: ConnectedParts, wanted_parts: Mask) -> Index:
    """Find the voxels, and the two parts, where the slopes of different parts meet, the highest first, shape (M, 5)."""
    low = np.argwhere(passable)
    low = low[parts.part_at(low) < 0]
    low = low[np.argsort(-values[tuple(low.T)], kind="stable")]
    number = np.where(wanted_parts, np.arange(parts.count) + 1, 0).astype(np.int32)
    labels = parts.fill_voxels(number, np.zeros(values.shape, np.int32))
    basin = np.arange(parts.count + len(low) + 1)
    found = np.empty((_MAX_MEETINGS * len(low), 5), np.int64)
    return found[: _flood_basins(values, labels, low, parts.count, basin, found)]


@compiled
def _flood_basins(height: Single, own: Labels, low: Index, count: int, basin: Index, found: Index) -> int:
    """Assign voxels, from high to low, to the part whose slope they lie on; note where two parts meet.

    A voxel without a higher neighbor begins a basin of its own, which goes to the first part that reaches it.
    """
    planes, rows, cols = height.shape
    seen = np.empty(27, np.int64)
    met = 0
    for n in range(len(low)):
        p, r, c = low[n]
        many, mine = 0, -1
        highest = -np.inf
        for u in range(max(p - 1, 0), min(p + 2, planes)):
            for v in range(max(r - 1, 0), min(r + 2, rows)):
                for w in range(max(c - 1, 0), min(c + 2, cols)):
                    if own[u, v, w] > 0:
                        lead = find_root(basin, own[u, v, w])
                        if lead <= count and height[u, v, w] > highest:
                            highest, mine = height[u, v, w], lead
                        new = True
                        for k in range(many):
                            new = new and seen[k] != lead
                        if new:
                            seen[many] = lead
                            many += 1
        if mine < 0:
            mine = seen[0] if many else count + 1 + n
        own[p, r, c] = mine
        noted = 0
        for k in range(many):
            if seen[k] > count:
                basin[seen[k]] = mine
            elif seen[k] != mine and noted < _MAX_MEETINGS:
                found[met, 0], found[met, 1], found[met, 2] = p, r, c
                found[met, 3], found[met, 4] = mine - 1, seen[k] - 1
                noted += 1
                met += 1
    return met


def find_path_through_saddle(
    values: Single, parts: ConnectedParts, saddle: Index, one: int, other: int, reach: int
) -> Index | None:
    """Find the shortest path, shape (K, 3), between two parts through a saddle, over voxels no lower; None without.

    Both ends are included. Voxels up to `reach` from the saddle are examined.
    """
    low = np.maximum(saddle - reach, 0)
    passable = values[tuple(map(slice, low, saddle + reach + 1))] >= values[tuple(saddle)]
    costs = skimage.graph.MCP_Geometric(np.where(passable, 1.0, -1.0))
    reached, _ = costs.find_costs([tuple(saddle - low)])
    voxels = np.argwhere(passable)
    part = parts.part_at(voxels + low)
    halves = []
    for wanted in (one, other):
        ends = voxels[part == wanted]
        cost = reached[tuple(ends.T)]
        if not len(ends) or not np.isfinite(cost).any():
            return None
        halves.append(np.array(costs.traceback(tuple(ends[cost.argmin()]))) + low)
    return np.concatenate([halves[0][::-1], halves[1][1:]])


_MIN_PARTICLES_ON_PART = 12
"""Least number of particles on a part at which a thin vessel begins."""

_NORMAL_QUARTILE = 0.6744897501960817
"""Distance from the mean within which half of normal noise lies [standard deviations]."""

_MIN_VESSEL_LEVEL = 2.0
"""Least gray level over the background everywhere along a thin vessel [standard deviations of the noise]."""

_MIN_VESSEL_CONTRAST = 4.0
"""Least mean contrast of the middle half of a thin vessel [standard deviations of such a mean]."""

_NOISE_LENGTH = 3.5
"""Length over which smoothed noise counts as one sample: the integral of its autocorrelation [widths of a smoothed
step]."""

_MIN_CONTRAST_SHARE = 0.2
"""Least mean contrast of that half, as a share of the contrast at which the edges of the two parts lie."""

_SHORTEST_VESSEL = 5.0
"""Least length of a thin vessel [widths of a smoothed step]: the blur of two edges farther apart adds up to less than
`_MIN_CONTRAST_SHARE`."""

_LONGEST_VESSEL = 18.0
"""Largest length of a thin vessel [widths of a smoothed step]."""

_RING_RADIUS = 2.5
"""Distance at which gray levels around a thin vessel are sampled [widths of a smoothed step]."""

_RING_DIRECTIONS = 8
"""Number of directions in which gray levels around a thin vessel are sampled."""

_MIN_DIRECTION_LENGTH = 1e-3
"""Length under which a vector has no direction, such as the sum of opposite ones, or the product of parallel ones."""

_MIN_FALL_SHARE = 0.5
"""Least fall of the gray level in each direction, as a share of the mean fall."""

_AVERAGED_VOXELS = 3
"""Number of voxels along a path over which its direction is averaged."""

_VESSEL_SADDLES_APART = 6
"""Distance between saddles of the same two parts that are examined for thin vessels [voxels]."""

_BACKGROUND_SAMPLES = 200_000
"""Number of voxels of the background from which the noise is estimated."""

_FAINT_EDGE_QUANTILE = 0.05
"""Share of the particles on edges so faint that no vessel is searched for them alone."""

_PATH_END_RADIUS = 4.0
"""Distance from the ends of a path within which particles give the gray level of the edges [smallest sides]."""


def bridge_thin_vessels(height: Single, begin: Index, surroundings: SaddleSurroundings, width: float) -> list[Index]:
    """Raise the voxels of thin vessels in a height, shape (P, R, C), just above zero; return those of each.

    `begin` is the first voxel of the height in the volume, and `width` that of a smoothed step [smallest sides]. The
    returned voxels are those of the volume.
    """
    inner, low = height[1:-1, 1:-1, 1:-1], begin + 1
    parts = find_connected_parts(inner > 0.0, corners=True)
    just_inside = surroundings.points - surroundings.normals / surroundings.size
    voxels = np.clip(np.rint(just_inside).astype(np.int64) - low, 0, np.array(inner.shape) - 1)
    part = parts.part_at(voxels)
    wanted = np.bincount(part[part >= 0], minlength=parts.count) >= _MIN_PARTICLES_ON_PART
    gray = surroundings.volume[window_at(low, inner.shape)]
    gray = gray if surroundings.sign > 0.0 else -gray
    background, noise = _estimate_background(gray, inner <= -HEIGHT_AWAY_FROM_PARTICLES)
    edges = surroundings.sign * interpolate_gray(surroundings.volume, surroundings.points)
    floor = background + max(
        _MIN_VESSEL_LEVEL * noise,
        _MIN_CONTRAST_SHARE * (float(np.quantile(edges, _FAINT_EDGE_QUANTILE)) - background),
    )

    def is_thread(way: Index, _: Index) -> bool:
        """Return whether gray levels fall on all sides of a path, shape (K, 3), all along, by more than noise."""
        outside, size = way[parts.part_at(way) < 0] + low.astype(float), surroundings.size
        steps = step_lengths(outside * size)
        if len(outside) <= _AVERAGED_VOXELS or not _SHORTEST_VESSEL * width <= steps.sum() <= _LONGEST_VESSEL * width:
            return False
        falls = surroundings.sign * contrast_around_path(outside, surroundings, width)
        near = (
            np.asarray(scipy.spatial.KDTree(outside[[0, -1]] * size).query(surroundings.points * size)[0])
            < _PATH_END_RADIUS
        )
        if not near.any():
            return False
        contrast, quarter = falls.mean(1), len(falls) // 4
        samples = max(float(steps.sum()) / (_NOISE_LENGTH * width), 1.0)
        least = max(
            _MIN_VESSEL_CONTRAST * noise / np.sqrt(samples), _MIN_CONTRAST_SHARE * (edges[near].mean() - background)
        )
        lasts = contrast[quarter : len(contrast) - quarter].mean() >= least
        return bool(lasts and (falls.mean(0) >= _MIN_FALL_SHARE * falls.mean()).all())

    reach = int(np.ceil(_LONGEST_VESSEL * width / 2.0 / surroundings.size.min())) + 2
    ways = find_saddle_paths(gray, gray > floor, parts, wanted, _VESSEL_SADDLES_APART, reach, is_thread)
    return [_raise_voxels(inner, way) + low for way in ways]


def _estimate_background(gray: Single, background: Mask) -> tuple[float, float]:
    """Estimate the gray level of the background and the standard deviation of its noise; outliers do not count."""
    every, seen, samples = max(int(np.count_nonzero(background)) // _BACKGROUND_SAMPLES, 1), 0, []
    for plane, here in zip(gray, background, strict=True):
        levels = plane[here]
        samples.append(levels[-seen % every :: every])
        seen += len(levels)
    some = np.concatenate(samples)
    if not len(some):
        return 0.0, np.inf
    level = float(np.median(some))
    return level, float(np.median(np.abs(some - np.median(some))) / _NORMAL_QUARTILE)


def contrast_around_path(path: Array, surroundings: SaddleSurroundings, width: float) -> Array:
    """Measure how much higher the volume is on a path, shape (K, 3), than around it, shape (K, directions)."""
    size = surroundings.size
    places = path * size
    along = scipy.ndimage.uniform_filter1d(np.gradient(places, axis=0), _AVERAGED_VOXELS, axis=0)
    turns = np.linalg.norm(along, axis=1) < _MIN_DIRECTION_LENGTH  # where the path goes back on the spot
    along[turns] = np.diff(places, axis=0, prepend=2.0 * places[:1] - places[1:2])[turns]
    along /= np.linalg.norm(along, axis=1)[:, None]
    helper = np.eye(3)[np.abs(places[-1] - places[0]).argmin()]
    one = np.cross(along, helper)
    # where a bend of the path runs along the axis that the path as a whole avoids
    askew = np.linalg.norm(one, axis=1) < _MIN_DIRECTION_LENGTH
    one[askew] = np.cross(along[askew], np.roll(helper, 1))
    one /= np.linalg.norm(one, axis=1)[:, None]
    other = np.cross(along, one)
    angles = 2.0 * np.pi * np.arange(_RING_DIRECTIONS) / _RING_DIRECTIONS
    away = np.cos(angles)[:, None] * one[:, None] + np.sin(angles)[:, None] * other[:, None]
    around = (places[:, None] + _RING_RADIUS * width * away) / size
    values = interpolate_gray(surroundings.volume, np.concatenate([path, around.reshape(-1, 3)]))
    return values[: len(path), None] - values[len(path) :].reshape(len(path), _RING_DIRECTIONS)
