"""Objects in an image edited by hand: split by points or along a line, or with a stretch of boundary redrawn."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import scipy
import skimage

from cpm_core.field.scale_field import ScaleField
from cpm_core.image.region import Region
from cpm_core.numerics import polyline
from cpm_core.numerics.grids import flood_from_markers, measure_depth, spread_labels
from cpm_core.numerics.types import Array, Arrays, Index, Line, Mask, Position, frozen
from cpm_core.objects.segmented.areas import BOUNDARY_DECIMALS, boundary_from_polygon, lies_on, polygon_from_boundary
from cpm_core.objects.segmented.segmented_object import SegmentedObject
from cpm_core.reconstruction.by_hand.live_wire import snap_path_to_ridge
from cpm_core.reconstruction.by_hand.redrawing import RedrawnCurve
from cpm_core.reconstruction.curve.subpixel import refine_to_ridge

_MAX_WATERSHED_PIXELS = 40_000
"""Largest number of pixels of the watershed; those of a larger object are larger."""

_LANDSCAPE_LEVELS = 24
"""Levels of the landscape of the watershed: smaller differences are flat, and divided halfway."""

_MAX_SEED_RADIUS = 0.4
"""Largest radius of the seed around a point, as a fraction of the distance to the other point."""

_HALVES_MARGIN = 4.0
"""Width around the object into which the halves continue, so that the cut crosses the boundary [px]."""

_BOUNDARY_EDGE_WIDTH = 2.0
"""Distance from the boundary over which its own edge fades [px]."""

_SNAP_TO_EDGE_DISTANCE = 2.5
"""Distance from an edge up to which a cut moves onto it [px]."""

_CUT_ON_EDGE_DISTANCE = 1.0
"""Distance from an edge up to which a cut is on it [px]."""

_MIN_CUT_STRENGTH = 0.4
"""Least strength of the edge along a cut, as a fraction of the strength along the boundary."""

_MIN_EDGE_SHARE = 0.6
"""Least share of a cut that lies on edges."""

_MAX_END_SLIDE = 0.3
"""How far the ends of a cut without an edge slide along the boundary to shorten it, in its length."""

_LINE_EXTENSION = 1e4
"""Factor by which a line is extended, so that it leaves the object."""

POINT_OUTSIDE = "A place lies outside of the object: click in one half of it, then in the other."

_LINE_GRID = 1e-3
"""Grid to which lines are rounded where they meet [px]."""


@frozen
class Halves:
    """Two objects that replace one, and the lines, each of shape (K, 2) [px], along which it was cut in an image.

    Both have the number, name and class of the whole, but no clicks, as they do not follow from these.
    """

    first: SegmentedObject
    second: SegmentedObject
    cuts: Arrays


def split_object(
    item: SegmentedObject, first: Position, second: Position, scale_field: ScaleField | None = None
) -> Halves:
    """Split an object into two, each with one of two points.

    The watershed between the points, by the distance from the boundary and the strength of edges, decides where the cut
    is. It follows the edge there; without an edge, it is the shortest straight line near by, a gap.

    Parameters
    ----------
    item : SegmentedObject
        An object in an image.
    first, second : (row, col)
        Points inside it [px].
    scale_field : ScaleField, optional
        Fields of the image; without them there are no edges.

    Returns
    -------
    Halves
        The halves with the first and with the second point.

    Raises
    ------
    ValueError
        When a point lies outside, or the two cannot be separated.
    """
    import shapely  # noqa: PLC0415 - needed for few edits

    places, area, edges = (
        np.array([first, second], dtype=float),
        polygon_from_boundary(item.region.boundary),
        _ObjectEdges(item, scale_field),
    )
    if not item.region.encloses(places).all():
        raise ValueError(POINT_OUTSIDE)
    low, step, is_second = _split_by_watershed(item, places, edges)
    between = skimage.measure.find_contours(is_second.astype(float), 0.5)  # type: ignore[no-untyped-call]
    smooth = [low + step * scipy.ndimage.gaussian_filter1d(line, 2.0, axis=0, mode="nearest") for line in between]
    one, other = shapely.points(places)

    def is_on_second_side(face: Any) -> bool:
        pixel = np.rint((np.array(face.representative_point().coords[0]) - low) / step).astype(int)
        return bool(face.contains(other) or (not face.contains(one) and is_second[tuple(pixel)]))

    return _divide_object(
        item, [_refine_cut(cut, area, edges) for cut in _clip_to_area(area, smooth)], is_on_second_side, edges
    )


def split_object_along(
    item: SegmentedObject, line: Sequence[Position], scale_field: ScaleField | None = None
) -> Halves:
    """Split an object along a line across it; the larger half comes first.

    The line, shape (K, 2) [px], is extended straight to the boundary, and moves onto an edge next to it; see
    `split_object`.
    """
    import shapely  # noqa: PLC0415 - needed for few edits

    path, edges = np.array(line, dtype=float), _ObjectEdges(item, scale_field)
    ahead, back = path[min(4, len(path) - 1)] - path[0], path[max(-5, -len(path))] - path[-1]
    if not ahead.any() or not back.any():
        raise ValueError("The line is too short to split an object: draw it across.")
    path = np.concatenate([path[:1] - _LINE_EXTENSION * ahead, path, path[-1:] - _LINE_EXTENSION * back])
    aside = path.mean(axis=0) + np.array([-1.0, 1.0]) * (path[-1] - path[0])[::-1]
    one_side, drawn = shapely.make_valid(shapely.Polygon([*path, aside])), shapely.LineString(line)
    cuts = [
        cut
        for cut in _clip_to_area(polygon_from_boundary(item.region.boundary), [path])
        if shapely.LineString(cut).distance(drawn) <= _CUT_ON_EDGE_DISTANCE
    ]
    cuts = [edges.snap_to_edges(cut) for cut in cuts]
    found = _divide_object(item, cuts, lambda face: bool(one_side.contains(face.representative_point())), edges)
    first, second = sorted((found.first, found.second), key=lambda half: -half.region.size)
    return Halves(first, second, found.cuts)


def redraw_boundary(
    item: SegmentedObject, index: int, redrawn: RedrawnCurve, scale_field: ScaleField | None
) -> SegmentedObject:
    """Replace the curve of a boundary with an index, or the line of an open object, by one with a redrawn stretch.

    Where the stretch follows no edge of the fields, it is a gap. An object stays as it was if nothing of it is left.
    """
    curve = round_line(redrawn.points)
    if item.line:
        return replace(item, line=curve, confidence=0.0)
    curves = [*item.region.boundary[:index], curve, *item.region.boundary[index + 1 :]]
    boundary = boundary_from_polygon(polygon_from_boundary(curves))
    return _replace_boundary(item, boundary, [redrawn.drawn], _ObjectEdges(item, scale_field)) if boundary else item


def mark_gaps(item: SegmentedObject, scale_field: ScaleField | None) -> SegmentedObject:
    """Mark as gaps the stretches of a boundary drawn by hand that follow no edge."""
    closed = [np.array((*curve, curve[0])) for curve in item.region.boundary]
    return _replace_boundary(item, item.region.boundary, closed, _ObjectEdges(item, scale_field))


def round_line(points: Array) -> Line:
    """Round a line, shape (K, 2) [px], to the decimals that objects keep."""
    return tuple((row, col) for row, col in np.round(points, BOUNDARY_DECIMALS).tolist())


class _ObjectEdges:
    """The edges along the boundary of an object that are strong enough to be followed; none without fields."""

    def __init__(self, item: SegmentedObject, scale_field: ScaleField | None) -> None:
        self._field = scale_field
        along = np.concatenate(
            [polyline.sample_path(np.array((*curve, curve[0])), 1.0) for curve in item.region.boundary]
        )
        self._boundary = max(float(np.median(self._measure_strength(along))), 1e-9)

    def _measure_strength(self, places: Array) -> Array:
        """Measure the edge strength at points of the image, shape (N,); beyond the border as at the border."""
        if self._field is None:
            return np.zeros(len(places))
        return self._field.strength_at(np.clip(places, 0.0, np.array(self._field.shape) - 1.0))

    def measure_relative_strength(self, places: Array) -> Array:
        """Measure the edge strength at points, shape (N, 2) [px], relative to that along the boundary, shape (N,)."""
        return self._measure_strength(places) / self._boundary

    def find_vertices_on_edge(self, path: Array) -> Mask:
        """Return which vertices of a path, shape (K, 2) [px], lie on the ridge of an edge, shape (K,)."""
        if self._field is None:
            return np.zeros(len(path), bool)
        ridge, found = refine_to_ridge(path, self._field)
        strong = self._measure_strength(ridge) >= max(_MIN_CUT_STRENGTH * self._boundary, self._field.floor)
        return found & strong & (np.linalg.norm(ridge - path, axis=1) <= _CUT_ON_EDGE_DISTANCE)

    def snap_to_edges(self, cut: Array) -> Array:
        """Snap a line, shape (K, 2) [px], to edges next to it; its ends stay on the boundary."""
        if self._field is None:
            return cut
        moved = snap_path_to_ridge(cut, self._field)
        keep = self.find_vertices_on_edge(moved) & (polyline.distances_to_path(cut, moved) <= _SNAP_TO_EDGE_DISTANCE)
        keep[[0, -1]] = True
        return moved[keep] if keep.sum() > 2 else cut

    def find_gaps(self, path: Array) -> list[Line]:
        """Find the stretches of a path, shape (K, 2) [px], that follow no edge."""
        path = polyline.resample_path(path, 1.0)
        off = scipy.ndimage.binary_dilation(~self.find_vertices_on_edge(path))
        return [round_line(path[run]) for run in polyline.find_marked_runs(off) if len(run) > 1]


def _split_by_watershed(item: SegmentedObject, places: Array, edges: _ObjectEdges) -> tuple[Array, float, Mask]:
    """Divide an object by a watershed between two points.

    Returns the first pixel, the distance of the pixels [px], and which of them belong to the second point.
    """
    low, high = item.box
    low = low - _HALVES_MARGIN
    extent = high + _HALVES_MARGIN - low
    step = max(1.0, float(np.sqrt(extent.prod() / _MAX_WATERSHED_PIXELS)))
    shape = tuple(np.ceil(extent / step).astype(int).tolist())
    grid = low + step * np.indices(shape).reshape(2, -1).T
    inside = item.region.encloses(grid).reshape(shape)
    depth = step * measure_depth(inside)
    pixels = np.rint((places - low) / step).astype(int)
    smooth = scipy.ndimage.gaussian_filter(depth, 1.0)
    ways = [climb_to_peak(smooth, pixel) for pixel in pixels]
    if (ways[0][-1] == ways[1][-1]).all():
        ways = [[pixel] for pixel in pixels]
    seeds, room = np.zeros(shape, np.int32), _MAX_SEED_RADIUS * float(np.linalg.norm(pixels[1] - pixels[0]))
    for number, (pixel, way) in enumerate(zip(pixels, ways, strict=True), start=1):
        away = np.linalg.norm(np.indices(shape) - pixel[:, None, None], axis=0)
        seeds[away < min(room, 0.5 * depth[tuple(pixel)] / step)] = number
        seeds[tuple(np.transpose(way))] = number
    deep = max(min(depth[tuple(way[-1])] for way in ways), step)
    height = np.maximum(
        edges.measure_relative_strength(grid).reshape(shape) - np.exp(-0.5 * (depth / _BOUNDARY_EDGE_WIDTH) ** 2), 0.0
    )
    levels = np.round(_LANDSCAPE_LEVELS * np.clip(height - np.minimum(depth / deep, 1.0), -1.0, 1.0))
    found = flood_from_markers(levels, seeds, inside | (seeds > 0))
    return low, step, spread_labels(found) == 2


def climb_to_peak(depth: Array, pixel: Index) -> list[Index]:
    """Climb from a pixel, or a voxel, shape (D,), steepest ascent, to a peak of `depth`; return all on the way."""
    steps = np.indices((3,) * len(pixel)).reshape(len(pixel), -1).T - 1
    way = [pixel]
    while True:
        around = way[-1] + steps
        best = around[depth[tuple(around.T)].argmax()]
        if depth[tuple(best)] <= depth[tuple(way[-1])]:
            return way
        way.append(best)


def _clip_to_area(area: Any, lines: Iterable[Array]) -> list[Array]:
    """Clip lines to the stretches that cross an area from boundary to boundary, each of shape (K, 2)."""
    import shapely  # noqa: PLC0415 - needed for few edits

    crossing = shapely.MultiLineString(list(lines)).intersection(area)
    parts = [part for part in shapely.get_parts(shapely.line_merge(crossing)) if part.geom_type == "LineString"]
    across = (part for part in parts if part.boundary.distance(area.boundary) <= _LINE_GRID < part.length)
    return [np.array(part.coords) for part in across]


def _refine_cut(cut: Array, area: Any, edges: _ObjectEdges) -> Array:
    """Refine a cut: along the edge near it, or straight and as short as possible where there is none."""
    import shapely  # noqa: PLC0415 - needed for few edits

    followed = edges.snap_to_edges(cut)
    if edges.find_vertices_on_edge(followed).mean() >= _MIN_EDGE_SHARE:
        return followed
    slide = _MAX_END_SLIDE * float(np.linalg.norm(cut[-1] - cut[0]))
    ends = [area.boundary.intersection(shapely.Point(end).buffer(slide)) for end in (cut[0], cut[-1])]
    line = shapely.shortest_line(*ends)
    return edges.snap_to_edges(np.array(line.coords)) if line and area.buffer(_LINE_GRID).covers(line) else cut


def _divide_object(
    item: SegmentedObject, cuts: Sequence[Array], on_second: Callable[[Any], bool], edges: _ObjectEdges
) -> Halves:
    """Divide an object into the two on the sides of cuts."""
    import shapely  # noqa: PLC0415 - needed for few edits

    area = polygon_from_boundary(item.region.boundary)
    lines = shapely.union_all([area.boundary, *map(shapely.LineString, cuts)], grid_size=_LINE_GRID)
    faces: tuple[list[Any], list[Any]] = [], []
    for face in shapely.get_parts(shapely.polygonize([lines])):
        if area.covers(face.representative_point()):
            faces[on_second(face)].append(face)
    parts = [boundary_from_polygon(shapely.union_all(side)) for side in faces]
    if not all(parts):
        raise ValueError("The object is not split: click in both halves, or draw a line from side to side.")
    first, second = (_replace_boundary(item, part, cuts, edges) for part in parts)
    return Halves(first, second, tuple(cuts))


def _replace_boundary(
    item: SegmentedObject, boundary: tuple[Line, ...], drawn: Iterable[Array], edges: _ObjectEdges
) -> SegmentedObject:
    """Replace the boundary of an object, along lines that were drawn or cut."""
    gaps = (*item.gaps, *(gap for path in drawn for gap in edges.find_gaps(path)))
    return item.redrawn(Region(boundary), tuple(gap for gap in gaps if lies_on(gap, boundary)))
