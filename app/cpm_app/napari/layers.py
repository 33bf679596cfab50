"""Layers of napari from contours, surfaces and labels, and contours from shapes drawn there."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cpm_core import Contour, Result, measure
from cpm_core.contours import assign_numbers
from cpm_core.formats import flatten_ellipse, parse_color
from cpm_core.formats.contours.contents import DEFAULT_COLOR
from cpm_core.numerics import Array
from cpm_core.numerics.types import Integers, JsonObject

LayerData = tuple[Any, dict[str, Any], str]
"""Layer as napari takes it: data, settings, and kind."""

_CLOSED_KINDS = ("polygon", "rectangle", "ellipse")
"""Kinds of closed shapes in napari."""

_SHAPE_KEY = "image_shape"
"""Key of the shape of the image in the metadata of a layer."""


def build_contour_layer(contours: Sequence[Contour], name: str, shape: Sequence[int], **settings: Any) -> LayerData:
    """Build a layer of shapes with a polygon or a path for each contour, and its measures as features."""
    lines = [contour for contour in contours if len(contour.points) > 1]
    rows = measure(lines, contrast=False)
    features = {
        "number": list(assign_numbers(lines)),
        "name": [contour.name for contour in lines],
        "closed": [contour.closed for contour in lines],
        "length": [row.length for row in rows],
        "net_area": [row.net_area for row in rows],
        "strength": [row.strength for row in rows],
    }
    look = {
        "shape_type": ["polygon" if contour.closed else "path" for contour in lines],
        "edge_color": [contour.color or DEFAULT_COLOR for contour in lines] or DEFAULT_COLOR,
        "face_color": "transparent",
        "edge_width": 1,
        "features": features,
        "metadata": {_SHAPE_KEY: tuple(shape)},
    }
    return [contour.points for contour in lines], {"name": name, **look, **settings}, "shapes"


def build_result_layers(result: Result, name: str, **settings: Any) -> list[LayerData]:
    """Build layers of labels with their measures and of contours, or in a volume the surface.

    The `settings` place them like their image.
    """
    measures = dict(result.table())
    features = {"index": measures.pop("label"), **measures}
    layers: list[LayerData] = [
        (result.labels.copy(), {"name": f"{name} labels", "features": features, **settings}, "labels")
    ]
    if result.surface is not None:
        look = {"name": f"{name} surface", **settings}
        return [*layers, ((result.surface.vertices, result.surface.faces), look, "surface")]
    return [*layers, build_contour_layer(result.contours, f"{name} contours", result.shape, **settings)]


def contours_from_layer(data: Sequence[Array], settings: JsonObject) -> tuple[tuple[Contour, ...], Integers]:
    """Return the contours of a layer of shapes in a plane, with names and colors, and the shape of their image.

    `data` are vertices of each shape, shape (K, D); the last two axes are rows and columns [px].
    """
    drawn = lines_from_shapes([np.asarray(corners)[:, -2:] for corners in data], settings["shape_type"])
    names = settings["features"].get("name", [""] * len(drawn))
    shades = [parse_color([round(255 * float(part)) for part in shade]) for shade in settings["edge_color"]]
    contours = tuple(
        replace(line, name=name if isinstance(name, str) else "", color="" if color == DEFAULT_COLOR else color)
        for line, name, color in zip(drawn, names, shades, strict=True)
    )
    known = settings["metadata"].get(_SHAPE_KEY)
    if not known:
        far = np.concatenate([np.zeros((1, 2)), *(line.points for line in drawn)]).max(axis=0)
        known = (np.ceil(far) + 1).astype(int).tolist()
    return contours, tuple(known)


def lines_from_shapes(data: Iterable[Array], kinds: Iterable[str]) -> list[Contour]:
    """Convert drawn shapes, each with vertices (K, D), to lines.

    napari represents an ellipse by the corners of its box.
    """
    lines = []
    for corners, kind in zip(data, kinds, strict=True):
        points = np.asarray(corners, dtype=float)
        if kind == "ellipse":
            one, two, three = points[:3]
            points = flatten_ellipse(points.mean(axis=0), 0.5 * (two - one), 0.5 * (three - two))
        lines.append(Contour(points, kind in _CLOSED_KINDS and len(points) > 2))
    return lines
