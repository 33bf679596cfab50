"""The formats in the export dialog: short names in groups, images first."""

from __future__ import annotations

import sys
from dataclasses import dataclass

from app.model.text.language import from_core, tr
from cpm_core.formats import FOR_VOLUMES, WRITABLE
from cpm_core.formats.writers import DRAWN
from cpm_core.image.drawing import has_matplotlib


@dataclass(frozen=True, slots=True)
class Format:
    """A format by the suffix of its files, with its name and its group."""

    suffix: str
    name: str
    group: str


_IMAGES, _DRAWINGS, _FIGURES, _ANNOTATIONS, _TABLES, _OTHERS = (
    tr("Images"),
    tr("Drawings"),
    tr("Figures"),
    tr("Annotations"),
    tr("Tables and data"),
    tr("Others"),
)

_KNOWN = (
    Format(".png", tr("PNG mask"), _IMAGES),
    Format(".tif", tr("TIFF mask"), _IMAGES),
    Format(".nii.gz", tr("NIfTI mask, compressed"), _IMAGES),
    Format(".nii", tr("NIfTI mask"), _IMAGES),
    Format(".svg", tr("SVG drawing"), _DRAWINGS),
    Format(".dxf", tr("DXF for CAD"), _DRAWINGS),
    Format(".figure.svg", tr("Figure as SVG, with image and scale bar"), _FIGURES),
    Format(".figure.pdf", tr("Figure as PDF"), _FIGURES),
    Format(".figure.png", tr("Figure as PNG"), _FIGURES),
    Format(".geojson", tr("GeoJSON for QuPath"), _ANNOTATIONS),
    Format(".labelme.json", tr("labelme"), _ANNOTATIONS),
    Format(".coco.json", tr("COCO"), _ANNOTATIONS),
    Format(".zip", tr("ImageJ, all selections"), _ANNOTATIONS),
    Format(".roi", tr("ImageJ, one selection"), _ANNOTATIONS),
    Format(".measures.csv", tr("CSV, one row per contour"), _TABLES),
    Format(".csv", tr("CSV, one row per vertex"), _TABLES),
    Format(".json", tr("JSON with everything"), _TABLES),
)

_OF_VOLUMES = (
    Format(".ply", tr("PLY, with normals"), tr("Surfaces")),
    Format(".stl", tr("STL for printing"), tr("Surfaces")),
    Format(".obj", tr("OBJ, as text"), tr("Surfaces")),
    Format(".vtk", tr("VTK poly data"), tr("Surfaces")),
    Format(".nii.gz", tr("NIfTI, compressed"), tr("Label volumes")),
    Format(".nii", tr("NIfTI"), tr("Label volumes")),
    Format(".tif", tr("TIFF stack"), tr("Label volumes")),
    Format(".points.csv", tr("CSV, one row per particle"), tr("Particles")),
    Format(".swc", tr("SWC, a tree of points with radii"), tr("Center lines")),
)

_SAME = {".tiff": ".tif"}
"""Suffixes of the same format."""


def formats() -> tuple[Format, ...]:
    """All formats that can be written, those of one group next to each other; new ones are last.

    A frozen application without matplotlib, which nobody can add to it, offers no figures.
    """
    known = {one.suffix for one in _KNOWN} | _SAME.keys()
    others = (Format(suffix, from_core(text), _OTHERS) for suffix, text in WRITABLE.items() if suffix not in known)
    left_out = DRAWN if getattr(sys, "frozen", False) and not has_matplotlib() else ()
    return (*(one for one in _KNOWN if one.suffix in WRITABLE and one.suffix not in left_out), *others)


def formats_of_volumes() -> tuple[Format, ...]:
    """All formats in which the result of a volume can be written, in groups; new ones are last."""
    known = {one.suffix for one in _OF_VOLUMES} | _SAME.keys()
    others = (Format(suffix, from_core(text), _OTHERS) for suffix, text in FOR_VOLUMES.items() if suffix not in known)
    return (*_OF_VOLUMES, *others)


def listed(suffix: str) -> str:
    """The suffix under which the format of a suffix is listed."""
    return _SAME.get(suffix, suffix)
