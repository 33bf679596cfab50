"""JSON of CPM: contours of an image, or of all pages of a stack, with all that is known of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cpm_core.contours.contour import present_names
from cpm_core.formats.contours import contour_json
from cpm_core.formats.contours.pages import stack_json
from cpm_core.formats.contours.reading.contents import Contents


def is_own(content: Any) -> bool:
    """Whether plain JSON is of this format."""
    return isinstance(content, dict) and content.get("format") in (contour_json.FORMAT, stack_json.FORMAT)


def read(content: dict[str, Any]) -> Contents:
    """Contours with their numbers, objects and strengths, of a stack with their pages."""
    found = Contents()
    if content["format"] == contour_json.FORMAT:
        _add(found, content)
        return found
    for page in content["pages"]:
        if "contours" in page:
            _add(found, page, int(page["page"]))
    return found


def _add(found: Contents, content: Mapping[str, Any], page: int = 0) -> None:
    rows, cols = content["image"]["shape"]
    found.shape = int(rows), int(cols)
    for entry in map(present_names, content["contours"]):
        found.add(
            entry["points"],
            bool(entry["closed"]),
            page=page,
            junctions=entry["junctions"],
            strength=entry["strength"],
            name=entry["name"],
            color=entry["color"],
            number=entry["number"],
            group=int(entry.get("object", 0)),
            hole=bool(entry.get("hole", False)),
            bridged=float(entry.get("bridged", 0.0)),
            reached=entry.get("reached", ""),
        )
