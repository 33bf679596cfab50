"""Writers of contours and skeletons: each format by the suffix of its files.

A new one is a module of its own with a function that makes the bytes of a file, and a line in `_WRITERS`.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import MappingProxyType

import numpy as np

from cpm_core.contours.measurements import contour_labels
from cpm_core.contours.result import Result
from cpm_core.formats.common.atomic import check_place, write_together
from cpm_core.formats.common.printable import printable
from cpm_core.formats.contours import coco, contour_csv, contour_json, figure, geojson, imagej, labelme, svg
from cpm_core.formats.contours.dxf import drawing as dxf
from cpm_core.formats.masks import label_tiff, labels, nifti
from cpm_core.formats.meshes import obj, ply, points_csv, stl, swc, vtk
from cpm_core.image.drawing import require_matplotlib
from cpm_core.image.geometry import Convention
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.medial_axis.space.centerlines import Centerlines
from cpm_core.medial_axis.space.steps import VolumeSkeleton
from cpm_core.parameters.quotation import shown

_LOG = logging.getLogger(__name__)

Encode = Callable[[Result | Skeleton], bytes]
"""Makes the bytes of a file; ValueError when the result holds nothing that such a file could show."""

_LABELME = ".labelme.json"
_FIGURE = "a figure of the image with contours and a scale bar"
_LABELS = "insides of closed contours as a label mask"
_SIZED_LABELS = f"{_LABELS} of 16 or 32 bits, with the size of a pixel"
_WRITERS: Mapping[str, tuple[str, Encode]] = MappingProxyType(
    {
        ".svg": ("contours as a vector drawing", svg.encode),
        ".csv": ("contours as a table of vertices", contour_csv.encode),
        ".measures.csv": ("a table with one row per contour", contour_csv.encode_measures),
        ".json": ("everything: contours, their measures, bridges, and the outcome of the run", contour_json.encode),
        ".geojson": ("contours as annotations for QuPath", geojson.encode),
        ".zip": ("contours as a set of selections of ImageJ and Fiji", imagej.encode_set),
        ".roi": ("the only contour as a selection of ImageJ and Fiji", imagej.encode),
        _LABELME: ("contours as shapes for labelme", labelme.encode),
        ".coco.json": ("closed contours as COCO instances", coco.encode),
        ".tif": (_SIZED_LABELS, label_tiff.encode),
        ".tiff": (_SIZED_LABELS, label_tiff.encode),
        ".nii": (f"{_LABELS} of one slice", nifti.encode),
        ".nii.gz": ("the same, compressed", nifti.encode_packed),
        ".dxf": ("contours as polylines for CAD", dxf.encode),
        ".png": (_LABELS, labels.encode_png),
        ".figure.svg": (
            f"{_FIGURE}, whose lines and texts a drawing program can change",
            partial(figure.encoded, ".svg"),
        ),
        ".figure.png": (f"{_FIGURE}, as a picture", partial(figure.encoded, ".png")),
        ".figure.pdf": (f"{_FIGURE}, for print", partial(figure.encoded, ".pdf")),
    }
)
"""Suffix -> what is written, and the function that encodes it."""

DRAWN = frozenset((".figure.svg", ".figure.png", ".figure.pdf"))
"""Suffixes of figures, which show the image and need matplotlib."""

_MESHES: Mapping[str, tuple[str, Encode]] = MappingProxyType(
    {
        ".ply": ("the surface of a volume with its normals", ply.encode),
        ".stl": ("the triangles of the surface of a volume, for printing", stl.encode),
        ".obj": ("the surface of a volume as text", obj.encode),
        ".vtk": ("the surface of a volume as poly data", vtk.encode),
        ".points.csv": ("the particles of a run in a volume, as a table", points_csv.encode),
    }
)
"""The same for surfaces, which only volumes have."""

_SURFACES: Mapping[str, Callable[[Result | Skeleton, Convention], bytes]] = MappingProxyType(
    {".ply": ply.encode, ".stl": stl.encode, ".obj": obj.encode, ".vtk": vtk.encode}
)
"""Suffix of a file with coordinates of a patient -> the function that encodes it in LPS or RAS."""

IN_SPACE = frozenset(_SURFACES)
"""Suffixes of the files of surfaces whose coordinates are in LPS or RAS, as `export` is told."""

_OUTLINES: Mapping[str, Encode] = MappingProxyType(
    {
        ".png": partial(labels.encode_png, outlines=True),
        ".tif": partial(label_tiff.encode, outlines=True),
        ".tiff": partial(label_tiff.encode, outlines=True),
        ".nii": partial(nifti.encode, outlines=True),
        ".nii.gz": partial(nifti.encode_packed, outlines=True),
    }
)
"""Suffix of a mask -> the function that encodes it with lines in place of filled contours."""

OUTLINABLE: frozenset[str] = frozenset(_OUTLINES)
"""Suffixes of masks, which hold the insides of closed contours, or lines."""

_CLOSED_ONLY = OUTLINABLE | {".coco.json"}
"""Suffixes of files that hold no open contours."""

WRITABLE: dict[str, str] = {suffix: text for suffix, (text, _) in _WRITERS.items()}
"""Suffixes that a result can be exported to, some of two parts -> what is written."""

_LABEL_VOLUMES = dict.fromkeys((".tif", ".tiff", ".nii", ".nii.gz"), "the objects inside a surface as a label volume")

FOR_VOLUMES: dict[str, str] = {**{suffix: text for suffix, (text, _) in _MESHES.items()}, **_LABEL_VOLUMES}
"""Suffixes that the result of a volume can be exported to -> what is written."""

FOR_SKELETONS: dict[str, str] = {
    ".svg": "branches as a vector drawing, with their thickness",
    ".csv": "branches as a table of vertices, with their radii",
    ".measures.csv": "a table with one row per branch",
    ".json": "everything: branches and their radii",
    ".geojson": "branches as annotations for QuPath",
    ".zip": "branches as a set of selections of ImageJ and Fiji",
    ".labelme.json": "branches as shapes for labelme",
    ".dxf": "branches as polylines for CAD",
    ".png": "branches as lines of a label mask",
    ".tif": "branches as lines of a label mask of 16 or 32 bits, with the size of a pixel",
    ".figure.svg": "a figure of the image with branches and a scale bar",
    ".figure.png": "the same as a picture",
    ".figure.pdf": "the same for print",
}
"""Suffixes that make sense for a skeleton -> what is written."""

FOR_CENTERLINES: dict[str, str] = {".swc": "center lines in a volume as a tree of points with radii"}
"""Suffixes that center lines can be exported to -> what is written."""


def export(
    result: Result | Skeleton | Centerlines,
    *paths: str | os.PathLike[str],
    outlines: bool = False,
    image: str | os.PathLike[str] | None = None,
    space: Convention = "LPS",
    tell: Callable[[str], object] = _LOG.warning,
    refused: Callable[[Path, str], object] | None = None,
) -> None:
    """Write contours, a skeleton, or center lines in a volume, in the format that each suffix names.

    Everything is encoded before anything is written, and no incomplete file is ever left behind.

    Parameters
    ----------
    result : Result, Skeleton or Centerlines
        Outcome of a run, or of `skeleton`.
    *paths : path-like
        Files to write; see `WRITABLE`, `FOR_VOLUMES` and `FOR_CENTERLINES` for suffixes. Existing ones are replaced.
    outlines : bool
        Whether masks hold contours as lines, open ones too, in place of the insides of closed ones.
    image : path-like, optional
        File of the image, for files that refer to it (labelme); by default its name.
    space : {"LPS", "RAS"}
        Where x, y and z of surfaces and center lines point, which the files tell; see `Geometry`.
    tell : callable, optional
        Called with a sentence for each file that leaves contours out; by default a warning is logged.
    refused : callable, optional
        Called with each file that the result holds nothing for, and why in a sentence; by default that is an error.

    Raises
    ------
    ValueError
        When a suffix is not known, a file cannot be written there, or the result holds nothing it could show; with
        `refused`, nothing for any of them. Then nothing is written.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("disk"), cpm.circle((32, 32), 8))
    >>> cpm.export(result, "disk.svg", "disk.measures.csv", "disk.tif")
    >>> int(cpm.load_image("disk.tif").values.max())
    1
    """
    files, contents = list(map(Path, paths)), []
    for file in files:
        check_export(file)
    for file in files:
        try:
            contents.append((file, _content(result, file, outlines, image, space)))
        except ValueError as error:
            if refused is None or (file is files[-1] and not contents):
                raise
            refused(file, str(error))
    for file, _ in contents:
        if missing := omission(result, suffix_of(file), outlines=outlines):
            tell(f"{file}: {missing}")
    write_together(contents)


def _content(
    result: Result | Skeleton | Centerlines,
    file: Path,
    outlines: bool,
    image: str | os.PathLike[str] | None,
    space: Convention,
) -> bytes:
    """Content of a file, which may name the file of the image."""
    suffix = suffix_of(file)
    if suffix == _LABELME and image is not None and not isinstance(result, Centerlines):
        result = labelme.located(result, file, Path(image))
    return encoded(result, suffix, outlines=outlines, space=space)


def left_out(result: Result | Skeleton | Centerlines, suffix: str, *, outlines: bool = False) -> int:
    """Number of contours that a file with this suffix does not hold, because they are open; see `export`."""
    if isinstance(result, Skeleton | Centerlines) or suffix not in _CLOSED_ONLY or (outlines and suffix in OUTLINABLE):
        return 0
    return sum(not contour.closed for contour in result.contours)


def omission(result: Result | Skeleton | Centerlines, suffix: str, *, outlines: bool = False) -> str:
    """What a file with this suffix does not hold of a result, in a sentence or two; empty when it holds everything."""
    said = []
    count, all_of_them = left_out(result, suffix, outlines=outlines), len(result.contours)
    what = "a mask" if suffix in OUTLINABLE else "a COCO file"
    if count == 1:
        said.append(f"1 of {all_of_them} contours is open and not in {what}.")
    elif count:
        said.append(f"{count} of {all_of_them} contours are open and not in {what}.")
    hidden = _without_pixels(result) if suffix in OUTLINABLE and not outlines else 0
    if hidden == 1:
        said.append("1 closed contour has no pixel of its own and is not in a mask.")
    elif hidden:
        said.append(f"{hidden} closed contours have no pixel of their own and are not in a mask.")
    return " ".join(said)


def _without_pixels(result: Result | Skeleton | Centerlines) -> int:
    """Number of labels that no pixel has: of contours smaller than a pixel, or covered by others."""
    if not isinstance(result, Result) or result.surface is not None:
        return 0
    shown = np.unique(result.labels)
    return len(set(contour_labels(result.contours)) - {0, *shown.tolist()})


def encoded(
    result: Result | Skeleton | Centerlines, suffix: str, *, outlines: bool = False, space: Convention = "LPS"
) -> bytes:
    """Encode what `export` would write, for the clipboard and other places without a file.

    Parameters
    ----------
    result : Result, Skeleton or Centerlines
        Outcome of a run, or of `skeleton`.
    suffix : str
        One of `WRITABLE`, or of `FOR_VOLUMES` and `FOR_CENTERLINES` for results of a volume. Text is encoded as UTF-8.
    outlines : bool
        Whether masks hold contours as lines.
    space : {"LPS", "RAS"}
        Where x, y and z of surfaces and center lines point; see `export`.

    Returns
    -------
    bytes
        Content of the file.

    Raises
    ------
    ValueError
        When the suffix is not known, or the result holds nothing such a file could show.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("disk"), cpm.circle((32, 32), 8))
    >>> cpm.encoded(result, ".svg")[:5]
    b'<?xml'
    """
    if not isinstance(suffix, str) or suffix not in {**_WRITERS, **_MESHES, **FOR_CENTERLINES}:
        raise ValueError(f"{shown(suffix)} names no format that can be written: choose one of {_known()}.")
    if isinstance(result, VolumeSkeleton):
        result = result.lines
    if isinstance(result, Centerlines):
        if suffix not in FOR_CENTERLINES:
            raise ValueError(f'A file with the suffix "{suffix}" holds no center lines in a volume: choose .swc.')
        return swc.encode(result, result.geometry, space)
    if suffix in FOR_CENTERLINES:
        raise ValueError(f"{result.source} has no center lines in a volume, which {suffix} is for: find its skeleton.")
    if isinstance(result, Result) and result.surface is not None and suffix not in FOR_VOLUMES:
        raise ValueError(
            f'{result.source} is a volume, but a file with the suffix "{suffix}" holds what lies in a plane: '
            f"choose one of {', '.join(FOR_VOLUMES)}."
        )
    if suffix in _SURFACES:
        return _SURFACES[suffix](_named(result), space)
    encode = _OUTLINES[suffix] if outlines and suffix in _OUTLINES else {**_WRITERS, **_MESHES}[suffix][1]
    return encode(_named(result))


def _named(result: Result | Skeleton) -> Result | Skeleton:
    """The result with names that every format can hold."""
    contours = tuple(
        contour if printable(contour.name) == contour.name else replace(contour, name=printable(contour.name))
        for contour in result.contours
    )
    return replace(result, contours=contours, source=printable(result.source))


def suffix_of(path: str | os.PathLike[str]) -> str:
    """Suffix of a format that can be written, which a file's name ends in, in lower case; empty when there is none.

    Of several the longest counts, so that ``a.coco.json`` is not a plain ``.json``; a name that consists of a suffix
    only has none.
    """
    name = Path(path).name.lower()
    suffix = max((suffix for suffix in _all() if name.endswith(suffix)), key=len, default="")
    return suffix if len(suffix) < len(name) else ""


def check_export(path: str | os.PathLike[str]) -> None:
    """Check in advance whether `export` could write to a path.

    Raises
    ------
    ValueError
        When the suffix is not known, the folder does not exist or is not writable, or the path is a folder; for figures
        without matplotlib.
    """
    file = Path(path)
    if not suffix_of(file) and not file.is_dir():
        named = f"ends in {shown(file.suffix)}" if file.suffix and file.suffix not in WRITABLE else "has no suffix"
        raise ValueError(f"{file.name} {named}, which names no format that can be written: choose one of {_known()}.")
    check_needs(suffix_of(file))
    check_place(file)


def check_needs(suffix: str) -> None:
    """Raise a `ValueError` unless all is installed that writes files with this suffix."""
    if suffix in DRAWN:
        require_matplotlib()


def _known() -> str:
    """Suffixes of all formats that can be written, in words."""
    return ", ".join(_all())


def _all() -> dict[str, str]:
    """Suffixes of all formats that can be written -> what is written."""
    return {**WRITABLE, **FOR_VOLUMES, **FOR_CENTERLINES}
