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
from cpm_core.formats.common.json_values import encode_json
from cpm_core.formats.common.provenance import PROVENANCE_KEY, Outcome, describe_provenance
from cpm_core.formats.contours.contents import PIXEL_OFFSET, CollectedContours, to_xy_pairs
from cpm_core.formats.contours.curves import flatten_ellipse, rectangle_corners
from cpm_core.formats.contours.mask import find_outlines
from cpm_core.numerics.polyline import find_holes, points_inside
from cpm_core.numerics.types import Array, JsonDict, Position

_UNNAMED_LABEL = "contour"
"""Label of a contour without a name."""

_LABELME_VERSION = "5.5.0"
"""Version of the format; later versions of labelme read it."""


def set_relative_source(result: Outcome, file: Path, image: Path) -> Outcome:
    """Set the source of a result to the path of its image relative to a file, so that labelme finds the image."""
    try:
        path = Path(os.path.relpath(image.resolve(), file.resolve().parent))
    except ValueError:  # they are on different drives
        path = image.resolve()
    return replace(result, source=path.as_posix())


def encode_labelme(result: Outcome) -> bytes:
    """Encode each closed contour as a polygon and each open one as a line strip.

    The label of a shape is the class of the object, with its name as the description and its number as the group; for a
    contour without a class it is the name, or "contour". Coordinates are (x, y) in px from the corner of the image. The
    image is referenced by the source of the result (see `set_relative_source`). Polygons of labelme have no holes: that
    of an object with holes includes them through slits of zero width. Colors are left out, because labelme chooses them
    by label. Provenance is an entry of the file, which labelme keeps when it saves the file.
    """
    rows, cols = result.shape
    holes: dict[int, list[Array]] = {}
    for contour in result.contours:
        if contour.hole:
            holes.setdefault(contour.group, []).append(contour.points)
    shapes: list[JsonDict] = [
        {
            "label": contour.category or contour.name or _UNNAMED_LABEL,
            "points": to_xy_pairs(_connect_holes(contour.points, holes.get(contour.group, ()))),
            "group_id": contour.group or None,
            "description": contour.name if contour.category else "",
            "shape_type": _choose_shape_type(contour),
            "flags": {},
            "mask": None,
        }
        for contour in result.contours
        if not contour.hole
    ]
    return encode_json(
        {
            "version": _LABELME_VERSION,
            "flags": {},
            "shapes": shapes,
            "imagePath": result.source,
            "imageData": None,
            "imageHeight": rows,
            "imageWidth": cols,
            PROVENANCE_KEY: describe_provenance(result),
        }
    )


def _connect_holes(outline: Array, holes: Sequence[Array]) -> Array:
    """Connect an outline to the holes in it by the shortest slits, running around them the other way."""
    left = [hole for hole in holes if points_inside(outline, hole).mean() > 0.5]
    while left:
        apart = [scipy.spatial.distance.cdist(outline, hole) for hole in left]
        nearest = min(range(len(left)), key=lambda number: apart[number].min())
        here, there = np.unravel_index(apart[nearest].argmin(), apart[nearest].shape)
        hole = np.roll(left.pop(nearest), -there, axis=0)
        if _is_counterclockwise(hole) == _is_counterclockwise(outline):
            hole = np.roll(hole[::-1], 1, axis=0)
        outline = np.concatenate([outline[: here + 1], hole, hole[:1], outline[here:]])
    return outline


def _is_counterclockwise(curve: Array) -> bool:
    """Return whether a closed curve runs counterclockwise as displayed, rows downward."""
    row, col = curve.T
    return bool(row @ np.roll(col, -1) > col @ np.roll(row, -1))


def _split_rings(corners: Array) -> list[Array]:
    """Split a polygon at corners that it visits twice, where slits lead to holes, into closed curves."""
    rings: list[list[Position]] = []
    way: list[Position] = []
    for row, col in corners.tolist():
        if (row, col) in way:
            first = way.index((row, col))
            rings.append(way[first:])
            del way[first:]
        way.append((row, col))
    return [np.array(ring) for ring in (way, *rings) if len(ring) > 2] or [corners]


def _choose_shape_type(contour: Contour) -> str:
    """Choose the type of shape for a contour."""
    if contour.encloses_area:
        return "polygon"
    return "linestrip" if len(contour.points) > 1 else "point"


def read_labelme(content: JsonDict) -> CollectedContours:
    """Read the contours of all shapes; labels are the classes, and the names of shapes without a description.

    Shapes with the same label and group are one object, in which a shape inside another is a hole.
    """
    found = CollectedContours()
    height, width = content.get("imageHeight"), content.get("imageWidth")
    found.shape = (int(height), int(width)) if height and width else None
    grouped: dict[tuple[Any, str], tuple[JsonDict, list[Array]]] = {}
    for shape in content["shapes"]:
        kind, label = shape.get("shape_type") or "polygon", str(shape["label"])
        name = "" if label == _UNNAMED_LABEL else label
        known: JsonDict = {"name": shape.get("description") or name, "category": name}
        corners = np.array(shape["points"], float).reshape(-1, 2)[:, ::-1] - PIXEL_OFFSET
        if kind == "mask":
            found.add_object(_decode_mask(shape, corners), **known)
        elif kind in ("point", "points"):
            for place in corners:
                found.add_point(place)
        elif kind in _CLOSED_SHAPES:
            curves = _split_rings(_CLOSED_SHAPES[kind](corners))
            if shape.get("group_id") is None:
                found.add_object(zip(curves, find_holes(curves), strict=True), **known)
            else:
                grouped.setdefault((shape["group_id"], name), (known, []))[1].extend(curves)
        elif kind in _OPEN_SHAPES:
            found.add_contour(corners, False, **known)
        else:
            found.omissions[f"shape of the kind {kind}"] += 1
    for known, curves in grouped.values():
        found.add_object(zip(curves, find_holes(curves), strict=True), **known)
    return found


def _decode_mask(shape: JsonDict, corners: Array) -> list[tuple[Array, bool]]:
    """Decode the outlines of a mask, a PNG in base64 placed at the first corner of its box."""
    with PIL.Image.open(io.BytesIO(base64.b64decode(shape["mask"])), formats=("PNG",)) as picture:
        mask = np.asarray(picture.convert("L")) > 0
    row, col = np.rint(corners[0] + PIXEL_OFFSET).astype(int).tolist()
    return find_outlines(mask, row, col)


_QUARTER_TURN = np.array([[0.0, 1.0], [-1.0, 0.0]])
"""Rotation by a right angle."""

_CLOSED_SHAPES: dict[str, Callable[[Array], Array]] = {
    # some variants of the program call an oriented rectangle a rotation
    **dict.fromkeys(("polygon", "oriented_rectangle", "rotation"), lambda corners: corners),
    "rectangle": lambda corners: rectangle_corners(corners[0], corners[-1]) if len(corners) == 2 else corners,
    # center, and a point on the circle
    "circle": lambda corners: flatten_ellipse(
        corners[0], corners[1] - corners[0], (corners[1] - corners[0]) @ _QUARTER_TURN
    ),
}
"""Kinds of closed shapes -> their outline by the points of the file, each of shape (K, 2)."""

_OPEN_SHAPES = ("line", "linestrip")
"""Kinds of open shapes."""
