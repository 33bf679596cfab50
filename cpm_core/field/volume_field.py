"""The fields of a volume at its scales: smoothed volume, edge map, and far field of the fixed charges."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property, lru_cache, partial
from typing import Any, Literal, NamedTuple

import numpy as np

from cpm_core.field.convolution import block_means, convolved_field, convolved_potential
from cpm_core.field.edge_map import NO_SMOOTHING, volume_edge_map
from cpm_core.field.scale_field import MAX_BACKGROUND, WEAKEST_EDGE
from cpm_core.field.scale_space import SourceImages
from cpm_core.field.volume_surface import Ridges, find_ridges, force_on_voxels
from cpm_core.image.pyramid import shape_at_scale, to_image
from cpm_core.image.volume_regions import VolumeRegions, Walls
from cpm_core.numerics.grids import extend_line, half_gaussian_weights, sum_across, sum_along
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import run_in_parallel
from cpm_core.numerics.types import Array, Arrays, Extent, Mask, Sides, Single, copy_with, record
from cpm_core.numerics.vectors import Vector
from cpm_core.parameters import DEFAULT_VALUES, PLANE_PARAMETERS, Parameters
from cpm_core.parameters.choices import Accuracy

FAR_FIELD_BLOCK = 2.0
"""Side of the blocks of the far field [units]."""

_MIN_CHARGED_STRENGTH = 0.25
"""Edge strength under which a voxel carries no charge of the far field, as a fraction of the floor."""

_MAXWELL_QUARTILE = 1.1010
"""Lower quartile of the Maxwell distribution of unit width."""

_NOISE_DEVIATIONS = 4.2
"""Deviations of a component of the gradient that noise rarely exceeds: one in two thousand voxels, which are no ridge
that a front could follow."""

_VOLUME_SIGMAS = (0.7, 1.0, 1.2, 1.4, 2.0, 3.0)
"""Sigmas that the automatic smoothing tries [units]; the first one keeps thin vessels that nearly touch apart."""

_CLEAR_BACKGROUNDS = (0.1, 0.22, 0.22, 0.25, 0.25, 1.0)
"""Background, as a fraction of the largest edge strength, up to which each sigma is enough."""

_USABLE_BACKGROUND = 0.25
"""Background up to which a sigma is taken if the next one is not enough: a volume full of edges has them everywhere."""

_MIN_NORMAL_COSINE = 0.7
"""Least scalar product of the normals of two voxels of the edge map that belong to one surface."""

PLANES_PER_THREAD = 8
"""Number of planes that are worth a thread."""

BACKGROUND_STRIDE = 3
"""The background is measured at every third voxel along each axis."""


class FarField(NamedTuple):
    """Field of the fixed charges, float32 of shape (3, P, R, C), and the voxels along the sides of a block."""

    force: Single
    block: Vector


class SmoothedVolume(NamedTuple):
    """Sigma of the smoothing, the smoothed volume, its edge map, the largest edge strength, and the background's."""

    sigma: float
    smoothed: Single
    edge_map: Single
    strongest: float
    background: float


