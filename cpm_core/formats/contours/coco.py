"""COCO: closed contours as instances, to train and evaluate learned segmentation."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import Any

import numpy as np

from cpm_core.contours.contour import Contour
from cpm_core.contours.measurements import Measures, measure
from cpm_core.contours.rasterize import Labels, paint
from cpm_core.contours.result import Result
from cpm_core.formats.common.provenance import ENTRY, PROGRAM, facts_of
from cpm_core.formats.contours.contents import DEFAULT, Contents, color_of, rgb
from cpm_core.formats.contours.json_text import PIXEL, pairs, rounded, text
from cpm_core.formats.contours.mask import mask_of_runs, outlines
from cpm_core.medial_axis.skeleton import Skeleton

_OBJECT = "object"
"""Category of an instance without a name."""

_OUTLINES, _HOLES = "outlines", "holes"
"""Entries of CPM next to a run-length mask: its curves as polygons, and which of them are holes."""

_Part = tuple[Contour, Measures]


def encode(result: Result | Skeleton) -> bytes:
    """Write an instance for each label of the label mask, with its net area and its box.

    Names are categories. Coordinates are x, y in px from the corner of the image. An instance without anything inside
    it is one polygon, or several for an object of several parts. The polygons of this format have no holes: an instance
    with holes, or with other contours in it, is a run-length mask, which equals its label in the label mask; beside it
    its ``outlines`` are polygons, of which ``holes`` tells those that are holes. Its ``gross_area`` is what its
    contours enclose. Open contours are left out. ValueError when no contour is closed.
    """
    rows = measure(result.contours, result.spacing, contrast=False)
    closed = [pair for pair in zip(result.contours, rows, strict=True) if pair[1].label and len(pair[0].points) > 2]
    if not closed:
        raise ValueError(
            f"No contour of {result.source} is closed, and a COCO file holds only closed ones: "
            "let it run on, or export to GeoJSON or CSV."
        )
    categories = sorted({contour.name or _OBJECT for contour, _ in closed})
    surrounding = {row.inside for row in rows if row.closed}
    labels = paint(result.contours, result.shape) if surrounding - {0} else None
    instances = []
    for _, group in groupby(sorted(closed, key=lambda pair: pair[1].label), key=lambda pair: pair[1].label):
        parts = list(group)
        filled = labels is None or surrounding.isdisjoint(row.number for _, row in parts)
        own = [one for one in result.contours if one.hole and one.group == parts[0][0].group and len(one.points) > 2]
        if not filled and labels is not None and not (labels == parts[0][1].label).any():  # hidden by another one
            shown = paint([*(contour for contour, _ in parts), *own], result.shape) > 0
            instances.append(_instance(parts, categories, shown * np.uint32(parts[0][1].label), own))
            continue
        instances.append(_instance(parts, categories, None if filled else labels, own))
    height, width = result.shape
    return text(
        {
            "info": {
                "description": f"Contours of {result.source}",
                "contributor": PROGRAM,
                ENTRY: facts_of(result),
            },
            "licenses": [],
            "images": [{"id": 1, "file_name": result.source, "width": width, "height": height}],
            "categories": [{"id": k, "name": name, "supercategory": ""} for k, name in enumerate(categories, start=1)],
            "annotations": instances,
        }
    )


def _instance(
    parts: Sequence[_Part], categories: Sequence[str], labels: Labels | None, holes: Sequence[Contour]
) -> dict[str, Any]:
    """One label: its parts as polygons, or as a run-length mask out of a label mask."""
    (first, row), *_ = parts
    outlines = [np.array(pairs(contour.points)) for contour, _ in parts]
    corners = np.concatenate(outlines)
    low, size = corners.min(axis=0), np.ptp(corners, axis=0)
    polygons: Any = [rounded(outline.ravel()) for outline in outlines]
    masked: dict[str, Any] = {}
    if labels is not None:
        masked[_OUTLINES] = [*polygons, *(rounded(np.array(pairs(hole.points)).ravel()) for hole in holes)]
        masked[_HOLES] = [False] * len(polygons) + [True] * len(holes)
    return {
        "id": row.number,
        "image_id": 1,
        "category_id": 1 + categories.index(first.name or _OBJECT),
        "segmentation": polygons if labels is None else _runs(labels, row.label, parts),
        "area": round(sum(row.net_area for _, row in parts), 4),
        "gross_area": round(sum(row.area for _, row in parts), 4),
        "bbox": rounded(np.concatenate([low, size])),
        "iscrowd": 0,
        "color": list(rgb(first)),
        **masked,
    }


def _runs(labels: Labels, label: int, parts: Sequence[_Part]) -> dict[str, Any]:
    """Lengths of the runs of pixels without and with a label in turn, down one column after the other."""
    height, width = labels.shape
    points = np.concatenate([contour.points for contour, _ in parts])
    low = np.clip(np.floor(points.min(axis=0)).astype(int), 0, labels.shape)
    high = np.clip(np.ceil(points.max(axis=0)).astype(int) + 1, 0, labels.shape)
    part = labels[low[0] : high[0], low[1] : high[1]].T
    cols, rows = np.nonzero(np.equal(part, label))
    places = (cols + low[1]) * height + rows + low[0]
    begins = np.diff(places, prepend=-2) > 1
    ends = np.append(begins[1:], True) if len(places) else begins
    bounds = np.stack([places[begins], places[ends] + 1], axis=1).ravel()
    return {"counts": np.diff(bounds, prepend=0, append=height * width).tolist(), "size": [height, width]}


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
            _add(found, entry, "" if name == _OBJECT else name)
    return found


def _add(found: Contents, entry: dict[str, Any], name: str) -> None:
    color = color_of(entry.get("color"))
    known: dict[str, Any] = {"name": name, "color": "" if color == DEFAULT else color}
    shapes = entry.get("segmentation")
    if entry.get(_OUTLINES):
        found.add_object(zip(map(_corners, entry[_OUTLINES]), entry[_HOLES], strict=True), **known)
    elif isinstance(shapes, dict):
        found.add_object(outlines(mask_of_runs(shapes)), **known)
    elif shapes:
        found.add_object(((_corners(ring), False) for ring in shapes), **known)
    else:
        found.left_out["instance without an outline"] += 1


def _corners(ring: Any) -> Any:
    return np.array(ring, dtype=np.float64).reshape(-1, 2)[:, ::-1] - PIXEL
