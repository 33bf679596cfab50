"""One surface from the particles of all chunks of a volume.

Each chunk finds the height over the edges in its core, and numbers the regions away from particles; all chunks together
decide which of these are inside. Then each chunk raises necks and thin vessels, and triangulates the zero of the common
height: triangles of neighbors share their corners, which lie on edges between voxels and are named by them. Parts of
the inside and of the outside are numbered in each chunk as well; parts of two chunks that share a voxel are one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.chunked.chunked_contours import OBJECTS_KIND, chunk_file_name
from cpm_core.chunked.grid import Chunk, ChunkedSource, ChunkGrid
from cpm_core.chunked.image_statistics import ImageStatistics
from cpm_core.chunked.run import Compute, map_chunks
from cpm_core.chunked.volume_run import ChunkedVolume
from cpm_core.formats.images.ome_zarr import create_multiscale, write_window
from cpm_core.formats.images.reading import Reading
from cpm_core.numerics.grids import (
    Labels,
    Window,
    bridge_corner_contacts,
    find_connected_parts,
    first_pixel,
    label_joined_pairs,
    lie_inside,
    relative_window,
    window_shape,
    zero_surface,
)
from cpm_core.numerics.types import Array, Index, JsonDict, Mask, Single, frozen, record
from cpm_core.reconstruction.surface.blur_correction import blurred_edge_width
from cpm_core.reconstruction.surface.components import (
    HEIGHT_AWAY_FROM_PARTICLES,
    has_enough_support,
    has_point_within,
    vote_on_unknown_regions,
)
from cpm_core.reconstruction.surface.joints import RAISED_HEIGHT, SaddleSurroundings, bridge_necks, bridge_thin_vessels
from cpm_core.reconstruction.surface.local_threshold import VoxelBox, height_over_threshold
from cpm_core.reconstruction.surface.pipeline import width_and_band

_MAX_HEIGHT = np.float32(2**18)
"""Largest height, where an edge has no slope: far from the surface."""

_HEIGHT_ARRAY = "height"
"""Name of the array of heights, NaN in the regions away from particles."""

_REGION_ARRAY = "regions"
"""Name of the array of the numbers of these regions."""

_PART_ARRAY = "parts"
"""Name of the array of the numbers of parts of the inside and of the outside."""

_NECKS_KIND = "necks"
"""Kind of the files that hold the necks of chunks."""

_GAUSSIAN_REACH = 3.0
"""Widths of the Gaussian within which a particle counts."""

_PARTICLE_MARGIN = 4
"""Additional voxels, for the thickness of the band along longer sides of voxels, and the layers around a core."""


@frozen
class _NumberedRegions:
    """Files of regions that are numbered within each chunk, from 0; -1 is the number of voxels in no region."""

    volume: ChunkedVolume
    name: str

    def read_window(self, window: Window) -> Labels:
        """Read the numbers in a window."""
        return _stored_array(self.volume, self.name).read_values(window)

    def load_chunk(self, number: int, *names: str) -> JsonDict:
        """Load what has been stored of a chunk, all arrays or some."""
        return self.volume.task.store.load(chunk_file_name(self.name, number), *names)

    def save_chunk(self, chunk: Chunk, numbers: Labels, **arrays: Any) -> None:
        """Write the numbers in the core of a chunk, and store those one voxel beyond with other arrays."""
        write_window(_stored_array(self.volume, self.name).path, chunk.core, numbers[_core_of_extended(chunk)])
        layers = {f"layer_{axis}": numbers.take(-1, axis) for axis, _ in _find_layers_beyond(self.volume, chunk)}
        self.volume.task.store.save(chunk_file_name(self.name, chunk.number), **layers, **arrays)

    def compute_chunks(self, work: Callable[[Chunk], None], compute: Compute, title: str) -> None:
        """Process each chunk that has no file yet."""
        _create_array(self.volume, self.name, np.int32)
        map_chunks(compute, work, self.volume.task.store, self.volume.grid.chunks, self.name, title)

    def join_regions(self, counts: Index) -> Index:
        """Join the regions of all chunks where they meet; return the group of each, from 0, shape (sum of counts,)."""
        first, pairs = np.cumsum([0, *counts]), [np.empty(0, np.int64)]
        for chunk in self.volume.grid.chunks:
            for axis, window in _find_layers_beyond(self.volume, chunk):
                mine = self.load_chunk(chunk.number, f"layer_{axis}")[f"layer_{axis}"].astype(np.int64)
                theirs = self.read_window(window).reshape(mine.shape).astype(np.int64)
                both = (mine >= 0) & (theirs >= 0)
                for number, part in self.volume.grid.split_window(window):
                    inner = tuple(side for k, side in enumerate(relative_window(part, window)) if k != axis)
                    theirs[inner] += first[number]
                pairs.append(np.unique((mine[both] + first[chunk.number]) * first[-1] + theirs[both]))
        return label_joined_pairs(np.stack(np.divmod(np.concatenate(pairs), first[-1])), int(first[-1]))


def _stored_array(volume: ChunkedVolume, name: str) -> ChunkedSource:
    """Return an array of the store that has a value for each voxel."""
    return ChunkedSource(volume.task.store.folder / f"{name}.zarr", Reading(), "zyx")


def _create_array(volume: ChunkedVolume, name: str, dtype: type[np.generic]) -> None:
    """Create such an array, unless an interrupted run has."""
    path = _stored_array(volume, name).path
    if not path.exists():
        create_multiscale(path, volume.grid.shape, dtype, volume.grid.side)


def _extended_core(volume: ChunkedVolume, chunk: Chunk) -> Window:
    """Extend the core of a chunk by one voxel at the end of each axis, within the volume."""
    return tuple(
        slice(side.start, min(side.stop + 1, n)) for side, n in zip(chunk.core, volume.grid.shape, strict=True)
    )


def _core_of_extended(chunk: Chunk) -> Window:
    """Return the core of a chunk as a window of the extended one."""
    return tuple(slice(n) for n in window_shape(chunk.core))


def _find_layers_beyond(volume: ChunkedVolume, chunk: Chunk) -> Iterator[tuple[int, Window]]:
    """Find the layers of voxels of neighbors that continue a core, each with the axis across it."""
    beyond = _extended_core(volume, chunk)
    for axis, (core, side) in enumerate(zip(chunk.core, beyond, strict=True)):
        if side.stop > core.stop:
            yield axis, (*beyond[:axis], slice(core.stop, side.stop), *beyond[axis + 1 :])


@record
class EdgeHeights:
    """The height over the edges of a volume.

    Attributes
    ----------
    volume : Volume
        The chunks.
    particle_distance : float
        Typical distance between particles [smallest sides of a voxel].
    first : ndarray of int64
        First region of each chunk.
    region_heights : ndarray of float32
        Height of each region.
    sign : float
        1, or -1 where the inside is darker.
    """

    volume: ChunkedVolume
    particle_distance: float
    first: Index
    region_heights: Single
    sign: float

    def read_window(self, window: Window) -> Single:
        """Read the height in a window, positive inside; outside the volume it is -1."""
        grid = self.volume.grid
        inner = tuple(slice(max(side.start, 0), min(side.stop, n)) for side, n in zip(window, grid.shape, strict=True))
        found: Single = _stored_array(self.volume, _HEIGHT_ARRAY).read_values(inner)
        regions = _NumberedRegions(self.volume, _REGION_ARRAY).read_window(inner)
        for number, part in grid.split_window(inner):
            here = relative_window(part, inner)
            values, region = found[here], regions[here]
            unknown = region >= 0
            values[unknown] = self.region_heights[self.first[number] + region[unknown]]
        found *= np.float32(self.sign)
        outer = [(a.start - b.start, b.stop - a.stop) for a, b in zip(inner, window, strict=True)]
        return np.pad(found, outer, constant_values=-1.0)


def compute_heights(volume: ChunkedVolume, apart: float, compute: Compute) -> EdgeHeights:
    """Compute the height over the edges of a volume with this typical distance between its particles."""
    regions = _NumberedRegions(volume, _REGION_ARRAY)
    _create_array(volume, _HEIGHT_ARRAY, np.float32)
    regions.compute_chunks(partial(_compute_chunk_height, regions, apart), compute, "surface near particles")
    names = ("votes", "at_border", "bright", "known")
    known = [regions.load_chunk(chunk.number, *names) for chunk in volume.grid.chunks]
    counts = np.array([len(one["votes"]) for one in known])
    group = regions.join_regions(counts)
    votes = np.bincount(group, np.concatenate([one["votes"] for one in known]))
    heights = np.where(votes > 0, np.float32(HEIGHT_AWAY_FROM_PARTICLES), np.float32(-HEIGHT_AWAY_FROM_PARTICLES))[
        group
    ]
    # an object may be darker than its surroundings: the side with most of the border of the volume is the outside
    at_border = np.concatenate([one["at_border"] for one in known])
    bright = at_border[heights > 0.0].sum() + sum(int(one["bright"]) for one in known)
    total = at_border.sum() + sum(int(one["known"]) for one in known)
    return EdgeHeights(volume, apart, np.cumsum([0, *counts]), heights, -1.0 if 2 * bright > total else 1.0)


def _compute_chunk_height(regions: _NumberedRegions, apart: float, chunk: Chunk) -> None:
    """Compute the height in a chunk, and number the regions away from particles in it and a voxel beyond; store both.

    The height is NaN in these regions.
    """
    volume = regions.volume
    beyond = _extended_core(volume, chunk)
    width, band = width_and_band(apart)
    levels, _ = volume.load_particles(chunk, beyond, max(_GAUSSIAN_REACH * width, band) + _PARTICLE_MARGIN)
    if len(levels.points):
        begin = np.array([side.start - 1 for side in relative_window(beyond, chunk.padded)])
        box = VoxelBox(begin, tuple(n + 2 for n in window_shape(beyond)))  # type: ignore[arg-type]
        found = height_over_threshold(volume.smooth_chunk(chunk), box, levels, volume.voxel_sides, width, band)
        np.clip(found, -_MAX_HEIGHT, _MAX_HEIGHT, out=found)
        found[found == 0.0] = -np.finfo(np.float32).tiny  # the darker side, whatever the sign
        parts, votes = vote_on_unknown_regions(found)
        numbers = parts.fill_voxels(np.arange(parts.count, dtype=np.int32), np.full(found.shape, -1, np.int32))
        height, numbers = found[1:-1, 1:-1, 1:-1], numbers[1:-1, 1:-1, 1:-1]
    else:
        height = np.full(window_shape(beyond), np.nan, np.float32)
        numbers, votes = np.zeros(height.shape, np.int32), np.zeros(1, np.int64)
    core = _core_of_extended(chunk)
    border, region = (_collect_border_values(volume, chunk, values[core]) for values in (height, numbers))
    at_border = np.bincount(region[region >= 0], minlength=len(votes))
    bright = np.count_nonzero(border[region < 0] > 0.0)
    write_window(_stored_array(volume, _HEIGHT_ARRAY).path, chunk.core, height[core])
    regions.save_chunk(
        chunk, numbers, votes=votes, at_border=at_border, bright=bright, known=np.count_nonzero(region < 0)
    )


def _collect_border_values(volume: ChunkedVolume, chunk: Chunk, values: NDArray[Any]) -> NDArray[Any]:
    """Collect the values of the outermost voxels of a chunk along the border of the volume."""
    found = [values[:0].ravel()]
    for axis, (side, n) in enumerate(zip(chunk.core, volume.grid.shape, strict=True)):
        found += [values.take(0, axis).ravel()] if side.start == 0 else []
        found += [values.take(-1, axis).ravel()] if side.stop == n else []
    return np.concatenate(found)


def find_necks(heights: EdgeHeights, compute: Compute) -> None:
    """Find the necks and threads of each chunk, and store the voxels that they raise."""
    map_chunks(
        compute, partial(_find_chunk_necks, heights), heights.volume.task.store, heights.volume.grid.chunks, _NECKS_KIND
    )


def _find_chunk_necks(heights: EdgeHeights, chunk: Chunk) -> None:
    volume, raised = heights.volume, [np.empty((0, 3), np.int64)]
    levels, normals = volume.load_particles(chunk, chunk.padded, 0.0)
    if len(levels.points):
        found = heights.read_window(tuple(slice(side.start - 1, side.stop + 1) for side in chunk.padded))
        smoothed, begin = volume.smooth_chunk(chunk), np.array([-1, -1, -1])
        around = SaddleSurroundings(
            smoothed, heights.sign, levels.points, heights.sign * normals, levels.slopes, volume.voxel_sides
        )
        ways = bridge_necks(found, begin, around)
        ways += bridge_thin_vessels(found, begin, around, blurred_edge_width(volume.statistics.scaling.smoothing))
        ways = [way + first_pixel(chunk.padded) for way in ways]
        raised += [way for way in ways if volume.grid.find_chunk_numbers(way[len(way) // 2][None]) == chunk.number]
    volume.task.store.save(chunk_file_name(_NECKS_KIND, chunk.number), raised=np.concatenate(raised))


@record
class ChunkedBodies:
    """The bodies of a volume, the largest first, with their measures and stored surfaces.

    Attributes
    ----------
    volume : Volume
        The chunks.
    table : dict of ndarray
        Columns: number, volume and area in units of length, center (plane, row, col) and box [voxels]; of objects
        their confidence.
    first_part : ndarray of int64
        First part of each chunk.
    body_of_part : ndarray of int64
        Number of the body of each part; 0 outside, and in bodies that are split.
    object_numbers : tuple of ndarray of int64
        Numbers of the objects of each chunk; empty where bodies are not split into objects.
    """

    volume: ChunkedVolume
    table: JsonDict
    first_part: Index
    body_of_part: Index
    object_numbers: tuple[Index, ...] = ()

    @property
    def kind(self) -> str:
        """What was found."""
        return OBJECTS_KIND if self.object_numbers else "bodies"

    @property
    def count(self) -> int:
        """Number of bodies."""
        return len(self.table["label"])

    @property
    def grid(self) -> ChunkGrid:
        """The chunks."""
        return self.volume.grid

    @property
    def statistics(self) -> ImageStatistics:
        """What the fields depend on in the whole volume."""
        return self.volume.statistics

    @property
    def regions(self) -> _NumberedRegions:
        """Files of the parts."""
        return _NumberedRegions(self.volume, _PART_ARRAY)

    def load_triangles(self, number: int) -> tuple[Index, Array, Index, Index]:
        """Load the triangles of a chunk that bound bodies.

        Returns the names of the vertices that the chunk owns, shape (N,), and their positions, shape (N, 3) [voxels];
        the names of the corners of each triangle, shape (F, 3), and its body, shape (F,).
        """
        known = self.regions.load_chunk(number)
        body = self._find_bounded_bodies(number, known["pairs"])
        on, faces = body[known["pair_of_vertex"]] > 0, body[known["pair_of_face"]]
        return known["names"][on], known["vertices"][on], known["faces"][faces > 0], faces[faces > 0]

    def _find_bounded_bodies(self, number: int, pairs: Index) -> Index:
        """Find the body that each pair of parts of a chunk bounds; 0 where the surface between them is left out."""
        inside, outside = self.body_of_part[self.first_part[number] + pairs].T
        return np.where(inside != outside, inside, 0)


def assemble_bodies(heights: EdgeHeights, compute: Compute) -> ChunkedBodies:
    """Assemble the bodies of a volume from the height over its edges."""
    volume = heights.volume
    parts = _NumberedRegions(volume, _PART_ARRAY)
    parts.compute_chunks(partial(_number_chunk_parts, parts, heights), compute, "bodies")
    known = [parts.load_chunk(chunk.number, "inside", "rim", "pairs", "sums", "boxes") for chunk in volume.grid.chunks]
    counts = np.array([len(one["inside"]) for one in known])
    first = np.cumsum([0, *counts])
    group = parts.join_regions(counts)
    rim = np.concatenate([one["rim"] + start for one, start in zip(known, first, strict=False)])
    outer, group = group.max(initial=-1) + 1, group.copy()
    group[np.isin(group, group[rim])] = outer  # beyond the border of the volume all outside parts are connected
    inside = np.zeros(outer + 1, bool)
    inside[group] = np.concatenate([one["inside"] for one in known])
    local = np.concatenate([group[one["pairs"] + start] for one, start in zip(known, first, strict=False)])
    pairs, pair = np.unique(local.reshape(-1, 2), axis=0, return_inverse=True)
    sums = np.zeros((len(pairs), 8))
    np.add.at(sums, pair.ravel(), np.concatenate([one["sums"] for one in known]))
    boxes = np.concatenate([one["boxes"] for one in known])
    *measures, corners, supported, particles = sums.T
    kept = has_enough_support(particles.astype(np.int64), supported / np.maximum(corners, 1))
    body = _assign_bodies(pairs, kept, inside, outer)
    bounds = kept & (body[pairs[:, 0]] > 0)
    of = body[pairs[bounds, 0]]
    area, total, *moments = (np.bincount(of, one[bounds], outer + 1) for one in measures)
    order = np.argsort(-total, kind="stable")[: len(np.unique(of))]
    number = np.zeros(outer + 1, np.int64)
    number[order] = np.arange(1, len(order) + 1)
    table = {
        "label": number[order],
        "volume": total[order],
        "area": area[order],
        "center": np.stack([moment[order] / total[order] for moment in moments], axis=1),
        "box": _unite_boxes(boxes, body[local[:, 0]] * kept[pair.ravel()], outer + 1)[order],
    }
    return ChunkedBodies(volume, table, first, number[body[group]])


def _unite_boxes(boxes: Array, group: Index, count: int) -> Array:
    """Unite the boxes, shape (N, 2, 3), of each group, shape (count, 2, 3)."""
    united = np.tile(np.array([[[np.inf], [-np.inf]]]), (count, 1, 3))
    np.minimum.at(united[:, 0], group, boxes[:, 0])
    np.maximum.at(united[:, 1], group, boxes[:, 1])
    return united


def _assign_bodies(pairs: Index, kept: Mask, inside: Mask, outer: int) -> Index:
    """Assign each part to a body, named by one of its parts, 0 outside, where some surfaces are left out.

    From the outside on, each part is entered through one surface; where that is left out, the part belongs to the body
    of the part before. The names are the parts plus one.
    """
    count = len(inside)
    left_out = {tuple(sorted(pair)) for pair in pairs[~kept].tolist()}
    graph = scipy.sparse.csr_array((np.ones(len(pairs)), tuple(pairs.astype(np.int32).T)), shape=(count, count))
    order, before = scipy.sparse.csgraph.breadth_first_order(graph, outer, directed=False)
    body = np.zeros(count, np.int64)
    for part, parent in ((part, before[part]) for part in order[1:].tolist()):
        same = tuple(sorted((part, int(parent)))) in left_out
        body[part] = body[parent] if same else part + 1 if inside[part] else 0
    return body


def _number_chunk_parts(files: _NumberedRegions, heights: EdgeHeights, chunk: Chunk) -> None:
    """Label the parts of a chunk, trace the surface between them, and store both."""
    volume, grid, store = heights.volume, heights.volume.grid, heights.volume.task.store
    # from the first voxel, or from the one before it at the border of the volume, to the one after the last
    window = tuple(slice(side.start - (side.start == 0), side.stop + 1) for side in chunk.core)
    outer = tuple(slice(side.start - 1, side.stop + 1) for side in window)
    found = heights.read_window(outer)
    corner = first_pixel(outer)
    for at in grid.find_neighbors(chunk):
        voxels = store.load(chunk_file_name(_NECKS_KIND, at))["raised"] - corner
        raised = tuple(voxels[lie_inside(voxels, found.shape)].T)
        found[raised] = np.maximum(found[raised], RAISED_HEIGHT)
    bridge_corner_contacts(found, RAISED_HEIGHT)
    found = np.ascontiguousarray(found[1:-1, 1:-1, 1:-1])
    inner, outside = find_connected_parts(found > 0.0, corners=True), find_connected_parts(found <= 0.0, corners=False)
    labels = inner.labels - 1
    outside.fill_voxels(np.arange(inner.count, inner.count + outside.count, dtype=np.int32), labels)
    beyond = relative_window(_extended_core(volume, chunk), window)
    surface = _triangulate_chunk(heights, chunk, found, labels, window)
    files.save_chunk(
        chunk,
        labels[beyond],
        inside=np.arange(inner.count + outside.count) < inner.count,
        rim=np.unique(_collect_border_values(volume, chunk, labels)),
        **surface,
    )


def _triangulate_chunk(heights: EdgeHeights, chunk: Chunk, found: Single, labels: Labels, window: Window) -> JsonDict:
    """Triangulate the surface in a chunk: triangles, and the vertices that it owns.

    The sums for each pair of parts, shape (N, 8), are area, volume and its moments along the axes, and the numbers of
    vertices, of those with a particle near, and of particles.
    """
    volume = heights.volume
    corner, sides = first_pixel(window), np.array(volume.task.source.levels.spacing)
    vertices, faces = zero_surface(found)
    low = np.floor(vertices).astype(np.int64)
    axis = (vertices - low).argmax(axis=1)
    high = low + np.eye(3, dtype=np.int64)[axis]
    above = (found[tuple(low.T)] > 0.0)[:, None]
    ends = (labels[tuple(np.where(above, one, other).T)].astype(np.int64) for one, other in ((low, high), (high, low)))
    pairs, pair = np.unique(np.stack(list(ends), axis=1), axis=0, return_inverse=True)
    pair, vertices = pair.ravel(), vertices + corner
    extent = tuple(n + 2 for n in volume.grid.shape)
    names = np.ravel_multi_index(tuple((low + corner + 1).T), extent) * 3 + axis
    stops = [side.stop for side in chunk.core]
    own = np.flatnonzero((low + corner < stops).all(axis=1))
    own = own[np.argsort(names[own])]
    levels, _ = volume.load_particles(
        chunk, _extended_core(volume, chunk), heights.particle_distance / volume.voxel_sides.min()
    )
    points = (levels.points + first_pixel(chunk.padded)) * volume.voxel_sides
    mine = points[volume.grid.find_chunk_numbers(points / volume.voxel_sides) == chunk.number]
    particles, supported = np.empty(0, np.int64), np.zeros(len(vertices), bool)
    if len(vertices) and len(points):
        particles = pair[scipy.spatial.KDTree(vertices * volume.voxel_sides).query(mine)[1]]
        supported = has_point_within(vertices * volume.voxel_sides, points, heights.particle_distance)
    of_face, (a, b, c), count = pair[faces[:, 0]], (vertices * sides)[faces.T], len(pairs)
    cross, enclosed = np.cross(b - a, c - a), np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    moments = enclosed[:, None] * (a + b + c) / 4.0 / sides
    sums = [
        *(np.bincount(of_face, one, count) for one in (np.linalg.norm(cross, axis=1) / 2.0, enclosed, *moments.T)),
        np.bincount(pair[own], minlength=count),
        np.bincount(pair[own], supported[own], count),
        np.bincount(particles, minlength=count),
    ]
    return {
        "names": names[own],
        "vertices": vertices[own].astype(np.float32),
        "pair_of_vertex": pair[own],
        "faces": names[faces],
        "pair_of_face": of_face,
        "pairs": pairs,
        "boxes": _unite_boxes(vertices[:, None].repeat(2, axis=1), pair, count),
        "sums": np.stack(sums, axis=1),
    }
