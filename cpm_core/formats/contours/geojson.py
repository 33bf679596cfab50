"""GeoJSON: contours as annotations of QuPath, and geometries of any program as contours."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from cpm_core.contours.contour import Contour, Contours
from cpm_core.contours.measurements import Measures, measure
from cpm_core.formats.common.json_values import encode_json
from cpm_core.formats.common.provenance import PROVENANCE_KEY, Outcome, describe_provenance
from cpm_core.formats.contours.contents import PIXEL_OFFSET, CollectedContours, contour_rgb, parse_color, to_xy_pairs
from cpm_core.numerics.types import Array, JsonDict

_CLASS_SEPARATOR = ": "
"""What QuPath has between a class and one derived from it, as in "Tumor: Positive"; it reads that as both."""


def encode_geojson(result: Outcome) -> bytes:
    """Write a collection of features, one for each contour (RFC 7946, with the properties that QuPath uses).

    A closed contour is a polygon whose interior rings are the contours directly inside it, so that it covers the pixels
    of its label in the label mask; each of these is a feature as well, unless it is just a hole in an object. An open
    contour is a line, a single vertex a point. The classification is the class, or else the name. Coordinates are
    (x, y) in px from the corner of the image, the center of the first pixel at (0.5, 0.5). Provenance is an entry of
    the collection, a foreign member as the format allows.
    """
    return encode_json(
        {"type": "FeatureCollection", PROVENANCE_KEY: describe_provenance(result), "features": build_features(result)}
    )


def build_features(result: Outcome) -> list[JsonDict]:
    """Build the features of a result; see `encode_geojson`."""
    rows = measure(result.contours, result.spacing)
    holes: dict[int, list[Contour]] = {}
    for contour, row in zip(result.contours, rows, strict=True):
        if row.inside and contour.encloses_area:
            holes.setdefault(row.inside, []).append(contour)
    return [
        {
            "type": "Feature",
            "geometry": _build_geometry(contour, holes.get(row.number, [])),
            "properties": {
                "objectType": "annotation",
                "name": contour.name or f"contour {row.number}",
                "color": list(contour_rgb(contour)),
                **({"classification": {"name": kind, "color": list(contour_rgb(contour))}} if kind else {}),
                "closed": row.closed,
                "junctions": list(contour.junctions),
                "inside": row.inside,
                "measurements": _build_measurements(contour, row, result.unit),
            },
        }
        for contour, row in zip(result.contours, rows, strict=True)
        for kind in [contour.category or contour.name]
        if not contour.hole
    ]


def _build_measurements(contour: Contour, row: Measures, unit: str | None) -> dict[str, float]:
    """Build the measurements under the names that QuPath uses; the net area is that of the polygon with its holes."""
    found = {"Length px": row.length}
    if unit:
        found[f"Length {unit}"] = row.length_in_units
    if row.closed:
        found |= {"Net area px^2": row.net_area, "Gross area px^2": row.area}
    if row.closed and unit:
        found |= {f"Net area {unit}^2": row.net_area_in_units, f"Gross area {unit}^2": row.area_in_units}
    found["Edge strength"] = row.strength
    if row.contrast is not None:
        found["Contrast"] = row.contrast
    if contour.group:
        found["Bridged px"] = contour.bridged
    if contour.confidence is not None:
        found["Confidence"] = contour.confidence
    return {name: round(value, 6) for name, value in found.items()}


def _build_geometry(contour: Contour, holes: Contours) -> JsonDict:
    """Build a polygon (exterior counterclockwise in (x, y), holes clockwise), a line, or a point."""
    from shapely.geometry import LineString, Point, Polygon, mapping
    from shapely.geometry.polygon import orient

    if contour.encloses_area:
        return dict(mapping(orient(Polygon(to_xy_pairs(contour.points), [to_xy_pairs(hole.points) for hole in holes]))))
    kind = LineString if len(contour.points) > 1 else Point
    return dict(mapping(kind(to_xy_pairs(contour.path if kind is LineString else contour.points))))


def read_geojson(content: Any) -> CollectedContours:
    """Read the contours of all geometries, in px from the corner of the image; interior rings are holes.

    The name of a contour is that of its feature, else that of its class, which QuPath writes as a name or a list of
    names. The nucleus of a cell is left out, since a contour in another is a hole. In files of CPM one in another is
    both an interior ring and a feature of its own, and then it is no hole.
    """
    own = isinstance(content, dict) and PROVENANCE_KEY in content
    found = CollectedContours(is_own=own)
    geometries = list(_iterate_geometries(content, {}, found))
    exteriors = {_ring_key(rings[0]) for kind, rings, _ in geometries if kind == "Polygon"}
    for kind, rings, feature in geometries:
        properties, page = _parse_properties(feature, own), _parse_page(feature)
        if kind == "Polygon":
            holes = [(ring, True) for ring in rings[1:] if _ring_key(ring) not in exteriors]
            found.add_object([(rings[0], False), *holes], page=page, **properties)
        else:
            found.add_contour(rings[0], False, page=page, **properties)
    return found


def _iterate_geometries(
    content: Any, feature: JsonDict, found: CollectedContours
) -> Iterator[tuple[str, list[Array], JsonDict]]:
    """Yield kind, rings (row, col) and feature of each geometry; a point is a line of one vertex."""
    import shapely

    if isinstance(content, list):
        for entry in content:
            yield from _iterate_geometries(entry, feature, found)
        return
    kind = content["type"]
    if kind in ("FeatureCollection", "GeometryCollection"):
        yield from _iterate_geometries(
            content["features" if kind == "FeatureCollection" else "geometries"], feature, found
        )
    elif kind == "Feature" and content["geometry"] is None:
        found.omissions["feature without a geometry"] += 1
    elif kind == "Feature":
        if content.get("nucleusGeometry"):
            found.omissions["nucleus of a cell"] += 1
        yield from _iterate_geometries(content["geometry"], content, found)
    else:
        placed = {**feature, "plane": content.get("plane") or feature.get("plane")}
        for part in shapely.get_parts(shapely.geometry.shape(content)):
            rings = (part.exterior, *part.interiors) if part.geom_type == "Polygon" else (part,)
            yield part.geom_type, [shapely.get_coordinates(ring)[:, ::-1] - PIXEL_OFFSET for ring in rings], placed


def _parse_properties(feature: JsonDict, own: bool) -> JsonDict:
    """Parse name, color and junctions of a feature, dropping those that CPM gives to contours without any."""
    properties = feature.get("properties") or {}
    kind = properties.get("classification") or {}
    kind = kind if isinstance(kind, dict) else {"name": kind}
    given = kind.get("names") or kind.get("name") or ""
    category = given if isinstance(given, str) else _CLASS_SEPARATOR.join(map(str, given))
    colors = (parse_color(one.get(key)) for one in (properties, kind) for key in ("color", "colorRGB"))
    color = next(filter(None, colors), "")
    measures = properties.get("measurements")
    strength = measures.get("Edge strength", 0.0) if own and isinstance(measures, dict) else 0.0
    return {
        "name": str(properties.get("name") or category),
        "category": category,
        "color": color,
        "junctions": properties.get("junctions") or (),
        "strength": strength,
    }


def _parse_page(feature: JsonDict) -> int:
    """Parse the page of a stack: that written by CPM, else the plane of QuPath; 0 without either."""
    properties = feature.get("properties") or {}
    if "page" in properties:
        return int(properties["page"])
    plane = feature.get("plane") or {}
    return 1 + max(int(plane.get("z", 0)), int(plane.get("t", 0))) if plane else 0


def _ring_key(points: Array) -> frozenset[tuple[float, ...]]:
    """Return a key that is equal for rings that differ only in first point or direction."""
    return frozenset(map(tuple, np.round(points, 3).tolist()))
