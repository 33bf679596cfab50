"""Labelme: contours as shapes of the annotation program labelme."""

from __future__ import annotations

import base64
import io
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.contours.contour import Contour
from cpm_core.formats.common.plain import Entries, encoded_json
from cpm_core.formats.common.provenance import ENTRY, Outcome, facts_of
from cpm_core.formats.contours.contents import PIXEL, Contents, pairs
from cpm_core.formats.contours.curves import ellipse, nested, rectangle
from cpm_core.formats.contours.mask import opened, outlines
from cpm_core.numerics.types import Array

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

    The label of a shape, its class, is the name of the contour, or "contour". Coordinates are (x, y) in px from the
    corner of the image. The image is referenced by the source of the result (see `located`). A hole is a polygon of its
    own, in the group of its object. Colors are left out, because labelme chooses them by label. How they were found is
    an entry of the file, which labelme keeps when it writes the file again.
    """
    rows, cols = result.shape
    names = {contour.group: contour.name for contour in result.contours if not contour.hole}
    shapes: list[Entries] = [
        {
            "label": contour.name or (names.get(contour.group) if contour.hole else "") or _CONTOUR,
            "points": pairs(contour.points),
            "group_id": contour.group or None,
            "description": "",
            "shape_type": _kind(contour),
            "flags": {},
            "mask": None,
        }
        for contour in result.contours
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


def _kind(contour: Contour) -> str:
    if contour.closed and len(contour.points) > 2:
        return "polygon"
    return "linestrip" if len(contour.points) > 1 else "point"


def read(content: Entries) -> Contents:
    """Contours of all shapes, whose labels are the names.

    Shapes of one label and one group are one object, in which a shape in another is a hole.
    """
    found = Contents()
    height, width = content.get("imageHeight"), content.get("imageWidth")
    found.shape = (int(height), int(width)) if height and width else None
    grouped: dict[tuple[Any, str], list[Array]] = {}
    for shape in content["shapes"]:
        kind, label = shape.get("shape_type") or "polygon", str(shape["label"])
        name = "" if label == _CONTOUR else label
        corners = np.array(shape["points"], dtype=np.float64).reshape(-1, 2)[:, ::-1] - PIXEL
        if kind == "mask":
            found.add_object(_mask(shape, corners), name=name)
        elif kind in ("point", "points"):
            for place in corners:
                found.add_place(place)
        elif kind in _CLOSED:
            curve = _CLOSED[kind](corners)
            if shape.get("group_id") is None:
                found.add(curve, True, name=name)
            else:
                grouped.setdefault((shape["group_id"], name), []).append(curve)
        elif kind in _OPEN:
            found.add(corners, False, name=name)
        else:
            found.left_out[f"shape of the kind {kind}"] += 1
    for (_, name), curves in grouped.items():
        found.add_object(nested(curves), name=name)
    return found


def _mask(shape: Entries, corners: Array) -> list[tuple[Array, bool]]:
    """The outlines of a mask, which is a picture in text, from its box on."""
    with opened(io.BytesIO(base64.b64decode(shape["mask"], validate=True))) as picture:
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
