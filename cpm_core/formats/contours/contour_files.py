"""Contour files: reads contours that CPM, QuPath or labelme have written."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.contours.contour import Contour, present_names
from cpm_core.formats.contours import contour_json
from cpm_core.formats.contours.json_text import PIXEL
from cpm_core.formats.images.decoded import UnreadableError
from cpm_core.formats.printable import text_of_cell
from cpm_core.numerics.types import Array

CONTOURS_READABLE: dict[str, str] = {
    ".csv": "table of vertices",
    ".geojson": "GeoJSON, as of QuPath",
    ".json": "JSON of CPM, of labelme or GeoJSON",
}
"""Suffixes of files that contours can be read from -> what they are."""

_CIRCLE = 128
"""Vertices that a circle of a file is converted to."""


@dataclass(frozen=True, eq=False)
class ContourFile:
    """Contours of a file.

    Attributes
    ----------
    contours : tuple of Contour
        The contours, in px.
    shape : tuple of int or None
        Shape of the image that they belong to, where the file gives it.
    """

    contours: tuple[Contour, ...]
    shape: tuple[int, int] | None = None


def load_contours(path: str | os.PathLike[str]) -> tuple[Contour, ...]:
    """Read contours from a file; see `read_contours`."""
    return read_contours(path).contours


def read_contours(path: str | os.PathLike[str]) -> ContourFile:
    """Read contours, and the shape of the image where the file gives it.

    Parameters
    ----------
    path : path-like
        A table of vertices or a JSON file that `export` has written, GeoJSON in px from the corner of the image, or a
        file of labelme. The kind of JSON is recognized by its content.

    Returns
    -------
    ContourFile
        Contours with the names, colors, strengths and junctions that the file gives; single points are left out.

    Raises
    ------
    ValueError
        When the file cannot be read or holds no contour; one sentence with its name and what to do.
    """
    file = Path(path)
    read = _table if file.suffix.lower() == ".csv" else _json
    try:
        found = read(file.name, file.read_text(encoding="utf-8-sig"))
    except UnreadableError:
        raise
    except UnicodeDecodeError:
        raise ValueError(f"{file.name} is not a text file: choose contours as CSV, GeoJSON or JSON.") from None
    except OSError as error:
        raise ValueError(f"{file} cannot be read: {error.strerror or error}.") from error
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, RecursionError) as error:
        raise ValueError(
            f"{file.name} is damaged or holds no contours of a known kind: choose contours as CSV, GeoJSON or JSON "
            "that CPM, QuPath or labelme has written."
        ) from error
    contours = tuple(contour for contour in found.contours if len(contour.points) > 1)
    if not all(np.isfinite(contour.points).all() for contour in contours):
        raise ValueError(f"{file.name} holds vertices that are not finite numbers: write it again.")
    if not contours:
        raise ValueError(f"{file.name} holds no contours: choose a file with at least one line or polygon.")
    return ContourFile(contours, found.shape)


def _contour(
    points: Any, closed: bool, *, strength: float = 0.0, junctions: Any = (), name: Any = "", color: str = ""
) -> Contour:
    vertices = np.array(points, dtype=np.float64)
    if vertices.ndim != 2 or vertices.shape[1] != 2:
        raise ValueError("vertices are not pairs")
    first, last = (*map(bool, junctions), False, False)[:2]
    return Contour(vertices, closed and len(vertices) > 2, float(strength), (first, last), None, str(name), color)


def _table(name: str, text: str) -> ContourFile:
    rows = [present_names(row) for row in csv.DictReader(text.splitlines())]
    missing = {"contour", "closed", "row", "col"} - set(rows[0] if rows else ())
    if missing:
        raise UnreadableError(
            f"{name} is not a table of contours: it has no column {' or '.join(sorted(missing))}. Choose a table of "
            "vertices that CPM has written."
        )
    contours = []
    for _, group in groupby(rows, key=lambda row: row["contour"]):
        vertices = list(group)
        first = vertices[0]
        contours.append(
            _contour(
                [(float(row["row"]), float(row["col"])) for row in vertices],
                first["closed"].strip().upper() == "TRUE",
                strength=float(first.get("strength") or 0.0),
                name=text_of_cell(first.get("name") or ""),
                color=first.get("color") or "",
            )
        )
    return ContourFile(tuple(contours))


def _json(name: str, text: str) -> ContourFile:
    content = json.loads(text)
    if isinstance(content, dict) and content.get("format") == contour_json.FORMAT:
        return _own(content)
    if isinstance(content, dict) and "shapes" in content:
        return _labelme(content)
    if isinstance(content, dict) and "annotations" in content and "images" in content:
        raise UnreadableError(f"{name} is a COCO file, which cannot be read: choose contours as GeoJSON, CSV or JSON.")
    lines = list(_features(content))
    exteriors = {_key(line.points) for line, interior in lines if not interior}
    # a contour in another is an interior ring there and, where CPM has written the file, a feature of its own as well
    return ContourFile(tuple(line for line, interior in lines if not (interior and _key(line.points) in exteriors)))


def _own(content: dict[str, Any]) -> ContourFile:
    rows, cols = content["image"]["shape"]
    contours = (
        _contour(
            entry["points"],
            bool(entry["closed"]),
            strength=entry["strength"],
            junctions=entry["junctions"],
            name=entry["name"],
            color=entry["color"],
        )
        for entry in map(present_names, content["contours"])
    )
    return ContourFile(tuple(contours), (int(rows), int(cols)))


def _labelme(content: dict[str, Any]) -> ContourFile:
    contours = []
    for shape in content["shapes"]:
        read = _SHAPES.get(shape["shape_type"])
        if read is not None:
            corners = np.array(shape["points"], dtype=np.float64)[:, ::-1] - PIXEL
            contours.append(_contour(*read(corners), name=shape["label"]))
    height, width = content.get("imageHeight"), content.get("imageWidth")
    return ContourFile(tuple(contours), (int(height), int(width)) if height and width else None)


def _rectangle(corners: Array) -> tuple[Array, bool]:
    (top, left), (bottom, right) = corners[0], corners[-1]
    return np.array([(top, left), (top, right), (bottom, right), (bottom, left)]), True


def _round(corners: Array) -> tuple[Array, bool]:
    """Circle through the second point about the first."""
    angle = 2.0 * np.pi * np.arange(_CIRCLE) / _CIRCLE
    radius = np.linalg.norm(corners[1] - corners[0])
    return corners[0] + radius * np.stack([np.sin(angle), np.cos(angle)], axis=1), True


_SHAPES: dict[str, Callable[[Array], tuple[Array, bool]]] = {
    "polygon": lambda corners: (corners, True),
    "linestrip": lambda corners: (corners, False),
    "line": lambda corners: (corners, False),
    "rectangle": _rectangle,
    "circle": _round,
}


def _features(content: Any, properties: dict[str, Any] | None = None) -> Iterator[tuple[Contour, bool]]:
    """Contours of any GeoJSON object, and whether each is an interior ring."""
    if isinstance(content, list):
        for entry in content:
            yield from _features(entry)
        return
    kind = content["type"]
    known = properties or {}
    if kind == "FeatureCollection":
        yield from _features(content["features"])
    elif kind == "Feature":
        if content["geometry"] is not None:
            yield from _features(content["geometry"], content.get("properties") or {})
    elif kind == "GeometryCollection":
        for geometry in content["geometries"]:
            yield from _features(geometry, known)
    elif kind in ("Polygon", "MultiPolygon"):
        for polygon in [content["coordinates"]] if kind == "Polygon" else content["coordinates"]:
            for number, ring in enumerate(polygon):
                yield _line(ring[:-1], True, {} if number else known), number > 0
    elif kind in ("LineString", "MultiLineString"):
        for line in [content["coordinates"]] if kind == "LineString" else content["coordinates"]:
            yield _line(line, False, known), False
    elif kind not in ("Point", "MultiPoint"):
        raise ValueError(f"{kind} is not a kind of geometry")


def _line(positions: Any, closed: bool, known: dict[str, Any]) -> Contour:
    color = known.get("color")
    red_green_blue = color if isinstance(color, list) and len(color) == 3 else None
    return _contour(
        np.array(positions, dtype=np.float64)[:, 1::-1] - PIXEL,
        closed,
        name=known.get("name") or "",
        junctions=known.get("junctions") or (),
        color="#{:02x}{:02x}{:02x}".format(*map(int, red_green_blue)) if red_green_blue else "",
    )


def _key(points: Array) -> frozenset[tuple[float, ...]]:
    """Key that is equal for rings which differ only in first point or direction."""
    return frozenset(map(tuple, np.round(points, 3).tolist()))
