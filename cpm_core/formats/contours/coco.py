"""COCO: closed contours as instances, for training and evaluating learned segmentation."""

from __future__ import annotations

import re
from collections.abc import Callable, Container
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.contours.contour import Contour
from cpm_core.contours.measurements import Measures, measure
from cpm_core.contours.rasterize import rasterize_labels
from cpm_core.formats.common.content import UnreadableError
from cpm_core.formats.common.json_values import encode_json
from cpm_core.formats.common.printable import make_printable
from cpm_core.formats.common.provenance import PROGRAM_NAME, PROVENANCE_KEY, Outcome, describe_provenance
from cpm_core.formats.contours.contents import (
    PIXEL_OFFSET,
    CollectedContours,
    PlaneInfo,
    contour_rgb,
    round_coordinates,
)
from cpm_core.formats.contours.mask import decode_runs, find_outlines
from cpm_core.numerics.types import JsonDict
from cpm_core.parameters.formatting import format_size

_UNNAMED_CATEGORY = "object"
"""Category of an instance without a name."""

_OUTLINES_KEY = "outlines"
"""Entry of CPM next to a run-length mask: its curves as polygons."""

_HOLES_KEY = "holes"
"""Entry of CPM next to a run-length mask: whether each of its curves is a hole."""


def encode_coco(result: Outcome) -> bytes:
    """Write an instance for each label of the label mask, which is its id, with its net area and its box.

    Classes, or else names, become categories. Coordinates are (x, y) in px from the corner of the image. An instance
    with nothing inside it is one polygon, or several for an object of several parts. Polygons of this format have no
    holes: an instance with holes, or with other contours in it, is a run-length mask equal to its label in the label
    mask, with its ``outlines`` as polygons and ``holes`` marking those that are holes. ``gross_area`` is the area
    enclosed by its contours, ``score`` the confidence of an object. Open contours are left out. ValueError when no
    contour is closed.
    """
    rows = measure(result.contours, result.spacing, contrast=False)
    parts: dict[int, list[tuple[Contour, Measures]]] = {}
    for contour, row in zip(result.contours, rows, strict=True):
        if row.label and len(contour.points) > 2:
            parts.setdefault(row.label, []).append((contour, row))
    if not parts:
        raise ValueError(
            f"No contour of {result.source} is closed, and a COCO file holds only closed ones: "
            "continue the run, or export to GeoJSON or CSV."
        )
    categories = sorted({_category_name(contour) for pairs in parts.values() for contour, _ in pairs})
    surrounding = {row.inside for row in rows if row.closed}
    labels = rasterize_labels(result.contours, result.shape) if surrounding - {0} else None
    height, width = result.shape
    instances: list[JsonDict] = []
    for label, pairs in sorted(parts.items()):
        first, _ = pairs[0]
        polygons = [_flatten_polygon(contour) for contour, _ in pairs]
        corners = np.reshape(np.concatenate(polygons), (-1, 2))
        instance = {
            "id": label,
            "image_id": 1,
            "category_id": 1 + categories.index(_category_name(first)),
            "segmentation": polygons,
            "area": round(sum(row.net_area for _, row in pairs), 4),
            "gross_area": round(sum(row.area for _, row in pairs), 4),
            "bbox": round_coordinates(np.concatenate([corners.min(axis=0), np.ptp(corners, axis=0)])),
            "iscrowd": 0,
            "color": list(contour_rgb(first)),
        }
        if first.category:
            instance["name"] = first.name
        if first.confidence is not None:
            instance["score"] = round(first.confidence, 6)
        if labels is not None and not surrounding.isdisjoint(row.number for _, row in pairs):
            holes = [one for one in result.contours if one.hole and one.group == first.group and len(one.points) > 2]
            mask = labels == label
            if not mask.any():  # hidden by another object
                mask = rasterize_labels([*(contour for contour, _ in pairs), *holes], result.shape) > 0
            changes = np.flatnonzero(np.diff(mask.T.ravel(), prepend=False, append=False))
            counts = np.diff(changes, prepend=0, append=labels.size).tolist()  # down one column after the other
            instance["segmentation"] = {"counts": counts, "size": [height, width]}
            instance[_OUTLINES_KEY] = [*polygons, *map(_flatten_polygon, holes)]
            instance[_HOLES_KEY] = [False] * len(polygons) + [True] * len(holes)
        instances.append(instance)
    return encode_json(
        {
            "info": {
                "description": f"Contours of {result.source}",
                "contributor": PROGRAM_NAME,
                PROVENANCE_KEY: describe_provenance(result),
            },
            "licenses": [],
            "images": [{"id": 1, "file_name": result.source, "width": width, "height": height}],
            "categories": [{"id": k, "name": name, "supercategory": ""} for k, name in enumerate(categories, start=1)],
            "annotations": instances,
        }
    )


def _category_name(contour: Contour) -> str:
    """Return the category of a contour: its class, else its name."""
    return contour.category or contour.name or _UNNAMED_CATEGORY


def _flatten_polygon(contour: Contour) -> list[float]:
    """Flatten a contour to [x1, y1, x2, y2, ...] from the corner of the image [px]."""
    return round_coordinates((contour.points[:, ::-1] + PIXEL_OFFSET).ravel())


