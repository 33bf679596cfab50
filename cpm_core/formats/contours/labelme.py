"""Labelme: contours as shapes for the annotation program labelme."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

from cpm_core.contours.contour import Contour
from cpm_core.contours.result import Result
from cpm_core.formats.common.provenance import ENTRY, facts_of
from cpm_core.formats.contours.json_text import pairs, text
from cpm_core.formats.contours.reading.labelme import CONTOUR
from cpm_core.medial_axis.skeleton import Skeleton

_VERSION = "5.5.0"
"""Version of labelme whose format this is; later versions read it."""


def located(result: Result | Skeleton, file: Path, image: Path) -> Result | Skeleton:
    """The result with the path of its image as seen from the folder of a file, so that labelme finds the image."""
    try:
        path = Path(os.path.relpath(image.resolve(), file.resolve().parent))
    except ValueError:  # on another drive
        path = image.resolve()
    return replace(result, source=path.as_posix())


def encode(result: Result | Skeleton) -> bytes:
    """Write a polygon for each closed contour and a strip of lines for each open one.

    The label of a shape, its class, is the name of the contour, or "contour". Coordinates are (x, y) in px from the
    corner of the image. The image is referenced by the source of the result (see `located`). A hole is a polygon of its
    own, in the group of its object. Colors are left out, because labelme chooses them by label. How they were found is
    an entry of the file, which labelme keeps when it writes the file again.
    """
    rows, cols = result.shape
    names = {contour.group: contour.name for contour in result.contours if not contour.hole}
    shapes: list[dict[str, Any]] = [
        {
            "label": contour.name or (names.get(contour.group) if contour.hole else "") or CONTOUR,
            "points": pairs(contour.points),
            "group_id": contour.group or None,
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
            ENTRY: facts_of(result),
        }
    )


def _kind(contour: Contour) -> str:
    if contour.closed and len(contour.points) > 2:
        return "polygon"
    return "linestrip" if len(contour.points) > 1 else "point"