@record
class VolumeField:
    """Fields of one scale of a volume.

    Attributes
    ----------
    smoothed, edge_map : ndarray of float32, shape (P, R, C)
        The smoothed volume, whose slope on an edge is normal to it, and the edge strength f of every voxel [gray
        levels / unit], zero outside the regions of interest.
    pitch : tuple of float
        Sides of a voxel [units].
    strongest : float
        Largest edge strength.
    floor : float
        Least edge strength for edge contact.
    smoothing : float
        Sigma of the Gaussian [units].
    exponent : float
        Power of the distance with which the force of a fixed charge decays.
    accuracy : {"standard", "exact"}
        How the far field is computed: from blocks of two units, or from every voxel.
    noisy : bool
        Whether noise decides on the floor; the normals of single voxels are then unreliable.
    walls : Walls or None
        Walls that no particle crosses.
    """

    smoothed: Single
    edge_map: Single
    pitch: Vector
    strongest: float
    floor: float
    smoothing: float
    exponent: float = 3.0
    accuracy: Accuracy = "standard"
    noisy: bool = False
    walls: Walls | None = None

    @property
    def shape(self) -> Extent:
        """Shape of the volume at this scale."""
        return self.smoothed.shape

    @property
    def extent(self) -> Vector:
        """Size of the volume [units]."""
        planes, rows, cols = (float(n * side) for n, side in zip(self.shape, self.pitch, strict=True))
        return planes, rows, cols

    @property
    def fixed_charges(self) -> Single:
        """Size of the fixed charges."""
        return self.edge_map

    @cached_property
    def far_field(self) -> FarField:
        """Field of the fixed charges; computed on first use."""
        wanted = FAR_FIELD_BLOCK if self.accuracy == "standard" else 1.0
        block = [max(1, round(wanted / side)) for side in self.pitch]
        deep = PLANES_PER_THREAD * block[0]
        slabs = (self.edge_map[k : k + deep] for k in range(0, self.shape[0], deep))
        weak = _MIN_CHARGED_STRENGTH * self.floor
        charges = np.concatenate([block_means(np.where(slab < weak, np.float32(0), slab), block) for slab in slabs])
        sides = tuple(n * side for n, side in zip(block, self.pitch, strict=True))
        force = convolved_field(charges, self.exponent, np.float32, sides).astype(np.float32, copy=False)
        return FarField(force, (float(block[0]), float(block[1]), float(block[2])))

    @property
    def lorentz(self) -> Single:
        """Lorentz force on the voxels, shape (3, P, R, C), as particles there feel it."""
        out = np.empty((3, *self.shape), np.float32)
        fields = (self.smoothed, self.edge_map, self.far_field.force, self.pitch, self.far_field.block, self.floor)
        run_in_parallel(
            lambda first, last: force_on_voxels(*fields, first, last, out), len(self.smoothed), PLANES_PER_THREAD
        )
        return out

    @cached_property
    def potential(self) -> Array:
        """Potential of the fixed charges, shape (P, R, C), exact."""
        return convolved_potential(self.edge_map, self.pitch, self.exponent)

    @cached_property
    def slope(self) -> float:
        """Mean slope of the potential [gray levels / unit]; 1 where it is flat."""
        slope = float(volume_edge_map(self.potential.astype(np.float32), self.pitch).mean(dtype=float))
        return slope if slope > 0.0 else 1.0

    def with_far_field(self, exponent: float, accuracy: Accuracy) -> VolumeField:
        """Return the same edges with another field of their charges; everything known of the edges is kept."""
        other = replace(self, exponent=exponent, accuracy=accuracy)
        other.__dict__.update({name: known for name, known in self.__dict__.items() if name == "ridges"})
        return other

    def crosses_wall(self, start: Array, end: Array) -> Mask:
        """Return a mask, shape (N,), of the straight moves, from and to shape (N, 3) [units], that cross a wall."""
        return np.zeros(len(start), bool) if self.walls is None else self.walls.is_crossed_by(start, end)

    @cached_property
    def ridges(self) -> Ridges:
        """Ridges of the edge map; found on first use."""
        return find_ridges(
            self.smoothed, self.edge_map, self.pitch, self.floor, -1.0 if self.noisy else _MIN_NORMAL_COSINE
        )


def build_volume_field(
    values: Array,
    pitch: Vector,
    smoothing: float | Literal["auto"],
    edge_floor: float,
    interest: Mask | None = None,
) -> VolumeField:
    """Build the fields of a volume, shape (P, R, C), with voxels of these sides [units].

    `smoothing` is the sigma of the Gaussian [units], or the least of a series that raises the edges above the noise;
    `edge_floor` is the fraction of the largest edge strength below which there is no edge; at 0 the background
    decides alone; outside `interest` there are no edges.
    """
    after = partial(_smooth_edges, values, pitch, interest)
    found = automatic_edges(after) if smoothing == "auto" else after(float(smoothing))
    floor, noisy = weakest_volume_edge(found.strongest, found.background, edge_floor)
    made = found.smoothed, found.edge_map, pitch, found.strongest, floor, found.sigma
    return VolumeField(*made, noisy=noisy)


def weakest_volume_edge(strongest: float, background: float, edge_floor: float) -> tuple[float, bool]:
    """Return the least edge strength for edge contact, and whether noise decides on it."""
    least = max(WEAKEST_EDGE, edge_floor) * strongest
    noise = min(background, MAX_BACKGROUND * strongest)
    return max(least, noise) if strongest > 0.0 else math.inf, noise > least


def automatic_edges(after: Callable[[float], SmoothedVolume]) -> SmoothedVolume:
    """Find the edges after the least smoothing that raises them above the noise; `after` smooths by one sigma."""
    usable: float | None = None
    for sigma, clear in zip(_VOLUME_SIGMAS, _CLEAR_BACKGROUNDS, strict=True):
        found = after(sigma)
        if found.background <= clear * found.strongest:
            return found
        if usable is not None:
            return after(usable)
        usable = sigma if found.background <= _USABLE_BACKGROUND * found.strongest else None
    return found


def _smooth_edges(values: Array, pitch: Vector, interest: Mask | None, sigma: float) -> SmoothedVolume:
    """Smooth a volume by a Gaussian of this sigma [units], and measure its edges; there are none outside `interest`."""
    smoothed = smooth_volume(values, [sigma / side for side in pitch])
    edge_map = volume_edge_map(smoothed, pitch, interest)
    some = edge_map[(slice(None, None, BACKGROUND_STRIDE),) * 3].ravel() if interest is None else edge_map[interest]
    return SmoothedVolume(sigma, smoothed, edge_map, float(edge_map.max()), noise_strength(some))