def read_coco(content: JsonDict, plane: PlaneInfo) -> CollectedContours:
    """Read the contours of the instances of one image; see `_select_image`.

    The category becomes the class of a contour, and its name if it has none. Contours of run-length masks run between
    pixels, unless CPM has written their outlines next to them.
    """
    found = CollectedContours(is_own=PROVENANCE_KEY in (content.get("info") or {}))
    categories = {entry["id"]: entry["name"] for entry in content.get("categories", [])}
    used = {str(entry["image_id"]) for entry in content["annotations"]}
    image, note = _select_image(content["images"], used, plane)
    found.shape = _image_shape(image)
    found.notes += note
    if found.shape and plane.shape and found.shape != plane.shape:
        there, here = (format_size(shape) for shape in (found.shape, plane.shape))
        found.notes.append(f"Its image has {there}, this one {here}.")
    for entry in content["annotations"]:
        if str(entry["image_id"]) == str(image.get("id")):
            name = categories.get(entry.get("category_id"), "")
            _add_instance(found, entry, "" if name == _UNNAMED_CATEGORY else name)
    return found


def _select_image(images: list[JsonDict], used: Container[str], plane: PlaneInfo) -> tuple[JsonDict, list[str]]:
    """Select the image at hand among those of a file, and note what makes that doubtful.

    It is the one of its name, whatever the folders, capitals and suffix; else one without a name whose id is its name;
    else the only one of its size that has instances. Without an image at hand it is the first with instances.

    Raises
    ------
    UnreadableError
        When it is none of several images, or may be more than one, or has no instances.
    """
    with_instances = [image for image in images if str(image["id"]) in used]
    if not plane.name:
        first = next(iter(with_instances), {})
        many = f"The file has instances of {len(with_instances)} images: those of {_image_name(first)} were read."
        return first, [many] * (len(with_instances) > 1)
    at_hand = make_printable(plane.name)
    rules: tuple[Callable[[JsonDict], bool], ...] = (
        lambda image: at_hand.lower() in _list_names(image),
        lambda image: Path(at_hand).stem.lower() in {Path(name).stem for name in _list_names(image)},
        lambda image: not _list_names(image) and Path(at_hand).stem.lstrip("0") == str(image["id"]).lstrip("0"),
    )
    for rule in rules:
        found = [image for image in images if rule(image)]
        fitting = [image for image in found if _image_shape(image) in (None, plane.shape)] or found
        if len(fitting) > 1:
            raise UnreadableError(
                f"The file has {len(fitting)} images named {at_hand}: save the instances of one alone."
            )
        if fitting and with_instances and str(fitting[0]["id"]) not in used:
            raise UnreadableError(f"The file has instances of other images, but none of {at_hand}: choose another one.")
        if fitting:
            return fitting[0], []
    fitting = [image for image in with_instances if _image_shape(image) in (None, plane.shape)]
    if len(with_instances) > 1 and len(fitting) != 1:
        raise UnreadableError(
            f"The file has instances of {len(with_instances)} images, such as {_image_name(with_instances[0])}, but "
            f"none named {at_hand}: rename the image, or choose another file."
        )
    chosen = next(iter(fitting or with_instances), {})
    return chosen, [f"Its instances are those of {_image_name(chosen)}, not of {at_hand}."] if chosen else []


def _list_names(image: JsonDict) -> set[str]:
    """List the names of an image without folders, in small letters: its own, and the one before it was renamed."""
    original = image["extra"].get("name") if isinstance(image.get("extra"), dict) else None
    names = (image.get("file_name"), original)
    return {make_printable(re.split(r"[/\\]", str(name))[-1]).lower() for name in names if name}


def _image_name(image: JsonDict) -> str:
    """Return the name of an image for a message."""
    return make_printable(str(image.get("file_name") or image.get("id", "")))


def _image_shape(image: JsonDict) -> tuple[int, int] | None:
    """Return rows and columns of an image; None where the file does not state them."""
    height, width = image.get("height"), image.get("width")
    return (int(height), int(width)) if height and width else None


def _add_instance(found: CollectedContours, entry: JsonDict, name: str) -> None:
    """Add the contours of an instance."""
    known: JsonDict = {"name": entry.get("name") or name, "category": name, "color": entry.get("color")}
    shapes = entry.get("segmentation")
    if entry.get(_OUTLINES_KEY):
        found.add_object(zip(map(_parse_ring, entry[_OUTLINES_KEY]), entry[_HOLES_KEY], strict=True), **known)
    elif isinstance(shapes, dict):
        found.add_object(find_outlines(decode_runs(shapes)), **known)
    elif shapes:
        found.add_object(((_parse_ring(ring), False) for ring in shapes), **known)
    else:
        found.omissions["instance without an outline"] += 1


def _parse_ring(ring: Any) -> Any:
    """Parse a ring [x1, y1, x2, y2, ...] as vertices (row, col), shape (K, 2) [px]."""
    return np.array(ring, float).reshape(-1, 2)[:, ::-1] - PIXEL_OFFSET
