"""A run on a volume larger than memory: particles in each chunk, in fields that are scaled as in the whole volume."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from cpm_core.chunked.chunked_contours import ChunkedTask, chunk_file_name
from cpm_core.chunked.grid import Chunk, ChunkGrid, disturbed_margin
from cpm_core.chunked.image_statistics import (
    ChunkEdges,
    GrayScaling,
    ImageStatistics,
    find_sample_spacing,
    measure_gray_ends,
    measure_strengths,
)
from cpm_core.chunked.run import STATISTICS_FILE, Compute, map_chunks, sort_results
from cpm_core.field.edge_map import volume_edge_map
from cpm_core.field.scale_field import WEAKEST_EDGE
from cpm_core.field.volume_field import (
    BACKGROUND_STRIDE,
    SmoothedVolume,
    automatic_edges,
    noise_strength,
    pitch_of,
    smooth_volume,
    weakest_volume_edge,
)
from cpm_core.image.gray_levels import merge_gray_ends
from cpm_core.image.image import Image
from cpm_core.image.pyramid import build_pyramid
from cpm_core.model.starts import STRONG_EDGE_FRACTION, pixels_above
from cpm_core.model.volume.starts import seeds_everywhere
from cpm_core.model.volume.state import VolumeState
from cpm_core.numerics.grids import Window, first_pixel
from cpm_core.numerics.types import Array, Single, frozen
from cpm_core.parameters import Parameters
from cpm_core.reconstruction.surface.components import neighbor_distances
from cpm_core.reconstruction.surface.local_threshold import LocalThresholds
from cpm_core.reconstruction.surface.pipeline import find_local_thresholds
from cpm_core.segmentation.engine import Engine
from cpm_core.segmentation.evolve import Evolution

VOLUME_CHUNK_SIDE = 256
"""Side of a core [voxels]: a run on it with its margin takes about 1 GB."""

_VOLUME_OVERLAP_MULTIPLE = 8
"""The overlap is a multiple of this, so that the pyramids of neighbors have the same voxels."""

_DISTANCE_SAMPLING = 8
"""One of this many particles contributes to the typical distance."""

_NO_PARTICLES = np.empty((0, 8))
"""Each row of particles has position, threshold, slope, and the normal away from bright."""

PARTICLES_KIND = "particles"
"""Kind of the files that hold the particles of chunks."""


@frozen
class ChunkedVolume:
    """A volume in chunks, with its statistics.

    Attributes
    ----------
    task : ChunkedTask
        The run.
    grid : ChunkGrid
        The chunks.
    statistics : ImageStatistics
        Statistics of the whole volume.
    """

    task: ChunkedTask
    grid: ChunkGrid
    statistics: ImageStatistics

    @property
    def voxel_sides(self) -> Array:
        """Sides of a voxel, shape (3,), the smallest being 1."""
        return np.array(pitch_of(self.task.source.levels.spacing))

    def smooth_chunk(self, chunk: Chunk) -> Single:
        """Smooth what a chunk sees of the volume, shape (P, R, C)."""
        tone = self.statistics.scaling
        values = tone.scale_grays(self.task.source.read_values(chunk.padded))
        return smooth_volume(values, (tone.smoothing / self.voxel_sides).tolist())

    def load_particles(self, chunk: Chunk, window: Window, margin: float) -> tuple[LocalThresholds, Array]:
        """Load the particles in and around a window, in voxels of what a chunk sees.

        Returns the levels of N particles and unit normals, shape (N, 3), that point away from bright.
        """
        files = (chunk_file_name(PARTICLES_KIND, at) for at in self.grid.find_neighbors(chunk))
        rows = np.concatenate([_NO_PARTICLES, *(self.task.store.load(file, "particles")["particles"]
                                                for file in files if self.task.store.has_file(file))])  # fmt: skip
        low, high = np.array([[side.start - margin, side.stop - 1 + margin] for side in window]).T
        rows = rows[((rows[:, :3] >= low) & (rows[:, :3] <= high)).all(axis=1)]
        points = rows[:, :3] - first_pixel(chunk.padded)
        return LocalThresholds(points, rows[:, 3].copy(), rows[:, 4].copy()), rows[:, 5:].copy()


def run_particles(task: ChunkedTask, compute: Compute, side: int) -> tuple[ChunkedVolume, float]:
    """Run in all chunks; return the volume and the typical distance between particles [smallest sides of a voxel]."""
    volume, strongest = _survey_volume(task, compute, side)
    some = [chunk for chunk in volume.grid.chunks if strongest[chunk.number] >= volume.statistics.floor[0]]
    map_chunks(compute, partial(_find_chunk_particles, volume), task.store, some, PARTICLES_KIND)
    distances = [
        task.store.load(chunk_file_name(PARTICLES_KIND, chunk.number), "distances")["distances"] for chunk in some
    ]
    apart = np.concatenate([np.empty(0), *distances])
    if not len(apart):
        raise ValueError("No particle has found an edge in this volume: lower --edge-floor or --smoothing.")
    return volume, float(np.median(apart))


def _survey_volume(task: ChunkedTask, compute: Compute, side: int) -> tuple[ChunkedVolume, Array]:
    """Measure the whole volume, and return it in chunks with the largest edge strength in the core of each."""
    source, parameters = task.source, task.parameters
    if task.store.has_file(STATISTICS_FILE):
        known = task.store.load(STATISTICS_FILE)
        whole = ImageStatistics.from_arrays(known, source.shape)
        return ChunkedVolume(task, _build_volume_grid(task, whole.scaling.smoothing, side), whole), known["in_core"]
    plain = ChunkGrid(source.shape, side, 0).chunks
    ends = compute(partial(measure_gray_ends, source), plain, "gray levels")
    low, high = merge_gray_ends(found for _, found in ends).usable
    looked: dict[float, list[ChunkEdges]] = {}

    def measure_edges(sigma: float, scale: int = 0) -> SmoothedVolume:
        if sigma not in looked:
            work = partial(_measure_chunk_edges, task, GrayScaling(low, high, 1.0, sigma, ()))
            looked[sigma] = sort_results(compute(work, _build_volume_grid(task, sigma, side).chunks, "edges"))
        background = noise_strength(np.concatenate([one.samples[scale] for one in looked[sigma]]))
        strongest = max(one.strongest[scale] for one in looked[sigma])
        nothing = np.empty((0, 0, 0), np.float32)
        return SmoothedVolume(sigma, nothing, nothing, strongest, background)

    smoothing = parameters.smoothing
    sigma = automatic_edges(measure_edges).sigma if smoothing == "auto" else float(smoothing)
    scales = [measure_edges(sigma, scale) for scale in range(parameters.scales)]
    if not scales[0].strongest:
        raise ValueError("The volume is the same everywhere and has no edges: open a volume with objects.")
    floors = [weakest_volume_edge(one.strongest, one.background, parameters.edge_floor)[0] for one in scales]
    whole = ImageStatistics(
        GrayScaling(low, high, 1.0, sigma, ()), tuple(one.strongest for one in scales), tuple(floors)
    )
    in_core = np.array([one.strongest[0] for one in looked[sigma]])
    task.store.save(STATISTICS_FILE, in_core=in_core, **whole.arrays)
    return ChunkedVolume(task, _build_volume_grid(task, sigma, side), whole), in_core


def _build_volume_grid(task: ChunkedTask, smoothing: float, side: int) -> ChunkGrid:
    """Build the grid of a volume for a Gaussian of `smoothing` smallest sides of a voxel."""
    overlap = -(-disturbed_margin(smoothing) // _VOLUME_OVERLAP_MULTIPLE) * _VOLUME_OVERLAP_MULTIPLE
    return ChunkGrid(task.source.shape, side, overlap)


def _measure_chunk_edges(task: ChunkedTask, tone: GrayScaling, chunk: Chunk) -> ChunkEdges:
    """Measure the edges in the core of a chunk at each scale, after a Gaussian."""
    source, pitch = task.source, pitch_of(task.source.levels.spacing)
    sigmas = [tone.smoothing / side for side in pitch]
    return measure_strengths(
        build_pyramid(tone.scale_grays(source.read_values(chunk.padded)), task.parameters.scales),
        chunk.padded,
        chunk.core,
        BACKGROUND_STRIDE * -(-find_sample_spacing(source.shape) // BACKGROUND_STRIDE),
        lambda values: volume_edge_map(smooth_volume(values, sigmas), pitch),
    )


def _find_chunk_particles(volume: ChunkedVolume, chunk: Chunk) -> None:
    """Run in a chunk, and store the particles that it owns."""
    particles, distances = _run_in_chunk(volume, chunk)
    own = np.flatnonzero(volume.grid.find_chunk_numbers(particles[:, :3]) == chunk.number)
    volume.task.store.save(
        chunk_file_name(PARTICLES_KIND, chunk.number),
        particles=particles[own],
        distances=distances[own][::_DISTANCE_SAMPLING],
    )


def _run_in_chunk(volume: ChunkedVolume, chunk: Chunk) -> tuple[Array, Array]:
    """Run in what a chunk sees; return particles at rest on edges, as they are stored, and their distances."""
    task, whole = volume.task, volume.statistics
    source, own = task.source, whole.scaling.adjust_parameters(task.parameters)
    values = whole.scaling.scale_grays(source.read_values(chunk.padded))
    if values.min() == values.max():
        return _NO_PARTICLES, np.empty(0)
    image = Image(values, source.levels.spacing, source.levels.unit, source.path.name)

    def impose_statistics(field: Any, scale: int, given: Parameters) -> Any:
        strongest, floor = whole.strongest[scale], whole.floor[scale]
        noisy = floor > max(WEAKEST_EDGE, given.edge_floor) * strongest
        return replace(field, strongest=strongest, floor=floor, noisy=noisy)

    engine = Engine(image, own, measured=impose_statistics)
    field: Any = engine.scale_field(own)
    seeds = (
        seeds_everywhere(image)
        if task.kind == "grid"
        else pixels_above(field.edge_map, STRONG_EDGE_FRACTION, whole.strongest[0])
    )
    if not len(seeds):
        return _NO_PARTICLES, np.empty(0)
    run = Evolution(engine, engine.start(seeds), own, task.max_steps)
    for _ in run:
        pass
    state = run.moment.state
    assert isinstance(state, VolumeState)
    points = state.position[state.particles.on_surface]
    if not len(points):
        return _NO_PARTICLES, np.empty(0)
    levels, normals = find_local_thresholds(field.smoothed, field.edge_map, points, volume.voxel_sides, field.smoothing)
    places = levels.points + first_pixel(chunk.padded)
    particles = np.column_stack([places, levels.thresholds, levels.slopes, normals])
    return particles, neighbor_distances(levels.points * volume.voxel_sides)
