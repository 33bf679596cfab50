"""The tables of formats, from the lists that readers and writers go by, and what checks each in the tests."""

from __future__ import annotations

from cpm_core.formats import (
    CENTERLINES_WRITABLE,
    CONTOURS_WRITABLE,
    SKELETONS_WRITABLE,
    VOLUMES_WRITABLE,
)
from docs.making.tables import table

CHECKED: dict[str, str] = {
    ".svg": "an XML parser, and read back",
    ".csv": "the csv module, and read back",
    ".measures.csv": "the csv module",
    ".table.csv": "the csv module",
    ".json": "the json module, and read back",
    ".geojson": "shapely, and read back",
    ".zip": "roifile, and read back",
    ".roi": "roifile, and read back",
    ".labelme.json": "the json module, and read back",
    ".coco.json": "pycocotools, and read back",
    ".tif": "tifffile and Pillow, and read back",
    ".tiff": "tifffile and Pillow, and read back",
    ".nii": "nibabel, and read back",
    ".nii.gz": "nibabel, and read back",
    ".nrrd": "pynrrd and slicerio, and read back",
    ".seg.dcm": "highdicom, and read back",
    ".dxf": "ezdxf, and read back",
    ".png": "Pillow, and read back",
    ".figure.svg": "an XML parser",
    ".figure.png": "Pillow",
    ".figure.pdf": "its head alone",
    ".ply": "by its published layout, and read back",
    ".stl": "by its published layout, and read back",
    ".obj": "by its published layout, and read back",
    ".vtk": "by its published layout, and read back",
    ".points.csv": "read back",
    ".swc": "by its published layout, and read back",
}
"""What reads a format in the tests."""


def writable() -> str:
    """From what each file is written, and what checks it."""
    lines = []
    for suffix in {**CONTOURS_WRITABLE, **VOLUMES_WRITABLE, **CENTERLINES_WRITABLE}:
        of = [
            word
            for word, known in (
                ("contours", CONTOURS_WRITABLE), ("skeletons", SKELETONS_WRITABLE), ("volumes", VOLUMES_WRITABLE),
                ("center lines", CENTERLINES_WRITABLE),
            )
            if suffix in known
        ]  # fmt: skip
        lines.append((f"`{suffix}`", ", ".join(of), CHECKED[suffix]))
    return table(("suffix", "written from", "checked in the tests by"), lines)
