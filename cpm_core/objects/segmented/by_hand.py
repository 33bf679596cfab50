"""Objects in an image edited by hand: split in two, by places or along a line, or with a stretch that is redrawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy
import skimage

from cpm_core.contours.contour import Contour
from cpm_core.contours.hand_edits import HandEdit, apply
from cpm_core.field.scale_field import ScaleField
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array, Mask, Position
from cpm_core.objects.segmented.areas import area_of, boundary_of, lies_on
from cpm_core.objects.segmented.segmented_object import Line, SegmentedObject
from cpm_core.reconstruction.by_hand.live_wire import on_ridge


@dataclass(frozen=True, slots=True)
class Halves:
    """Two objects in place of one, and the lines, each of shape (K, 2) [px], along which it was cut.

    Both have number, name and class of the whole, and no clicks, of which they are not the answer.
    """

    first: SegmentedObject
    second: SegmentedObject
    cuts: tuple[Array, ...]


_MOST_PIXELS = 40_000
"""Pixels between which the watershed is found; of a larger object every second, third ... is taken."""

_LEVELS = 24
"""Steps of the landscape of the watershed: what differs by less is flat, and divided halfway."""

_NEAR = 2.5
"""Distance from an edge up to which the cut follows it [px]."""

_STRONG, _MOSTLY = 0.4, 0.6
"""Least strength of such an edge, in that of the boundary, and share of the cut that has to lie near edges."""

_ON = 1.0
"""Distance from the ridge of an edge up to which the cut is on it [px]."""

_BLUR = 2.0
"""Distance from the boundary over which its own edge fades [px]."""

_SLIDE, _FARTHEST = 0.5, 24.0
"""How far the ends of a cut without an edge slide along the boundary to shorten it, in its length and at most [px]."""

_SPACING = 0.5
"""Distance between the places that are compared [px]."""

_BEYOND = 1e-3
"""Length by which a cut passes the boundary [px]."""


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
    places = np.array([first, second], dtype=float)
    if not item.encloses(places).all():
        raise ValueError("A place lies outside of the object: click in one half of it, then in the other.")
    side = _Sides(item, places, scale_field)
    area = area_of(item.boundary)
    level = _level(item, scale_field)
    cuts = [_settled(cut, item, scale_field, level) for cut in _within(area, side.lines)]
    return _divided(item, area, cuts, side, scale_field, level)


def split_along(item: SegmentedObject, line: Sequence[Position], scale_field: ScaleField | None = None) -> Halves:
    """Two objects in place of one, on the two sides of a line across it, the larger one first.

    The line continues straight to the boundary, and moves onto an edge next to it; see `split`.
    """
    import shapely  # noqa: PLC0415 - needed for few edits

    path = np.array(line, dtype=float)
    if polyline.length(path) < _SPACING:
        raise ValueError("The line is too short to split an object: draw it across.")
    area, level = area_of(item.boundary), _level(item, scale_field)
    low, top, high, bottom = area.bounds
    far = float(np.hypot(high - low, bottom - top))
    path = np.concatenate([path[:1] - far * _direction(path), path, path[-1:] - far * _direction(path[::-1])])
    drawn = shapely.LineString(line)
    cuts = [cut for cut in _within(area, [path]) if shapely.LineString(cut).distance(drawn) <= _ON]
    cuts = [cut if scale_field is None else _on_edges(cut, scale_field, level) for cut in cuts]
    halves = _divided(item, area, cuts, _Across(path), scale_field, level)
    larger = halves.first.area >= halves.second.area
    return halves if larger else replace(halves, first=halves.second, second=halves.first)


def redrawn(
    item: SegmentedObject, contour: Contour, edit: HandEdit, scale_field: ScaleField | None = None
) -> SegmentedObject:
    """An object with an edit by hand carried out on one of the closed curves of its boundary.

    Parameters
    ----------
    item : SegmentedObject
        The object.
    contour : Contour
        The curve that is edited.
    edit : HandEdit
        A stretch in place of another one.
    scale_field : ScaleField, optional
        Fields of the image that the stretch follows; the rest of it, or without them all of it, is a gap.
    """
    changed = [one for one in apply((contour,), (edit,))[0] if one.closed]
    rest = [curve for curve in item.boundary if not np.array_equal(curve, contour.points)]
    boundary = boundary_of(area_of([*rest, *(tuple(map(tuple, one.points.tolist())) for one in changed)]))
    if not boundary:
        return item
    gaps = _gaps(np.array(edit.added), scale_field, _level(item, scale_field))
    return replace(
        item, clicks=(), boundary=boundary, gaps=tuple(gap for gap in (*item.gaps, *gaps) if lies_on(gap, boundary))
    )


def _direction(path: Array) -> Array:
    """The direction in which a path begins, over some px."""
    ahead = polyline.places_at(path, np.array([min(4.0, polyline.length(path))]))[0] - path[0]
    size = float(np.linalg.norm(ahead))
    return np.asarray(ahead / size if size > 0.0 else path[-1] - path[0])


class _Sides:
    """The watershed between two places in an object: which of the two a place belongs to, and the lines between."""

    def __init__(self, item: SegmentedObject, places: Array, scale_field: ScaleField | None) -> None:
        corners = np.concatenate([np.asarray(curve) for curve in item.boundary])
        self._low = np.floor(corners.min(axis=0)) - 1.0
        extent = np.ceil(corners.max(axis=0)) + 2.0 - self._low
        self._step = max(1.0, float(np.sqrt(extent.prod() / _MOST_PIXELS)))
        shape = np.ceil(extent / self._step).astype(int)
        grid = self._low + self._step * np.indices(shape).reshape(2, -1).T
        inside = item.encloses(grid).reshape(shape)
        pixels = [tuple(pixel) for pixel in self._pixels(places).tolist()]
        inside[tuple(np.transpose(pixels))] = True
        depth = scipy.ndimage.distance_transform_edt(np.pad(inside, 1))[1:-1, 1:-1]
        ways = [_way_up(scipy.ndimage.gaussian_filter(depth, 1.0), pixel) for pixel in pixels]
        if ways[0][-1] == ways[1][-1]:
            ways = [[pixel] for pixel in pixels]
        seeds = np.zeros(shape, np.int32)
        for number, way in enumerate(ways, start=1):
            seeds[tuple(np.transpose(way))] = number
        height = -np.minimum(depth / min(depth[way[-1]] for way in ways), 1.0)
        if scale_field is not None:
            edges = _strength(grid, scale_field).reshape(shape) * _STRONG / _level(item, scale_field)
            height += np.maximum(edges - np.exp(-0.5 * (self._step * depth / _BLUR) ** 2), 0.0)
        levels = np.round(_LEVELS * np.clip(height, -1.0, 1.0))
        found = skimage.segmentation.watershed(levels, seeds, mask=inside)  # type: ignore[no-untyped-call]
        nearest = scipy.ndimage.distance_transform_edt(found == 0, return_distances=False, return_indices=True)
        self._second = found[tuple(nearest)] == 2
        between = skimage.measure.find_contours(self._second.astype(float), 0.5)  # type: ignore[no-untyped-call]
        smooth = [scipy.ndimage.gaussian_filter1d(line, 2.0, axis=0, mode="nearest") for line in between]
        self.lines = [self._low + self._step * line for line in smooth]

    def _pixels(self, places: Array) -> Any:
        return np.rint((places - self._low) / self._step).astype(int)

    def __call__(self, places: Array) -> Mask:
        """Which places belong to the second."""
        pixels = np.clip(self._pixels(places), 0, np.array(self._second.shape) - 1)
        return np.asarray(self._second[tuple(pixels.T)])


def _way_up(depth: Array, pixel: tuple[int, ...]) -> list[tuple[int, ...]]:
    """The pixels from one to where it is deepest around, straight up."""
    way = [pixel]
    while True:
        row, col = way[-1]
        low, left = max(row - 1, 0), max(col - 1, 0)
        around = depth[low : row + 2, left : col + 2]
        up, right = np.unravel_index(int(around.argmax()), around.shape)
        if depth[row, col] >= around[up, right]:
            return way
        way.append((low + int(up), left + int(right)))


class _Across:
    """Which side of a line places lie on."""

    def __init__(self, path: Array) -> None:
        self._path = path

    def __call__(self, places: Array) -> Mask:
        """Which places lie on its left."""
        begin, along = self._path[:-1], np.diff(self._path, axis=0)
        share = ((places[:, None] - begin) * along).sum(axis=2) / np.maximum((along**2).sum(axis=1), 1e-12)
        off = places[:, None] - begin - np.clip(share, 0.0, 1.0)[..., None] * along
        near = (off**2).sum(axis=2).argmin(axis=1)
        aside = off[np.arange(len(places)), near]
        return np.asarray(along[near, 0] * aside[:, 1] - along[near, 1] * aside[:, 0] > 0.0)


def _within(area: Any, lines: Sequence[Array]) -> list[Array]:
    """The stretches of lines that cross an area from boundary to boundary, each of shape (K, 2)."""
    import shapely  # noqa: PLC0415 - needed for few edits

    cut = shapely.line_merge(shapely.MultiLineString(list(lines)).intersection(area)) if lines else None
    parts = [part for part in shapely.get_parts(cut) if part.geom_type == "LineString"]
    paths = [np.array(part.coords) for part in parts]
    ends = [shapely.MultiPoint(path[[0, -1]]).geoms for path in paths]
    return [
        path
        for path, both in zip(paths, ends, strict=True)
        if all(area.boundary.distance(end) <= _BEYOND for end in both) and polyline.length(path) > _BEYOND
    ]


def _level(item: SegmentedObject, scale_field: ScaleField | None) -> float:
    """Strength from which an edge inside is followed."""
    if scale_field is None:
        return np.inf
    along = np.concatenate([polyline.sampled(np.array((*curve, curve[0])), 1.0) for curve in item.boundary])
    return max(_STRONG * float(np.median(_strength(along, scale_field))), scale_field.floor, 1e-9)


def _strength(places: Array, scale_field: ScaleField) -> Array:
    """Strength of edges at places of the image, next to it that of its border."""
    return scale_field.strength(np.clip(places, 0.0, np.array(scale_field.shape) - 1.0))


def _settled(cut: Array, item: SegmentedObject, scale_field: ScaleField | None, level: float) -> Array:
    """A cut along the edge near it, or straight and as short as possible where there is none."""
    if scale_field is not None:
        followed = _on_edges(cut, scale_field, level)
        if _on(followed, scale_field, level).mean() >= _MOSTLY:
            return followed
    straight = _shortest(cut, item)
    return straight if scale_field is None else _on_edges(straight, scale_field, level)


def _on_edges(cut: Array, scale_field: ScaleField, level: float) -> Array:
    """A cut moved onto strong edges next to it; its ends stay on the boundary."""
    path = polyline.resampled(cut, 1.0)
    if len(path) < 4:
        return cut
    moved = on_ridge(path, scale_field)
    strong = _on(moved, scale_field, level)
    if not strong[1:-1].any():
        return cut
    away = polyline.distances(cut, moved)
    keep = strong & (away <= _NEAR)
    keep[[0, -1]] = True
    return np.asarray(moved[keep])


def _on(path: Array, scale_field: ScaleField, level: float) -> Mask:
    """Which vertices lie on the ridge of an edge that is strong enough."""
    from cpm_core.reconstruction.curve.subpixel import ridge_points  # noqa: PLC0415

    ridge, found = ridge_points(path, scale_field)
    return np.asarray(found & (np.linalg.norm(ridge - path, axis=1) <= _ON) & (_strength(ridge, scale_field) >= level))


def _shortest(cut: Array, item: SegmentedObject) -> Array:
    """The shortest straight line through the object with ends near those of a cut."""
    import shapely  # noqa: PLC0415 - needed for few edits

    slide = min(max(_SLIDE * polyline.length(cut), 2.0), _FARTHEST)
    near = [_along(item, end, slide) for end in (cut[0], cut[-1])]
    length = np.linalg.norm(near[0][:, None] - near[1], axis=2)
    moved = sum(
        0.01 * np.linalg.norm(some - end, axis=1).reshape(shape)
        for some, end, shape in zip(near, (cut[0], cut[-1]), ((-1, 1), (1, -1)), strict=True)
    )
    area = area_of(item.boundary).buffer(1.5 * _BEYOND)
    for index in np.argsort(length + moved, axis=None)[:400:8].tolist():
        one, other = np.unravel_index(index, length.shape)
        line = np.array([near[0][one], near[1][other]])
        if area.covers(shapely.LineString(line)):
            return line
    return cut


def _along(item: SegmentedObject, place: Array, slide: float) -> Array:
    """Places of the boundary up to so far from one on it, along the curve, shape (K, 2) [px]."""
    paths = [np.array((*curve, curve[0])) for curve in item.boundary]
    path = min(paths, key=lambda path: polyline.distances(path, place[None])[0])
    whole = polyline.length(path)
    count = max(8, int(np.ceil(whole / _SPACING)))
    around = polyline.places_at(path, np.arange(count) * whole / count)
    at = int(np.linalg.norm(around - place, axis=1).argmin())
    reach = min(int(slide * count / whole), count // 4)
    return np.concatenate([place[None], around[np.arange(at - reach, at + reach + 1) % count]])


def _divided(
    item: SegmentedObject, area: Any, cuts: Sequence[Array], side: Any, scale_field: ScaleField | None, level: float
) -> Halves:
    """The two objects on the sides of cuts."""
    import shapely  # noqa: PLC0415 - needed for few edits

    lines = [shapely.LineString(_longer(cut)) for cut in cuts]
    edges = shapely.unary_union([area.boundary, *lines])
    faces = [
        face for face in shapely.get_parts(shapely.polygonize([edges])) if area.covers(face.representative_point())
    ]
    second = [float(side(_samples(face)).mean()) > 0.5 for face in faces]
    parts = [
        boundary_of(shapely.union_all([face for face, on in zip(faces, second, strict=True) if on is which]))
        for which in (False, True)
    ]
    if not all(parts):
        raise ValueError("The object is not split: click in both halves, or draw a line from side to side.")
    gaps = [gap for cut in cuts for gap in _gaps(cut, scale_field, level)]
    one, other = (
        replace(item, clicks=(), boundary=part, gaps=tuple(gap for gap in (*item.gaps, *gaps) if lies_on(gap, part)))
        for part in parts
    )
    return Halves(one, other, tuple(cuts))


def _longer(cut: Array) -> Array:
    """A cut that passes the boundary on both sides."""
    begin, end = cut[0] - cut[1], cut[-1] - cut[-2]
    over = [_BEYOND * way / max(float(np.linalg.norm(way)), 1e-12) for way in (begin, end)]
    return np.concatenate([cut[:1] + over[0], cut[1:-1], cut[-1:] + over[1]])


def _samples(face: Any) -> Array:
    """Places inside of a polygon, shape (K, 2)."""
    import shapely  # noqa: PLC0415 - needed for few edits

    low, top, high, bottom = face.bounds
    grid = np.stack(np.meshgrid(np.linspace(low, high, 14)[1:-1], np.linspace(top, bottom, 14)[1:-1]), axis=-1)
    places = grid.reshape(-1, 2)
    inside = places[shapely.contains_xy(face, places)]
    return inside if len(inside) else np.array(face.representative_point().coords)


def _gaps(cut: Array, scale_field: ScaleField | None, level: float) -> list[Line]:
    """The stretches of a cut that follow no edge."""
    path = polyline.resampled(cut, 1.0)
    off = np.ones(len(path), np.bool_) if scale_field is None else ~_on(path, scale_field, level)
    off |= scipy.ndimage.binary_dilation(off)
    rounded = np.round(path, 3)
    return [tuple(map(tuple, rounded[run].tolist())) for run in polyline.stretches(off) if len(run) > 1]