def noise_strength(strengths: Array | Single) -> float:
    """Return the edge strength that noise rarely exceeds, from strengths, shape (N,), all over a volume."""
    return _NOISE_DEVIATIONS * float(np.percentile(strengths, 25.0)) / _MAXWELL_QUARTILE


def smooth_volume(values: Array, sigmas: list[float]) -> Single:
    """Smooth a volume, shape (P, R, C), by a Gaussian with a sigma for each axis [voxels], in single precision."""
    weights = tuple(half_gaussian_weights(sigma) if sigma > NO_SMOOTHING else np.ones(1) for sigma in sigmas)
    out = np.empty(values.shape, np.float32)
    lines = values.reshape(len(values), -1)
    run_in_parallel(partial(_smooth_planes, lines, weights, out), len(out), PLANES_PER_THREAD)
    return out


@compiled
def _smooth_planes(lines: Array, weights: Arrays, out: Single, first: int, end: int) -> None:
    """Write planes, given as lines of all their rows, after a Gaussian, each axis rounded to single precision."""
    (rows, cols), reach = out.shape[1:], len(weights[2]) - 1
    flat, line, total = np.empty((rows, cols)), np.empty(cols + 2 * reach), np.empty(cols)
    for i in range(first, end):
        for j in range(rows):
            sum_across(lines, i, j * cols, weights[0], total)
            for k in range(cols):
                flat[j, k] = np.float32(total[k])
        for j in range(rows):
            sum_across(flat, j, 0, weights[1], total)
            for k in range(cols):
                line[reach + k] = np.float32(total[k])
            extend_line(line, reach)
            sum_along(line, weights[2], total)
            for k in range(cols):
                out[i, j, k] = total[k]


MAX_PITCH = 10.0
"""Side that a voxel has at most for particles, in units of the smallest one.

Particles are about two units apart. Along a longer side they would be closer than the voxels can resolve, and there
would be so many that a run takes minutes. Measures of the surface use the true side.
"""


VolumeFieldBuilder = Callable[..., VolumeField]
"""Builds fields without walls from a scale and the values that their edges depend on."""


def volume_field_builders(
    sources: SourceImages, pitch: Vector, regions: VolumeRegions | None, free: VolumeFieldBuilder | None = None
) -> tuple[VolumeFieldBuilder, Callable[[int, Parameters], VolumeField]]:
    """Make the functions of `plane_field_builders` for a volume; they refuse parameters of images."""
    kept, shape = lru_cache(sources.scales), sources.shape

    @kept
    def build_field(scale: int, gamma: Any, smoothing: Any, edge_floor: float) -> VolumeField:
        values = sources.source_at(scale, "luminance", "gradient", gamma, 0.0).values  # not cleaned
        return build_volume_field(values, pitch, smoothing, edge_floor, _interest_voxels(regions, shape, scale))

    known = free or build_field

    @kept
    def field_of(exponent: float, accuracy: Accuracy, scale: int, *key: object) -> VolumeField:
        found = known(scale, *key)
        if (found.exponent, found.accuracy) != (exponent, accuracy):
            found = found.with_far_field(exponent, accuracy)
        return found if regions is None else copy_with(found, walls=regions.build_walls(shape).at_scale(scale, pitch))

    def field_at(scale: int, parameters: Parameters) -> VolumeField:
        check_volume_parameters(parameters)
        edges = parameters.gamma, parameters.smoothing, parameters.edge_floor
        return field_of(parameters.exponent_in(3), parameters.accuracy, scale, *edges)

    return known, field_at


def _interest_voxels(regions: VolumeRegions | None, shape: Extent, scale: int) -> Mask | None:
    """Return a mask of the voxels of a scale whose centers are of interest; None for all."""
    voxels = None if regions is None else regions.voxel_mask(shape)
    if voxels is None or scale == 0:
        return voxels
    count = shape_at_scale(shape, scale)
    along = np.rint(to_image(np.arange(max(count))[:, None] * np.ones(3), scale, shape))
    along = np.clip(along, 0, np.array(shape) - 1).astype(int)
    return voxels[np.ix_(*(along[:n, axis] for axis, n in enumerate(count)))]


def pitch_of(spacing: Sides) -> Vector:
    """Return the sides of a voxel in units of the smallest one, as particles feel them: at most `MAX_PITCH`."""
    least = min(spacing)
    plane, row, col = (min(side / least, MAX_PITCH) for side in spacing)
    return plane, row, col


def check_volume_parameters(parameters: Parameters) -> None:
    """Raise a `ValueError` unless the parameters that have a meaning in the plane only have their default values."""
    for name in PLANE_PARAMETERS:
        value = getattr(parameters, name)
        if value != DEFAULT_VALUES[name]:
            shown = f"{value:g}" if isinstance(value, float) else repr(value)
            raise ValueError(
                f"{name} is {shown} but has no meaning in a volume: leave it at {DEFAULT_VALUES[name]}, "
                'as PRESETS["volume"] does.'
            )
