"""GeoJSON: any geometry as contours, with the names, classes and colors of QuPath."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np

from cpm_core.contours.contour import present_names
from cpm_core.formats.common.provenance import ENTRY
from cpm_core.formats.contours.appearance import DEFAULT
from cpm_core.formats.contours.json_text import PIXEL
from cpm_core.formats.contours.reading.contents import Contents, color_of
from cpm_core.numerics.types import Array

Known = dict[str, Any]


def read(content: Any) -> Contents:
    """Contours of all geometries in px from the corner of the image; interior rings are holes.

    The name of a contour is that of its feature, else that of its class. A contour in another is an interior ring there
    and, where CPM has written the file, a feature of its own as well: then it is no hole.
    """
    found = Contents()
    own = isinstance(content, dict) and ENTRY in content
    geometries = list(_geometries(content, {}, found))
    exteriors = {_key(rings[0]) for kind, rings, _ in geometries if kind == "Polygon"}
    for kind, rings, feature in geometries:
        properties, page = _properties(feature, own), _page(feature)
        if kind == "Polygon":
            holes = [ring for ring in rings[1:] if _key(ring) not in exteriors]
            found.add_object([(rings[0], False), *((ring, True) for ring in holes)], page=page, **properties)
        elif kind == "LineString":
            found.add(rings[0], False, page=page, **properties)
        else:
            for place in rings[0]:
                found.add_place(place, page)
    return found


def _geometries(content: Any, feature: Known, found: Contents) -> Iterator[tuple[str, list[Array], Known]]:
    """Kind, lines and feature of each geometry."""
    if isinstance(content, list):
        for entry in content:
            yield from _geometries(entry, feature, found)
        return
    kind = content["type"]
    if kind == "FeatureCollection":
        yield from _geometries(content["features"], feature, found)
    elif kind == "Feature":
        if content["geometry"] is None:
            found.left_out["feature without a geometry"] += 1
        else:
            yield from _geometries(content["geometry"], content, found)
    elif kind == "GeometryCollection":
        yield from _geometries(content["geometries"], feature, found)
    else:
        placed = {**feature, "plane": content.get("plane") or feature.get("plane")}
        positions = content["coordinates"]
        many = positions if kind.startswith("Multi") and kind != "MultiPoint" else [positions]
        for one in many:
            if kind in ("Polygon", "MultiPolygon"):
                yield "Polygon", [_corners(ring)[:-1] for ring in one], placed
            elif kind in ("LineString", "MultiLineString"):
                yield "LineString", [_corners(one)], placed
            elif kind in ("Point", "MultiPoint"):
                yield "Point", [_corners([one] if kind == "Point" else one)], placed
            else:
                raise ValueError(f"{kind} is not a kind of geometry")


def _corners(positions: Any) -> Array:
    return np.asarray(np.array(positions, dtype=np.float64)[:, 1::-1] - PIXEL)


def _properties(feature: Known, own: bool) -> Known:
    """Name, color and junctions of the contours of a feature; what CPM writes for none is none."""
    properties = present_names(feature.get("properties") or {})
    kind = properties.get("classification") or {}
    kind = {"name": kind} if isinstance(kind, str) else kind
    name = str(properties.get("name") or kind.get("name") or "")
    color = (
        color_of(properties.get("color"))
        or color_of(properties.get("colorRGB"))
        or color_of(kind.get("color"))
        or color_of(kind.get("colorRGB"))
    )
    if own:
        name = "" if re.fullmatch(r"contour \d+", name) else name
        color = "" if color == DEFAULT else color
    measures = properties.get("measurements")
    strength = measures.get("Edge strength", 0.0) if own and isinstance(measures, dict) else 0.0
    return {"name": name, "color": color, "junctions": properties.get("junctions") or (), "strength": strength}


def _page(feature: Known) -> int:
    """Page of a stack: what CPM has written, else the plane of QuPath where it is not the first one."""
    properties = feature.get("properties") or {}
    if "page" in properties:
        return int(properties["page"])
    plane = feature.get("plane") or {}
    return 1 + max(int(plane.get("z", 0)), int(plane.get("t", 0))) if plane else 0


def _key(points: Array) -> frozenset[tuple[float, ...]]:
    """Key that is equal for rings which differ only in first point or direction."""
    return frozenset(map(tuple, np.round(points, 3).tolist()))
