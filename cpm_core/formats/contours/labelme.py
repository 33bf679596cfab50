"""Labelme: contours as shapes for the annotation program labelme."""

from __future__ import annotations

from typing import Any

from cpm_core.contours.contour import Contour
from cpm_core.contours.result import Result
from cpm_core.formats.json_text import pairs, text
from cpm_core.medial_axis.skeleton import Skeleton

_VERSION = "5.5.0"
"""Version of labelme whose format this is; later versions read it."""


def encode(result: Result | Skeleton) -> bytes:
    """Write a polygon for each closed contour and a strip of lines for each open one.

    The label of a shape, its class, is the name of the contour, or "closed" or "open". Coordinates are (x, y) in px
    from the corner of the image. The image is referenced by its name, so the file belongs beside it. A hole is a
    polygon of its own. Colors are left out, because labelme chooses them by label.
    """
    rows, cols = result.shape
    shapes: list[dict[str, Any]] = [
        {
            "label": contour.name or ("closed" if contour.closed else "open"),
            "points": pairs(contour.points),
            "group_id": None,
            "description": "",
            "shape_type": _kind(contour),
            "flags": {},
            "mask": None,
        }
        for contour in result.contours
    ]
    return text(
        {
            "version": _VERSION,
            "flags": {},
            "shapes": shapes,
            "imagePath": result.source,
            "imageData": None,
            "imageHeight": rows,
            "imageWidth": cols,
        }
    )


def _kind(contour: Contour) -> str:
    if contour.closed and len(contour.points) > 2:
        return "polygon"
    return "linestrip" if len(contour.points) > 1 else "point"
