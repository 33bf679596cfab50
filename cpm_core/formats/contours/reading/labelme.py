"""Labelme: shapes of all kinds as contours."""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from cpm_core.formats.contours.json_text import PIXEL
from cpm_core.formats.contours.reading.contents import Contents
from cpm_core.formats.contours.reading.curves import ellipse, nested, rectangle
from cpm_core.formats.contours.reading.mask import opened, outlines
from cpm_core.numerics.types import Array

CONTOUR = "contour"
"""Label that CPM writes for a contour without a name."""


def is_labelme(content: Any) -> bool:
    """Whether plain JSON is of this format."""
    return isinstance(content, dict) and isinstance(content.get("shapes"), list)


def read(content: dict[str, Any]) -> Contents:
    """Contours of all shapes, whose labels are the names.

    Shapes of one label and one group are one object, in which a shape in another is a hole.
    """
    found = Contents()
    height, width = content.get("imageHeight"), content.get("imageWidth")
    found.shape = (int(height), int(width)) if height and width else None
    grouped: dict[tuple[Any, str], list[Array]] = {}
    for shape in content["shapes"]:
        kind, label = shape.get("shape_type") or "polygon", str(shape["label"])
        name = "" if label == CONTOUR else label
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


def _round(corners: Array) -> Array:
    """Circle through the second point about the first."""
    radius = math.hypot(*(corners[1] - corners[0]))
    return ellipse(corners[0], (0.0, radius), (radius, 0.0))


def _mask(shape: dict[str, Any], corners: Array) -> list[tuple[Array, bool]]:
    """The outlines of a mask, which is a picture in text, from its box on."""
    with opened(io.BytesIO(base64.b64decode(shape["mask"], validate=True))) as picture:
        mask = np.asarray(picture.convert("L")) > 0
    row, col = np.rint(corners[0] + PIXEL).astype(int).tolist()
    return outlines(mask, row, col)


_CLOSED: dict[str, Callable[[Array], Array]] = {
    "polygon": lambda corners: corners,
    "rectangle": lambda corners: rectangle(corners[0], corners[-1]) if len(corners) == 2 else corners,
    "oriented_rectangle": lambda corners: corners,
    "rotation": lambda corners: corners,  # what variants of the program call the same
    "circle": _round,
}
_OPEN = ("line", "linestrip")
