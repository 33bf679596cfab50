"""Export: the formats on offer, what is written to a file, and what a format leaves out."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

from app.model.document.document import Document
from app.model.document.modes import MODES
from app.model.document.objects import objects_result
from app.model.text.language import from_core, tr, written
from cpm_core import METHODS, Image, Parameters, Result, Skeleton, edge_map
from cpm_core.contours import apply, reviewed, with_kept
from cpm_core.formats import DRAWN, FOR_VOLUMES, WRITABLE, facts_on, left_out, plain_shapes, text_of
from cpm_core.image import Convention, has_matplotlib
from cpm_core.parameters import Provenance, taken
from cpm_core.reconstruction import can_be_closed, close_contours

_IMAGES = {
    ".png": tr("PNG mask"),
    ".tif": tr("TIFF mask"),
    ".nii.gz": tr("NIfTI mask, compressed"),
    ".nii": tr("NIfTI mask"),
    ".svg": tr("SVG drawing"),
    ".dxf": tr("DXF for CAD"),
    ".figure.svg": tr("Figure as SVG, with image and scale bar"),
    ".figure.pdf": tr("Figure as PDF"),
    ".figure.png": tr("Figure as PNG"),
    ".geojson": tr("GeoJSON for QuPath"),
    ".labelme.json": tr("labelme"),
    ".coco.json": tr("COCO"),
    ".zip": tr("ImageJ, all selections"),
    ".roi": tr("ImageJ, one selection"),
    ".measures.csv": tr("CSV, one row per contour"),
    ".csv": tr("CSV, one row per vertex"),
    ".json": tr("JSON with everything"),
}
"""Formats of the contours of an image by the suffix of their files, images first."""

_VOLUMES = {
    ".ply": tr("PLY, with normals"),
    ".stl": tr("STL for printing"),
    ".obj": tr("OBJ, as text"),
    ".vtk": tr("VTK poly data"),
    ".nii.gz": tr("NIfTI labels, compressed"),
    ".nii": tr("NIfTI labels"),
    ".tif": tr("TIFF stack of labels"),
    ".points.csv": tr("CSV, one row per particle"),
    ".swc": tr("SWC, a tree of points with radii"),
}
"""Formats of what a run in a volume has found."""

_SAME = {".tiff": ".tif"}
"""Suffixes of the same format."""


def formats(*, of_volumes: bool = False) -> Mapping[str, str]:
    """Names of all formats that can be written, by suffix; new ones are last.

    A frozen application without matplotlib, which nobody can add to it, offers no figures.
    """
    known, writable = (_VOLUMES, FOR_VOLUMES) if of_volumes else (_IMAGES, WRITABLE)
    lacking = DRAWN if getattr(sys, "frozen", False) and not has_matplotlib() else ()
    others = {suffix: from_core(text) for suffix, text in writable.items() if suffix not in {*known, *_SAME}}
    return {suffix: name for suffix, name in {**known, **others}.items() if suffix not in lacking}


def listed(suffix: str) -> str:
    """The suffix under which the format of a suffix is listed."""
    return _SAME.get(suffix, suffix)


SOURCES = {
    "all": tr("All that are not rejected"),
    "kept": tr("Kept ones only"),
    "selected": tr("The selection"),
    "objects": tr("Objects"),
}
"""What can be exported, in the order shown; all but objects are contours of the run."""

Closing = Literal["", "edges", "straight"]
"""How open contours are closed: not at all, along the edges of the image, or straight."""


@dataclass(frozen=True, slots=True)
class ExportOrder:
    """How contours are exported.

    Attributes
    ----------
    source : str
        One of `SOURCES`.
    selected : frozenset of int
        Numbers of the selected contours.
    closing : {"", "edges", "straight"}
        How open contours are closed whose ends are near each other.
    outlines : bool
        Whether masks hold lines in place of filled contours.
    space : {"LPS", "RAS"}
        Where the coordinates of a surface point.
    """

    source: str = "all"
    selected: frozenset[int] = frozenset()
    closing: Closing = ""
    outlines: bool = False
    space: Convention = "LPS"


def has_objects(document: Document) -> bool:
    """Whether a document has something to export that needs no run."""
    return any(not item.hidden for item in document.objects.items)


def chosen(
    found: Result | Skeleton | None, document: Document, order: ExportOrder, image: Image | None = None
) -> Result | Skeleton:
    """What is exported, before open contours are closed; ValueError where there is nothing of the kind."""
    result = objects_result(document) if order.source == "objects" else found
    if result is None:
        raise ValueError(tr("There is nothing to export yet: let the particles run first."))
    known = document.image
    if known is not None and known.unit and not known.is_volume:  # it may have been set after the run
        result = replace(result, spacing=known.spacing, unit=known.unit)
    if isinstance(result, Skeleton):
        return result
    if order.source == "objects":  # the image says where a volume lies in space
        return result if result.surface is None else replace(result, image=image)
    kept = with_kept(result, document.marks)
    shown = apply(kept, document.marks)
    if order.source == "kept":
        verdicts = reviewed(kept.contours, document.marks)
        return _only(shown, {kept.contours[one.index].number for one in verdicts if one.verdict == "kept"})
    return _only(shown, order.selected) if order.source == "selected" else shown


def _only(found: Result, numbers: set[int] | frozenset[int]) -> Result:
    """The contours with some numbers, and the bridges on them."""
    contours = tuple(contour for contour in found.contours if contour.number in numbers)
    vertices = {tuple(point) for contour in contours for point in contour.points.tolist()}
    bridges = tuple(bridge for bridge in found.bridges if tuple(bridge.points[1].tolist()) in vertices)
    return replace(found, contours=contours, bridges=bridges)


def closed(result: Result | Skeleton, order: ExportOrder, image: Image, parameters: Parameters) -> Result | Skeleton:
    """The result with open contours closed as ordered."""
    if not order.closing or isinstance(result, Skeleton) or not any(map(can_be_closed, result.contours)):
        return result
    gray = image.gray(parameters.channel)
    return close_contours(result, edge_map(gray, parameters.smoothing) if order.closing == "edges" else None)


@dataclass(frozen=True, slots=True)
class ExportSummary:
    """How many contours are written and left out, and how many of those written were open and have been closed.

    `objects` is the number of objects whose boundaries the contours are, 0 for other contours. `triangles` is the
    number of those of the surface that a run in a volume has found, 0 for an image.
    """

    written: int
    left_out: int
    bridged: int
    objects: int = 0
    triangles: int = 0


def summarize(before: Result | Skeleton, after: Result | Skeleton, suffix: str, order: ExportOrder) -> ExportSummary:
    """What a file with a suffix holds of a result `before` and `after` open contours were closed."""
    missing = left_out(after, suffix, outlines=order.outlines)
    bridged = sum(one.closed for one in after.contours) - sum(one.closed for one in before.contours)
    whole = isinstance(after, Result) and order.source == "objects"
    objects = len({one.group for one in after.contours}) if whole else 0
    surface = after.surface if isinstance(after, Result) else None
    triangles = 0 if surface is None else len(surface.faces)
    if surface is not None and surface.numbers is not None:
        objects = len(set(surface.numbers.tolist()))
    return ExportSummary(len(after.contours) - missing, missing, bridged, objects, triangles)


def summary_text(summary: ExportSummary) -> str:
    """What is written and what is left out, in one line."""
    parts = []
    if summary.objects:
        parts = [tr("1 object") if summary.objects == 1 else tr("{count} objects").format(count=summary.objects)]
    elif not summary.triangles:
        parts = [tr("1 contour") if summary.written == 1 else tr("{count} contours").format(count=summary.written)]
    if summary.triangles:
        parts.append(tr("a surface of {count} triangles").format(count=written(f"{summary.triangles:,}")))
    if summary.bridged:
        parts.append(tr("{count} of them closed for the export").format(count=summary.bridged))
    if summary.left_out:
        parts.append(tr("{count} open ones left out").format(count=summary.left_out))
    return ", ".join(parts)


def provenance_comment(document: Document, *, steered: bool) -> str:
    """How the pictures of a run came about, for the file of an animation; empty without an image."""
    if document.image is None:
        return ""
    method = METHODS[MODES[document.mode].method]
    parameters = taken(document.parameters, method.parameters)
    shapes = plain_shapes(document.shapes)
    made = Provenance(method.name, parameters, shapes=shapes, steered=steered, sha256=document.image.sha256)
    return text_of(facts_on(document.image.name, made))
