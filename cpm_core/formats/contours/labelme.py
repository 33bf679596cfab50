"""Labelme: contours as shapes of the annotation program labelme."""

from __future__ import annotations

import base64
import io
import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import PIL.Image
import scipy

from cpm_core.contours.contour import Contour
from cpm_core.formats.common.plain import encoded_json
from cpm_core.formats.common.provenance import ENTRY, Outcome, facts_of
from cpm_core.formats.contours.contents import PIXEL, Contents, pairs
from cpm_core.formats.contours.curves import ellipse, nested, rectangle
from cpm_core.formats.contours.mask import outlines
from cpm_core.numerics.polyline import inside
from cpm_core.numerics.types import Array, Entries, Position

_CONTOUR = "contour"
"""Label of a contour without a name."""

_VERSION = "5.5.0"
"""Version of labelme whose format this is; later versions read it."""


def located(result: Outcome, file: Path, image: Path) -> Outcome:
    """The result with the path of its image as seen from the folder of a file, so that labelme finds the image."""
    try:
        path = Path(os.path.relpath(image.resolve(), file.resolve().parent))
    except ValueError:  # on another drive
        path = image.resolve()
    return replace(result, source=path.as_posix())


def encode(result: Outcome) -> bytes:
    """Write a polygon for each closed contour and a strip of lines for each open one.

    The label of a shape is the class of the object, with its name as the description and its number as the group; of a
    contour without a class it is the name, or "contour". Coordinates are (x, y) in px from the corner of the image. The
    image is referenced by the source of the result (see `located`). Polygons of labelme have no holes: that of an
    object with holes goes around them by way of slits of no width. Colors are left out, because labelme chooses them by
    label. How they were found is an entry of the file, which labelme keeps when it writes the file again.
    """
    rows, cols = result.shape
    holes: dict[int, list[Array]] = {}
    for contour in result.contours:
        if contour.hole:
            holes.setdefault(contour.group, []).append(contour.points)
    shapes: list[Entries] = [
        {
            "label": contour.category or contour.name or _CONTOUR,
            "points": pairs(_around(contour.points, holes.get(contour.group, ()))),
            "group_id": contour.group or None,
            "description": contour.name if contour.category else "",
            "shape_type": _kind(contour),
            "flags": {},
            "mask": None,
        }
        for contour in result.contours
        if not contour.hole
    ]
    return encoded_json(
        {
            "version": _VERSION,
            "flags": {},
            "shapes": shapes,
            "imagePath": result.source,
            "imageData": None,
            "imageHeight": rows,
            "imageWidth": cols,
            ENTRY: facts_of(result),
        }
    )


def _around(outline: Array, holes: Sequence[Array]) -> Array:
    """An outline that goes around the holes inside it, too, the other way, there and back by the shortest slits."""
    left = [hole for hole in holes if inside(outline, hole).mean() > 0.5]
    while left:
        apart = [scipy.spatial.distance.cdist(outline, hole) for hole in left]
        nearest = min(range(len(left)), key=lambda number: apart[number].min())
        here, there = np.unravel_index(apart[nearest].argmin(), apart[nearest].shape)
        hole = np.roll(left.pop(nearest), -there, axis=0)
        if _turns(hole) == _turns(outline):
            hole = np.roll(hole[::-1], 1, axis=0)
        outline = np.concatenate([outline[: here + 1], hole, hole[:1], outline[here:]])
    return outline


def _turns(curve: Array) -> bool:
    """Which way a closed curve runs around what it encloses."""
    row, col = curve.T
    return bool(row @ np.roll(col, -1) > col @ np.roll(row, -1))


def _rings(corners: Array) -> list[Array]:
    """The closed curves of a polygon: one that comes to a corner twice goes around holes by way of slits."""
    rings: list[list[Position]] = []
    way: list[Position] = []
    for row, col in corners.tolist():
        if (row, col) in way:
            first = way.index((row, col))
            rings.append(way[first:])
            del way[first:]
        way.append((row, col))
    return [np.array(ring) for ring in (way, *rings) if len(ring) > 2] or [corners]


def _kind(contour: Contour) -> str:
    if contour.closed and len(contour.points) > 2:
        return "polygon"
    return "linestrip" if len(contour.points) > 1 else "point"


def read(content: Entries) -> Contents:
    """Contours of all shapes, whose labels are the classes, and the names where there is no description.

    Shapes of one label and one group are one object, in which a shape in another is a hole.
    """
    found = Contents()
    height, width = content.get("imageHeight"), content.get("imageWidth")
    found.shape = (int(height), int(width)) if height and width else None
    grouped: dict[tuple[Any, str], tuple[Entries, list[Array]]] = {}
    for shape in content["shapes"]:
        kind, label = shape.get("shape_type") or "polygon", str(shape["label"])
        name = "" if label == _CONTOUR else label
        known: Entries = {"name": shape.get("description") or name, "category": name}
        corners = np.array(shape["points"], float).reshape(-1, 2)[:, ::-1] - PIXEL
        if kind == "mask":
            found.add_object(_mask(shape, corners), **known)
        elif kind in ("point", "points"):
            for place in corners:
                found.add_place(place)
        elif kind in _CLOSED:
            curves = _rings(_CLOSED[kind](corners))
            if shape.get("group_id") is None:
                found.add_object(nested(curves), **known)
            else:
                grouped.setdefault((shape["group_id"], name), (known, []))[1].extend(curves)
        elif kind in _OPEN:
            found.add(corners, False, **known)
        else:
            found.left_out[f"shape of the kind {kind}"] += 1
    for known, curves in grouped.values():
        found.add_object(nested(curves), **known)
    return found


def _mask(shape: Entries, corners: Array) -> list[tuple[Array, bool]]:
    """The outlines of a mask, which is a picture in text, from its box on."""
    with PIL.Image.open(io.BytesIO(base64.b64decode(shape["mask"])), formats=("PNG",)) as picture:
        mask = np.asarray(picture.convert("L")) > 0
    row, col = np.rint(corners[0] + PIXEL).astype(int).tolist()
    return outlines(mask, row, col)


_QUARTER = np.array([[0.0, 1.0], [-1.0, 0.0]])

_CLOSED: dict[str, Callable[[Array], Array]] = {
    # variants of the program call an oriented rectangle a rotation
    **dict.fromkeys(("polygon", "oriented_rectangle", "rotation"), lambda corners: corners),
    "rectangle": lambda corners: rectangle(corners[0], corners[-1]) if len(corners) == 2 else corners,
    # through the second point about the first
    "circle": lambda corners: ellipse(corners[0], corners[1] - corners[0], (corners[1] - corners[0]) @ _QUARTER),
}
_OPEN = ("line", "linestrip")
