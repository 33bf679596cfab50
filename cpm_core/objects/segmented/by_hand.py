"""Objects in an image edited by hand: split in two, by places or along a line, or with a stretch that is redrawn."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import scipy
import skimage

from cpm_core.contours.contour import Contour
from cpm_core.contours.hand_edits import HandEdit, apply
from cpm_core.field.scale_field import ScaleField
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array, Arrays, Index, Line, Mask, Position, frozen
from cpm_core.objects.segmented.areas import area_of, boundary_of, lies_on
from cpm_core.objects.segmented.segmented_object import SegmentedObject
from cpm_core.reconstruction.by_hand.live_wire import on_ridge
from cpm_core.reconstruction.curve.subpixel import ridge_points

_MOST_PIXELS = 40_000
"""Pixels between which the watershed is found; those of a larger object are larger."""

_LEVELS = 24
"""Steps of the landscape of the watershed: what differs by less is flat, and divided halfway."""

_ROOM = 0.4
"""Largest radius of what around a place belongs to it, in the distance to the other one."""

_MARGIN = 4.0
"""Width around the object in which the halves continue, so that what divides them crosses the boundary [px]."""

_BLUR = 2.0
"""Distance from the boundary over which its own edge fades [px]."""

_NEAR, _ON = 2.5, 1.0
"""Distance from an edge up to which a cut moves onto it, and up to which it is on it [px]."""

_STRONG, _MOSTLY = 0.4, 0.6
"""Least strength of such an edge, in that of the boundary, and share of the cut that has to be on edges."""

_SLIDE = 0.3
"""How far the ends of a cut without an edge slide along the boundary to shorten it, in its length."""

_FAR = 1e4
"""Factor by which a line is continued, so that it leaves the object."""

OUTSIDE = "A place lies outside of the object: click in one half of it, then in the other."

_GRID, _DECIMALS = 1e-3, 3
"""Grid to which lines are rounded where they meet [px], and decimals of what is kept."""


@frozen
class Halves:
    """Two objects in place of one, and the lines, each of shape (K, 2) [px], along which it was cut in an image.

    Both have number, name and class of the whole, and no clicks, of which they are not the answer.
    """

    first: SegmentedObject
    second: SegmentedObject
    cuts: Arrays


def split(item: SegmentedObject, first: Position, second: Position, scale_field: ScaleField | None = None) -> Halves:
    """Two objects in place of one, each with one of two places.

    The watershed between the places, by the distance from the boundary and the strength of edges, says where the cut
    is. It follows the edge there; where there is none, it is the shortest straight line near by, a gap.

    Parameters
    ----------
    item : SegmentedObject
        An object in an image.
    first, second : (row, col)
        Places inside it [px].
    scale_field : ScaleField, optional
        Fields of the image; without them there are no edges.

    Returns
    -------
    Halves
        Those of the first and of the second place.

    Raises
    ------
    ValueError
        When a place lies outside, or the two cannot be separated.
    """
    import shapely  # noqa: PLC0415 - needed for few edits

    places, area, edges = np.array([first, second], dtype=float), area_of(item.boundary), _Edges(item, scale_field)
    if not item.encloses(places).all():
        raise ValueError(OUTSIDE)
    low, step, is_second = _watershed(item, places, edges)
    between = skimage.measure.find_contours(is_second.astype(float), 0.5)  # type: ignore[no-untyped-call]
    smooth = [low + step * scipy.ndimage.gaussian_filter1d(line, 2.0, axis=0, mode="nearest") for line in between]
    one, other = shapely.points(places)

    def on_second(face: Any) -> bool:
        pixel = np.rint((np.array(face.representative_point().coords[0]) - low) / step).astype(int)
        return bool(face.contains(other) or (not face.contains(one) and is_second[tuple(pixel)]))

    return _divided(item, [_settled(cut, area, edges) for cut in _within(area, smooth)], on_second, edges)


def split_along(item: SegmentedObject, line: Sequence[Position], scale_field: ScaleField | None = None) -> Halves:
    """Two objects in place of one, on the two sides of a line across it, the larger one first.

    The line continues straight to the boundary, and moves onto an edge next to it; see `split`.
    """
    import shapely  # noqa: PLC0415 - needed for few edits

    path, edges = np.array(line, dtype=float), _Edges(item, scale_field)
    ahead, back = path[min(4, len(path) - 1)] - path[0], path[max(-5, -len(path))] - path[-1]
    if not ahead.any() or not back.any():
        raise ValueError("The line is too short to split an object: draw it across.")
    path = np.concatenate([path[:1] - _FAR * ahead, path, path[-1:] - _FAR * back])
    aside = path.mean(axis=0) + np.array([-1.0, 1.0]) * (path[-1] - path[0])[::-1]
    one_side, drawn = shapely.make_valid(shapely.Polygon([*path, aside])), shapely.LineString(line)
    cuts = [cut for cut in _within(area_of(item.boundary), [path]) if shapely.LineString(cut).distance(drawn) <= _ON]
    cuts = [edges.followed(cut) for cut in cuts]
    found = _divided(item, cuts, lambda face: bool(one_side.contains(face.representative_point())), edges)
    first, second = sorted((found.first, found.second), key=lambda half: -half.area)
    return Halves(first, second, found.cuts)


def redrawn(item: SegmentedObject, contour: Contour, edit: HandEdit, scale_field: ScaleField | None) -> SegmentedObject:
    """An object with an edit by hand carried out on one of the closed curves of its boundary.

    What is added follows the edges of the fields; without them, or where there is none, it is a gap.
    """
    changed = [line_of(one.points) for one in apply((contour,), (edit,))[0] if one.closed]
    rest = [curve for curve in item.boundary if not np.array_equal(curve, contour.points)]
    boundary = boundary_of(area_of([*rest, *changed]))
    return _bounded(item, boundary, [np.array(edit.added)], _Edges(item, scale_field)) if boundary else item


def outlined(item: SegmentedObject, scale_field: ScaleField | None) -> SegmentedObject:
    """An object whose boundary has been drawn by hand, with a gap wherever it follows no edge."""
    closed = [np.array((*curve, curve[0])) for curve in item.boundary]
    return _bounded(item, item.boundary, closed, _Edges(item, scale_field))


def line_of(points: Array) -> Line:
    """A line as objects keep it, rounded."""
    return tuple((row, col) for row, col in np.round(points, _DECIMALS).tolist())


class _Edges:
    """The edges of an image that are strong enough, next to the boundary of an object, to be followed; or none."""

    def __init__(self, item: SegmentedObject, scale_field: ScaleField | None) -> None:
        self._field = scale_field
        along = np.concatenate([polyline.sampled(np.array((*curve, curve[0])), 1.0) for curve in item.boundary])
        self._boundary = max(float(np.median(self._strength(along))), 1e-9)

    def _strength(self, places: Array) -> Array:
        """Strength at places of the image, next to it that at its border."""
        if self._field is None:
            return np.zeros(len(places))
        return self._field.strength(np.clip(places, 0.0, np.array(self._field.shape) - 1.0))

    def heights(self, places: Array) -> Array:
        """Strength at places, in that of the boundary."""
        return self._strength(places) / self._boundary

    def on(self, path: Array) -> Mask:
        """Which vertices lie on the ridge of an edge."""
        if self._field is None:
            return np.zeros(len(path), bool)
        ridge, found = ridge_points(path, self._field)
        strong = self._strength(ridge) >= max(_STRONG * self._boundary, self._field.floor)
        return found & strong & (np.linalg.norm(ridge - path, axis=1) <= _ON)

    def followed(self, cut: Array) -> Array:
        """A line moved onto edges next to it; its ends stay on the boundary."""
        if self._field is None:
            return cut
        moved = on_ridge(cut, self._field)
        keep = self.on(moved) & (polyline.distances(cut, moved) <= _NEAR)
        keep[[0, -1]] = True
        return moved[keep] if keep.sum() > 2 else cut

    def gaps(self, path: Array) -> list[Line]:
        """The stretches of a path that follow no edge."""
        path = polyline.resampled(path, 1.0)
        off = scipy.ndimage.binary_dilation(~self.on(path))
        return [line_of(path[run]) for run in polyline.stretches(off) if len(run) > 1]


def _watershed(item: SegmentedObject, places: Array, edges: _Edges) -> tuple[Array, float, Mask]:
    """Which pixels belong to the second of two places; the first pixel of them, and their distance [px]."""
    low, high = item.box
    low = low - _MARGIN
    extent = high + _MARGIN - low
    step = max(1.0, float(np.sqrt(extent.prod() / _MOST_PIXELS)))
    shape = tuple(np.ceil(extent / step).astype(int).tolist())
    grid = low + step * np.indices(shape).reshape(2, -1).T
    inside = item.encloses(grid).reshape(shape)
    depth = step * scipy.ndimage.distance_transform_edt(np.pad(inside, 1))[1:-1, 1:-1]
    pixels = np.rint((places - low) / step).astype(int)
    smooth = scipy.ndimage.gaussian_filter(depth, 1.0)
    ways = [way_up(smooth, pixel) for pixel in pixels]
    if (ways[0][-1] == ways[1][-1]).all():
        ways = [[pixel] for pixel in pixels]
    seeds, room = np.zeros(shape, np.int32), _ROOM * float(np.linalg.norm(pixels[1] - pixels[0]))
    for number, (pixel, way) in enumerate(zip(pixels, ways, strict=True), start=1):
        away = np.linalg.norm(np.indices(shape) - pixel[:, None, None], axis=0)
        seeds[away < min(room, 0.5 * depth[tuple(pixel)] / step)] = number
        seeds[tuple(np.transpose(way))] = number
    deep = max(min(depth[tuple(way[-1])] for way in ways), step)
    height = np.maximum(edges.heights(grid).reshape(shape) - np.exp(-0.5 * (depth / _BLUR) ** 2), 0.0)
    levels = np.round(_LEVELS * np.clip(height - np.minimum(depth / deep, 1.0), -1.0, 1.0))
    found = skimage.segmentation.watershed(levels, seeds, mask=inside | (seeds > 0))  # type: ignore[no-untyped-call]
    around = scipy.ndimage.distance_transform_edt(found == 0, return_distances=False, return_indices=True)
    return low, step, found[tuple(around)] == 2


def way_up(depth: Array, pixel: Index) -> list[Index]:
    """The pixels, or voxels, from one to where it is deepest around, straight up."""
    steps = np.indices((3,) * len(pixel)).reshape(len(pixel), -1).T - 1
    way = [pixel]
    while True:
        around = way[-1] + steps
        best = around[depth[tuple(around.T)].argmax()]
        if depth[tuple(best)] <= depth[tuple(way[-1])]:
            return way
        way.append(best)


def _within(area: Any, lines: Iterable[Array]) -> list[Array]:
    """The stretches of lines that cross an area from boundary to boundary, each of shape (K, 2)."""
    import shapely  # noqa: PLC0415 - needed for few edits

    crossing = shapely.MultiLineString(list(lines)).intersection(area)
    parts = [part for part in shapely.get_parts(shapely.line_merge(crossing)) if part.geom_type == "LineString"]
    across = (part for part in parts if part.boundary.distance(area.boundary) <= _GRID < part.length)
    return [np.array(part.coords) for part in across]


def _settled(cut: Array, area: Any, edges: _Edges) -> Array:
    """A cut along the edge near it, or straight and as short as possible where there is none."""
    import shapely  # noqa: PLC0415 - needed for few edits

    followed = edges.followed(cut)
    if edges.on(followed).mean() >= _MOSTLY:
        return followed
    slide = _SLIDE * float(np.linalg.norm(cut[-1] - cut[0]))
    ends = [area.boundary.intersection(shapely.Point(end).buffer(slide)) for end in (cut[0], cut[-1])]
    line = shapely.shortest_line(*ends)
    return edges.followed(np.array(line.coords)) if line and area.buffer(_GRID).covers(line) else cut


def _divided(item: SegmentedObject, cuts: Sequence[Array], on_second: Callable[[Any], bool], edges: _Edges) -> Halves:
    """The two objects on the sides of cuts."""
    import shapely  # noqa: PLC0415 - needed for few edits

    area = area_of(item.boundary)
    lines = shapely.union_all([area.boundary, *map(shapely.LineString, cuts)], grid_size=_GRID)
    faces: tuple[list[Any], list[Any]] = [], []
    for face in shapely.get_parts(shapely.polygonize([lines])):
        if area.covers(face.representative_point()):
            faces[on_second(face)].append(face)
    parts = [boundary_of(shapely.union_all(side)) for side in faces]
    if not all(parts):
        raise ValueError("The object is not split: click in both halves, or draw a line from side to side.")
    first, second = (_bounded(item, part, cuts, edges) for part in parts)
    return Halves(first, second, tuple(cuts))


def _bounded(
    item: SegmentedObject, boundary: tuple[Line, ...], drawn: Iterable[Array], edges: _Edges
) -> SegmentedObject:
    """An object with another boundary, to which lines belong that were drawn or cut."""
    gaps = (*item.gaps, *(gap for path in drawn for gap in edges.gaps(path)))
    return replace(item, clicks=(), boundary=boundary, gaps=tuple(gap for gap in gaps if lies_on(gap, boundary)))
