"""Formats: a module reads or writes one kind of file; `readers` and `writers` choose the module for a file."""

from cpm_core.formats.contour_file import CONTOURS_READABLE, load_contours
from cpm_core.formats.contours.points_csv import load_points
from cpm_core.formats.images.readers import READABLE, holds_volume, load_image, load_pages, load_volume, open_stack
from cpm_core.formats.meshes.swc import load_centerlines
from cpm_core.formats.surface_file import SURFACES_READABLE, load_surface
from cpm_core.formats.writers import (
    FOR_CENTERLINES,
    FOR_SKELETONS,
    FOR_VOLUMES,
    OUTLINABLE,
    WRITABLE,
    check_export,
    encoded,
    export,
    left_out,
    omission,
    suffix_of,
)

__all__ = [
    "CONTOURS_READABLE",
    "FOR_CENTERLINES",
    "FOR_SKELETONS",
    "FOR_VOLUMES",
    "OUTLINABLE",
    "READABLE",
    "SURFACES_READABLE",
    "WRITABLE",
    "check_export",
    "encoded",
    "export",
    "holds_volume",
    "left_out",
    "load_centerlines",
    "load_contours",
    "load_image",
    "load_pages",
    "load_points",
    "load_surface",
    "load_volume",
    "omission",
    "open_stack",
    "suffix_of",
]
