"""GeoJSON: contours as annotations for QuPath, and for programs that read shapes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpm_core.contours.contour import Contour
from cpm_core.contours.measurements import Measures, measure
from cpm_core.contours.result import Result
from cpm_core.formats.common.provenance import ENTRY, facts_of
from cpm_core.formats.contours.appearance import rgb, title
from cpm_core.formats.contours.json_text import pairs, text
from cpm_core.medial_axis.skeleton import Skeleton


def encode(result: Result | Skeleton) -> bytes:
    """Write a collection of features, one for each contour (RFC 7946, with the properties that QuPath uses).

    A closed contour is a polygon whose interior rings are the contours directly inside it, so it covers the pixels of
    its label in the label mask; each of those is a feature of its own as well, unless it is just a hole in an object.
    An open one is a line, a single vertex a point. The name of a contour is that of its class, too. Coordinates are
    (x, y) in px from the corner of the image, the center of the first pixel at (0.5, 0.5). How they were found is an
    entry of the collection, a foreign member as the format allows.
    """
    return text({"type": "FeatureCollection", ENTRY: facts_of(result), "features": features_of(result)})


def features_of(result: Result | Skeleton) -> list[dict[str, Any]]:
    """The features of a result; see `encode`."""
    rows = measure(result.contours, result.spacing)
    holes: dict[int, list[Contour]] = {}
    for contour, row in zip(result.contours, rows, strict=True):
        if row.inside and _areal(contour):
            holes.setdefault(row.inside, []).append(contour)
    return [
        {
            "type": "Feature",
            "geometry": _geometry(contour, holes.get(row.number, [])),
            "properties": {
                "objectType": "annotation",
                "name": title(contour, row.number),
                "color": list(rgb(contour)),
                **({"classification": {"name": contour.name, "color": list(rgb(contour))}} if contour.name else {}),
                "closed": row.closed,
                "junctions": list(contour.junctions),
                "inside": row.inside,
                "measurements": _measurements(row, result.unit) | _measurements_of_object(contour),
            },
        }
        for contour, row in zip(result.contours, rows, strict=True)
        if not contour.hole
    ]


def _measurements(row: Measures, unit: str | None) -> dict[str, float]:
    """Measures under names as QuPath uses them; the net area is that of the polygon with its holes."""
    found = {"Length px": row.length}
    areas = {"Net area px^2": row.net_area, "Gross area px^2": row.area} if row.closed else {}
    if unit:
        found[f"Length {unit}"] = row.length_in_units
        areas |= {f"Net area {unit}^2": row.net_area_in_units, f"Gross area {unit}^2": row.area_in_units}
    found |= areas if row.closed else {}
    found["Edge strength"] = row.strength
    if row.contrast is not None:
        found["Contrast"] = row.contrast
    if row.by_hand:
        found["Length by hand px"] = row.by_hand
    return {name: round(value, 6) for name, value in found.items()}


def _measurements_of_object(contour: Contour) -> dict[str, float]:
    """What is measured of the boundary of an object only."""
    return {"Bridged px": round(contour.bridged, 6)} if contour.group else {}


def _areal(contour: Contour) -> bool:
    """Whether a contour encloses anything."""
    return contour.closed and len(contour.points) > 2


def _geometry(contour: Contour, holes: Sequence[Contour]) -> dict[str, Any]:
    if _areal(contour):
        rings = [_ring(contour.points, 1.0), *(_ring(hole.points, -1.0) for hole in holes)]
        return {"type": "Polygon", "coordinates": rings}
    if len(contour.points) > 1:
        return {"type": "LineString", "coordinates": pairs(contour.path)}
    return {"type": "Point", "coordinates": pairs(contour.points)[0]}


def _ring(points: NDArray[np.float64], turn: float) -> list[list[float]]:
    """Ring of positions, the first repeated at the end: counterclockwise in (x, y) outside, clockwise inside."""
    row, col = points.T
    signed = float(col @ np.roll(row, -1) - np.roll(col, -1) @ row)
    ring = pairs(points if signed * turn > 0 else points[::-1])
    return [*ring, ring[0]]
