"""Export: what can be written and in which formats, names of files, and the content of each."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from cpm_app.model.document.document import Document
from cpm_app.model.document.objects import build_objects_result
from cpm_app.model.text.language import localize_number, tr, translate_core_text
from cpm_core import Contour, Image, Result, Skeleton
from cpm_core.contours import select_bridges_on
from cpm_core.formats import (
    ANIMATIONS_WRITABLE,
    CENTERLINES_WRITABLE,
    CONTOURS_WRITABLE,
    FIGURE_SUFFIXES,
    SKELETONS_WRITABLE,
    STACKS_WRITABLE,
    SURFACE_SUFFIXES,
    VOLUMES_WRITABLE,
    choose_file_name,
    count_left_out,
    encode_measures_table,
)
from cpm_core.formats.meshes.simplification import Simplification, measure_change, simplify_surface
from cpm_core.image import Convention
from cpm_core.numerics import polyline
from cpm_core.numerics.packages import has_package
from cpm_core.numerics.types import frozen
from cpm_core.shapes import select_measures

ExportKind = Literal[
    "objects", "contours", "skeleton", "surface", "lines", "pages", "measures", "space", "turntable", "run"
]

EXPORT_TITLES = {
    "objects": (tr("Objects"), tr("Export objects")),
    "contours": (tr("Contours"), tr("Export contours")),
    "skeleton": (tr("Skeleton"), tr("Export skeleton")),
    "surface": (tr("Surface"), tr("Export surface")),
    "lines": (tr("Center lines"), tr("Export center lines")),
    "pages": (tr("All pages"), tr("Export all pages")),
    "measures": (tr("Measures"), tr("Export measures")),
    "space": (tr("View in space"), tr("Export view in space")),
    "turntable": (tr("Turn of the view in space"), tr("Export turntable")),
    "run": (tr("Animation of the run"), tr("Export animation")),
}
"""Heading of each kind, and title of the dialog where only that can be written."""

_FORMAT_NAMES = {
    ".labelme.json": tr("labelme"),
    ".coco.json": tr("COCO"),
    ".geojson": tr("GeoJSON for QuPath"),
    ".zip": tr("ImageJ ROI set"),
    ".png": tr("Labels, PNG"),
    ".tif": tr("Labels, TIFF"),
    ".nii.gz": tr("Labels, NIfTI"),
    ".nrrd": tr("Labels, NRRD"),
    ".seg.dcm": tr("Segments, DICOM"),
    ".table.csv": tr("CSV, one row per object"),
    ".measures.csv": tr("CSV, one row per contour"),
    ".csv": tr("CSV, one row per vertex"),
    ".points.csv": tr("CSV, one row per particle"),
    ".json": tr("JSON with everything"),
    ".svg": tr("SVG drawing"),
    ".dxf": tr("DXF for CAD"),
    ".figure.png": tr("Figure, PNG"),
    ".figure.pdf": tr("Figure, PDF"),
    ".figure.svg": tr("Figure, SVG"),
    ".stl": tr("STL for printing"),
    ".ply": tr("PLY, with normals"),
    ".obj": tr("OBJ"),
    ".vtk": tr("VTK poly data"),
    ".swc": tr("SWC"),
}
"""Names of formats by the suffixes of their writers, in the order shown."""

_ANIMATION_NAMES = {".gif": tr("GIF"), ".png": tr("APNG, in full color"), ".mp4": tr("MP4 video")}
"""Names of the formats of animations, by suffix."""

_FORMATS_BY_KIND = {
    "skeleton": SKELETONS_WRITABLE,
    "surface": VOLUMES_WRITABLE,
    "lines": CENTERLINES_WRITABLE,
    "pages": STACKS_WRITABLE,
    "run": ANIMATIONS_WRITABLE,
    "turntable": ANIMATIONS_WRITABLE,
    "space": {".png": tr("PNG")},
    "measures": {".csv": tr("CSV, one row per measure")},
}
"""Writers of each kind that is not written as contours, by suffix."""

_ALIAS_SUFFIXES = {".tiff": ".tif", ".nii": ".nii.gz", ".roi": ".zip", ".apng": ".png"}
"""Suffixes of the same format, or of one that holds less."""

_OMITTED_SUFFIXES = {"objects": ".measures.csv .points.csv", "contours": ".table.csv"}
"""Suffixes that are not offered for a kind, between spaces."""


def list_export_formats(
    kind: ExportKind = "contours", in_volume: bool = False, of_dicom: bool = False
) -> dict[str, str]:
    """Return the names of the formats for a kind of content, by suffix; those without a fixed place are last.

    DICOM segmentations are offered where the image is `of_dicom` and the package that writes them is installed. A
    frozen application without matplotlib, which cannot be added to it, offers no figures.
    """
    writable = VOLUMES_WRITABLE if in_volume and kind == "objects" else _FORMATS_BY_KIND.get(kind, CONTOURS_WRITABLE)
    names = {"space": writable, "measures": writable, "run": _ANIMATION_NAMES, "turntable": _ANIMATION_NAMES}.get(
        kind, _FORMAT_NAMES
    )
    lacking = {*_ALIAS_SUFFIXES, *_OMITTED_SUFFIXES.get(kind, "").split()}
    if getattr(sys, "frozen", False) and not has_package("matplotlib"):
        lacking |= FIGURE_SUFFIXES
    if writable is VOLUMES_WRITABLE:
        lacking.add(".csv")  # the same as .table.csv
    if not of_dicom or not has_package("highdicom"):
        lacking.add(".seg.dcm")
    known = {suffix: name for suffix, name in names.items() if suffix in writable}
    known |= {suffix: translate_core_text(text) for suffix, text in writable.items() if suffix not in known}
    return {suffix: name for suffix, name in known.items() if suffix not in lacking}


def export_file_name(base: str, kind: ExportKind, suffix: str, alone: bool) -> str:
    """Return the name of a file; of several for labelme, only one that is `alone` can have the name of the image."""
    if kind in ("pages", "measures") or (suffix == ".labelme.json" and not alone):
        return f"{base}_{kind}{suffix}"
    return choose_file_name(base, kind, suffix)


HAND_EDITED_SUFFIXES = frozenset({".labelme.json"})
"""Suffixes of formats that are edited by hand, where few vertices are better."""


@frozen
class ExportFile:
    """A file to write: its path, the kind of its content, and the suffix of its format."""

    path: Path
    kind: ExportKind
    suffix: str


@frozen
class ExportOrder:
    """Files to write, and how.

    Attributes
    ----------
    files : tuple of ExportFile
        The files.
    objects, contours : frozenset of int or None
        Numbers of the objects and indices of the contours that are written; None for all.
    tolerance : float
        How far a line may move where vertices are left out [px]; 0 keeps all.
    simplify_all_formats : bool
        Whether vertices are left out in all formats, not only in those that are edited by hand.
    space : {"LPS", "RAS"}
        Where the coordinates of a surface point.
    in_units : bool
        Whether lengths are in the unit of the image too, where it is known.
    simpler : Simplification
        How the surface in files of triangles is made simpler.
    """

    files: tuple[ExportFile, ...] = ()
    objects: frozenset[int] | None = None
    contours: frozenset[int] | None = None
    tolerance: float = 0.0
    simplify_all_formats: bool = False
    space: Convention = "LPS"
    in_units: bool = True
    simpler: Simplification = Simplification()

    def should_simplify(self, suffix: str) -> bool:
        """Tell whether something is left out or smoothed in a format."""
        if suffix in SURFACE_SUFFIXES:
            return bool(self.simpler)
        return self.tolerance > 0.0 and (self.simplify_all_formats or suffix in HAND_EDITED_SUFFIXES)


def has_objects_to_export(document: Document) -> bool:
    """Tell whether a document has objects to export, for which no run is needed."""
    return any(not item.hidden for item in document.objects.items)


def encode_measures(document: Document, order: ExportOrder, image: Image) -> bytes:
    """Encode the table of the measures of a document."""
    assert document.image is not None
    known = document.image.with_known_pixel_size(image)
    if not order.in_units:
        known = known.with_spacing((1.0,) * known.ndim, None)
    return encode_measures_table(select_measures(document.shapes), known, document.parameters.channel)


def prepare_export(
    found: Result | Skeleton | None,
    document: Document,
    order: ExportOrder,
    kind: ExportKind,
    image: Image | None = None,
) -> Result | Skeleton:
    """Return what is exported, with all its vertices; ValueError where there is nothing of the kind."""
    result = build_objects_result(document, order.objects) if kind == "objects" else found
    if result is None:
        raise ValueError(tr("There is nothing to export yet: start a run first."))
    known = document.image
    if known is not None and known.unit and not known.is_volume:  # it may have been set after the run
        result = replace(result, spacing=known.spacing, unit=known.unit)
    if not order.in_units:
        result = replace(result, spacing=(1.0,) * len(result.spacing), unit=None)
    if isinstance(result, Skeleton):
        return result
    if kind == "objects":  # tables measure gray levels in the image, and it says where a volume lies in space
        return replace(result, image=image)
    if order.contours is None:
        return result
    kept = tuple(contour for index, contour in enumerate(result.contours) if index in order.contours)
    return replace(result, contours=kept, bridges=select_bridges_on(result.bridges, kept))


def simplify_result(result: Result | Skeleton, order: ExportOrder) -> Result | Skeleton:
    """Leave out vertices of a result, so that its lines move by no more than the tolerance; simplify its surface."""
    if isinstance(result, Skeleton):  # whose vertices have radii
        return result
    if result.surface is not None:
        return replace(result, surface=simplify_surface(result.surface, order.simpler))
    return replace(result, contours=tuple(_simplify_contour(contour, order.tolerance) for contour in result.contours))


def describe_change(before: Result | Skeleton, after: Result | Skeleton) -> str:
    """Tell how far the surface of a result was moved when it was made simpler; empty if it was not."""
    if before.surface is None or after.surface is None or after.surface is before.surface:
        return ""
    change, unit = measure_change(before.surface, after.surface), before.surface.unit or tr("voxels")
    mean, largest = (localize_number(f"{away:.3g}") for away in (change.mean, change.largest))
    return tr("moved by {mean} {unit} on average, {largest} at most", mean=mean, unit=unit, largest=largest)


def _simplify_contour(contour: Contour, tolerance: float) -> Contour:
    points = contour.points
    if not contour.closed:
        return replace(contour, points=np.array(polyline.simplify_path(points.tolist(), tolerance)))
    middle = np.linalg.norm(points - points[0], axis=1).argmax()
    halves = points[: middle + 1], np.concatenate([points[middle:], points[:1]])
    few = [corner for half in halves for corner in polyline.simplify_path(half.tolist(), tolerance)[:-1]]
    return replace(contour, points=np.array(few)) if len(few) > 2 else contour


def describe_export(result: Result | Skeleton, kind: ExportKind, suffix: str) -> str:
    """Tell what a file with a suffix holds of a result, and what it leaves out."""
    surface, missing = result.surface, count_left_out(result, suffix)
    if kind == "objects":
        groups = {one.group for one in result.contours}
        count = len(groups if surface is None or surface.numbers is None else set(surface.numbers.tolist()))
        text = tr("1 object") if count == 1 else tr("{count} objects", count=count)
    elif surface is not None:
        text = tr("a surface of {count} triangles", count=localize_number(f"{len(surface.faces):,}"))
        left = surface.left_out and suffix in SURFACE_SUFFIXES
        return f"{text}, {tr('{count} parts left out', count=surface.left_out)}" if left else text
    else:
        count = len(result.contours) - missing
        text = tr("1 contour") if count == 1 else tr("{count} contours", count=count)
    return f"{text}, {tr('{count} open ones left out', count=missing)}" if missing else text
