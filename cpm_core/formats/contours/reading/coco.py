"""COCO: instances as contours, polygons and run-length masks."""

from __future__ import annotations

from typing import Any

import numpy as np

from cpm_core.formats.contours.appearance import DEFAULT
from cpm_core.formats.contours.json_text import PIXEL
from cpm_core.formats.contours.reading.contents import Contents, color_of
from cpm_core.formats.contours.reading.mask import outlines
from cpm_core.formats.contours.reading.run_lengths import mask_of

OBJECT = "object"
"""Category of an instance without a name."""

OUTLINES, HOLES = "outlines", "holes"
"""Entries of CPM beside a run-length mask: its curves as polygons, and which of them are holes."""


def is_coco(content: Any) -> bool:
    """Whether plain JSON is of this format."""
    return isinstance(content, dict) and "annotations" in content and "images" in content


def read(content: dict[str, Any], image_name: str = "") -> Contents:
    """Contours of the instances of one image: that of the given name, else the first with any.

    The category is the name of a contour. Of run-length masks contours run between pixels, unless CPM has written
    their outlines beside them.
    """
    found = Contents()
    categories = {entry["id"]: entry["name"] for entry in content.get("categories", [])}
    images = {entry["id"]: entry for entry in content["images"]}
    used = {entry["image_id"] for entry in content["annotations"]}
    wanted = [number for number, entry in images.items() if image_name and entry.get("file_name") == image_name]
    chosen = next(iter([*wanted, *(number for number in images if number in used)]), None)
    if chosen in images and {"height", "width"} <= images[chosen].keys():
        found.shape = int(images[chosen]["height"]), int(images[chosen]["width"])
    if len(used) > 1 and chosen in images:
        found.notes.append(
            f"The file has instances of {len(used)} images: those of "
            f"{images[chosen].get('file_name', chosen)} were read."
        )
    for entry in content["annotations"]:
        if entry["image_id"] == chosen:
            name = categories.get(entry.get("category_id"), "")
            _add(found, entry, "" if name == OBJECT else name)
    return found


def _add(found: Contents, entry: dict[str, Any], name: str) -> None:
    color = color_of(entry.get("color"))
    known: dict[str, Any] = {"name": name, "color": "" if color == DEFAULT else color}
    shapes = entry.get("segmentation")
    if entry.get(OUTLINES):
        found.add_object(zip(map(_corners, entry[OUTLINES]), entry[HOLES], strict=True), **known)
    elif isinstance(shapes, dict):
        found.add_object(outlines(mask_of(shapes)), **known)
    elif shapes:
        found.add_object(((_corners(ring), False) for ring in shapes), **known)
    else:
        found.left_out["instance without an outline"] += 1


def _corners(ring: Any) -> Any:
    return np.array(ring, dtype=np.float64).reshape(-1, 2)[:, ::-1] - PIXEL
