"""Areas of objects as polygons: painting with a round brush, and uniting objects, in an image and in a volume."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import scipy

from cpm_core.contours.surface_agreement import TriangleSamples
from cpm_core.image.region import Region
from cpm_core.image.surface import Surface
from cpm_core.numerics import polyline
from cpm_core.numerics.grids import zero_surface
from cpm_core.numerics.polyline import as_line
from cpm_core.numerics.types import Array, Extent, Index, Line, Position
from cpm_core.objects.segmented.segmented_object import SegmentedObject

_DISTANCE_MARGIN = 3
"""Width around the surfaces in which distances are computed [voxels]."""

_EXACT_DISTANCE = 2.5
"""Distance from a surface up to which the distance of a voxel is exact [voxels]."""

_BLENDING_RANGE = 2.0
"""Range of distances that are blended [voxels]: a slit between objects up to half as wide is closed."""


def unite_bodies(first: Region, second: Region) -> Region:
    """Unite two regions of a volume: their voxels, if one of them has been painted, else one surface around both.

    Surfaces that do not come near each other stay as they are. Otherwise the result is the zero of the smaller of the
    signed distances from the two; between surfaces that face each other the distances are blended by the polynomial
    smooth minimum (I. Quilez, 2013), which closes the slit between objects that touch.
    """
    one, other = first.surface, second.surface
    if one is None or other is None or first.pixels or second.pixels:
        return first.united(second)
    low = np.minimum(one.vertices.min(axis=0), other.vertices.min(axis=0))
    high = np.maximum(one.vertices.max(axis=0), other.vertices.max(axis=0))
    begin = np.floor(low).astype(np.int64) - _DISTANCE_MARGIN
    shape = tuple((np.ceil(high).astype(np.int64) + _DISTANCE_MARGIN + 1 - begin).tolist())
    here, there = _signed_distance(first, one, begin, shape), _signed_distance(second, other, begin, shape)
    if not ((here <= _BLENDING_RANGE) & (there <= _BLENDING_RANGE)).any():
        faces = np.concatenate([one.faces, other.faces + len(one.vertices)])
        return Region.from_surface(Surface(np.concatenate([one.vertices, other.vertices]), faces))
    blend = np.maximum(_BLENDING_RANGE - np.abs(here - there), 0.0)
    facing = -sum(a * b for a, b in zip(np.gradient(here), np.gradient(there), strict=True))
    level = np.minimum(here, there) - np.clip(facing, 0.0, 1.0) * blend**2 / (4.0 * _BLENDING_RANGE)
    vertices, triangles = zero_surface(-level.astype(np.float32))
    return Region.from_surface(Surface(vertices + begin, triangles))


def _signed_distance(region: Region, surface: Surface, begin: Index, shape: Extent) -> Array:
    """Compute the signed distance of voxels from a surface, negative inside, exact near it, of `shape` [voxels]."""
    inside = region.cut_out(tuple(map(slice, begin, begin + shape)))
    away = np.where(inside, scipy.ndimage.distance_transform_edt(inside), scipy.ndimage.distance_transform_edt(~inside))
    near = away <= _EXACT_DISTANCE
    triangles = TriangleSamples((surface.vertices - begin)[surface.faces])
    away = np.maximum(away - 0.5, 0.5)
    away[near] = triangles.distances_to(np.argwhere(near).astype(float))
    return np.where(inside, -away, away)


_MIN_RING_AREA = 0.5
"""Area below which an island or a hole is a remainder [px²]."""

_BRUSH_SEGMENTS = 32
"""Sides of a quarter of the outline of the brush."""

_MAX_SLIT_WIDTH = 1.5
"""Width of a slit between objects up to which it is closed when they are united [px]."""

_BOUNDARY_GAP_TOLERANCE = 1.0
"""Distance from the boundary up to which a gap still belongs to it [px]."""

BOUNDARY_DECIMALS = 3
"""Decimals of the vertices of a boundary that an object keeps [px]."""


def paint_boundary(
    boundary: Sequence[Line],
    path: Sequence[Position],
    radius: float,
    adds: bool,
    shape: Extent,
    limits: Iterable[Sequence[Line]] = (),
) -> tuple[Line, ...]:
    """Add to the boundary of an area, or remove from it, what a disk of a radius covers along a path [px].

    Away from the brush the vertices stay as they were. What is added ends at the border of the image, and at the
    boundaries in `limits`.
    """
    import shapely  # noqa: PLC0415 - needed for few edits

    way = shapely.LineString(path) if len(path) > 1 else shapely.Point(path[0])
    brush, area = way.buffer(radius, quad_segs=_BRUSH_SEGMENTS), polygon_from_boundary(boundary)
    if not adds:
        return boundary_from_polygon(area.difference(brush)) if area.intersects(brush) else tuple(boundary)
    within = brush.intersection(shapely.box(-0.5, -0.5, shape[0] - 0.5, shape[1] - 0.5))
    for limit in limits:
        within = within.difference(polygon_from_boundary(limit))
    return tuple(boundary) if within.is_empty else boundary_from_polygon(area.union(within))


def unite_objects(first: SegmentedObject, second: SegmentedObject) -> SegmentedObject:
    """Unite two objects; a slit between them where they touch is closed.

    Returns
    -------
    SegmentedObject
        The first object with the boundary and the positive clicks of both, the gaps that still lie on the boundary, the
        mean of their strength weighted by perimeter, and without confidence, since the user has decided.
    """
    clicks = tuple(said for item in (first, second) for said in item.clicks if said.inside)
    if first.region.ndim == 3:
        return replace(first.redrawn(unite_bodies(first.region, second.region)), clicks=clicks)
    one, other = polygon_from_boundary(first.region.boundary), polygon_from_boundary(second.region.boundary)
    both = one.union(other)
    closed = both.buffer(0.5 * _MAX_SLIT_WIDTH, join_style="mitre").buffer(-0.5 * _MAX_SLIT_WIDTH, join_style="mitre")
    between = closed.intersection(one.buffer(_MAX_SLIT_WIDTH)).intersection(other.buffer(_MAX_SLIT_WIDTH))
    boundary = boundary_from_polygon(both.union(between))
    lengths = [item.measure_perimeter() for item in (first, second)]
    gaps = tuple(gap for item in (first, second) for gap in item.gaps if lies_on(gap, boundary))
    strength = float(np.average((first.strength, second.strength), weights=lengths))
    return replace(first.redrawn(Region(boundary), gaps), clicks=clicks, strength=strength)


def lies_on(gap: Line, boundary: tuple[Line, ...]) -> bool:
    """Return whether most of a stretch lies on a boundary."""
    away = polyline.distances_to_closed_paths(boundary, polyline.path_midpoints(np.asarray(gap), 8))
    return bool(np.median(away) <= _BOUNDARY_GAP_TOLERANCE)


def polygon_from_boundary(boundary: Iterable[Line]) -> Any:
    """Build the polygon that an odd number of closed curves encloses."""
    import shapely  # noqa: PLC0415 - needed for few edits

    area: Any = shapely.Polygon()
    for curve in boundary:
        area = area.symmetric_difference(shapely.make_valid(shapely.Polygon(curve)))
    return area


def boundary_from_polygon(area: Any) -> tuple[Line, ...]:
    """Return the closed curves around a polygon, the longest first, without remainders."""
    import shapely  # noqa: PLC0415 - needed for few edits

    parts = [part for part in shapely.get_parts(area) if part.geom_type == "Polygon"]
    rings = [
        np.round(ring.coords, BOUNDARY_DECIMALS)[:-1] for part in parts for ring in (part.exterior, *part.interiors)
    ]
    rings = [ring for ring in rings if polyline.enclosed_area(ring) >= _MIN_RING_AREA]
    return tuple(as_line(ring) for ring in sorted(rings, key=lambda ring: -len(ring)))
