"""Layers of napari from contours and surfaces, and contours and starts from shapes that are drawn there."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from cpm_core import Contour, Result, measure
from cpm_core.contours import numbers_of
from cpm_core.formats import color_of, ellipse
from cpm_core.formats.contours.contents import DEFAULT
from cpm_core.numerics import Array
from cpm_core.shapes import Polygon, Stroke

LayerData = tuple[Any, dict[str, Any], str]
"""What napari makes a layer of: data, settings, and the kind."""

_CLOSED = ("polygon", "rectangle", "ellipse")
_SHAPE = "image_shape"


def layer_of_contours(contours: Sequence[Contour], name: str, shape: Sequence[int], **settings: Any) -> LayerData:
    """A layer of shapes with a polygon or a path for each contour, and its measures as features."""
    lines = [contour for contour in contours if len(contour.points) > 1]
    rows = measure(lines, contrast=False)
    features = {
        "number": list(numbers_of(lines)),
        "name": [contour.name for contour in lines],
        "closed": [contour.closed for contour in lines],
        "length": [row.length for row in rows],
        "net_area": [row.net_area for row in rows],
        "strength": [row.strength for row in rows],
    }
    look = {
        "shape_type": ["polygon" if contour.closed else "path" for contour in lines],
        "edge_color": [contour.color or DEFAULT for contour in lines] or DEFAULT,
        "face_color": "transparent",
        "edge_width": 1,
        "features": features,
        "metadata": {_SHAPE: tuple(shape)},
    }
    return [contour.points for contour in lines], {"name": name, **look, **settings}, "shapes"


def layers_of_result(result: Result, name: str, **settings: Any) -> list[LayerData]:
    """The contours of an image, or the surface in a volume, as layers; `settings` place them as their image."""
    if result.surface is not None:
        look = {"name": f"{name} surface", **settings}
        return [((result.surface.vertices, result.surface.faces), look, "surface")]
    return [layer_of_contours(result.contours, f"{name} contours", result.shape, **settings)]


def contours_of(data: Iterable[Array], settings: Mapping[str, Any]) -> tuple[tuple[Contour, ...], tuple[int, ...]]:
    """The contours of a layer of shapes in a plane, and the shape of their image."""
    shapes = [np.asarray(one, dtype=float)[:, -2:] for one in data]
    kinds = _each(settings.get("shape_type", "polygon"), len(shapes))
    colors = _each(settings.get("edge_color", ""), len(shapes))
    features = settings.get("features")  # a data frame
    names = _each(features["name"] if features is not None and "name" in features else "", len(shapes))
    contours = []
    for corners, kind, shade, name in zip(shapes, kinds, colors, names, strict=True):
        color = color_of(shade if isinstance(shade, str) else [round(255 * float(part)) for part in shade])
        points = _corners(corners, kind)
        color = "" if color == DEFAULT else color
        contours.append(
            Contour(
                points, kind in _CLOSED and len(points) > 2, name=name if isinstance(name, str) else "", color=color
            )
        )
    known = dict(settings.get("metadata") or {}).get(_SHAPE)
    if not known:
        far = np.concatenate([np.zeros((1, 2)), *(contour.points for contour in contours)]).max(axis=0)
        known = (np.ceil(far) + 1).astype(int).tolist()
    return tuple(contours), tuple(known)


def seeds_of(data: Iterable[Array], kinds: Sequence[str]) -> Array:
    """Particles along drawn shapes in an image or in a volume, shape (N, 2) or (N, 3)."""
    found = []
    for one, kind in zip(data, kinds, strict=True):
        corners = tuple(map(tuple, _corners(np.asarray(one, dtype=float), kind).tolist()))
        shape = Polygon(corners) if kind in _CLOSED and len(set(corners)) > 2 else Stroke(corners)
        found.append(shape.seeds())
    if not found:
        raise ValueError("The layer of shapes is empty: draw a circle or another shape inside the object first.")
    return np.concatenate(found)


def _corners(corners: Array, kind: str) -> Array:
    """The vertices of a shape; an ellipse has the corners of its box."""
    if kind != "ellipse":
        return corners
    one, two, three = corners[:3]
    return ellipse(corners.mean(axis=0), 0.5 * (two - one), 0.5 * (three - two))


def _each(value: Any, count: int) -> list[Any]:
    """A value for each shape, where there may be one for all."""
    if isinstance(value, str) or np.ndim(value) == 0:
        return [value] * count
    return list(value)
