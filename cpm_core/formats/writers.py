"""Writers of contours, surfaces, skeletons and center lines: each format by the suffix of its files.

A new format is a module with a function that encodes a file, and an entry of `FILE_FORMATS`.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from cpm_core.contours.contour import Contour
from cpm_core.contours.measurements import assign_labels
from cpm_core.formats.common.atomic import check_target, find_suffix, write_together
from cpm_core.formats.common.content import AnyPath
from cpm_core.formats.common.printable import make_printable
from cpm_core.formats.common.provenance import Outcome
from cpm_core.formats.contours import (
    coco,
    contour_csv,
    contour_json,
    dxf,
    figure,
    geojson,
    imagej,
    labelme,
    points_csv,
    svg,
)
from cpm_core.formats.exportable import Exportable, as_result
from cpm_core.formats.masks import dicom_seg, itk_snap, labels, nifti, nrrd
from cpm_core.formats.meshes import obj, ply, stl, swc, vtk
from cpm_core.formats.meshes.coordinates import ExportMesh, build_mesh
from cpm_core.formats.meshes.simplification import AS_FOUND, Simplification, measure_change, simplify_surface
from cpm_core.image.geometry import Convention
from cpm_core.image.image import Image
from cpm_core.image.surface import Surface
from cpm_core.medial_axis.centerlines import Centerlines
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.numerics.packages import require_package
from cpm_core.numerics.types import JsonDict, Texts, copy_with, frozen
from cpm_core.parameters.formatting import format_choice, format_count, quote_value
from cpm_core.results.result import Result

_LOG = logging.getLogger(__name__)


@frozen
class Format:
    """A format of files.

    Attributes
    ----------
    suffix : str
        Suffix of its files.
    encode : callable
        Encodes a file; ValueError when the result holds nothing that such a file could show.
    contours, branches, volume, lines : str
        What is written of contours, of a skeleton, of the result of a volume, and of center lines in a volume; empty if
        nothing is.
    options : tuple of str
        Options that `encode` takes: ``outlines`` for masks, ``space`` for files in patient coordinates, ``image`` for
        the file of the image.
    package : str
        Package that writing needs beyond those of the program, or empty.
    """

    suffix: str
    encode: Callable[..., bytes]
    contours: str = ""
    branches: str = ""
    volume: str = ""
    lines: str = ""
    options: Texts = ()
    package: str = ""


_FIGURE_TEXT = "a figure of the image with {} and a scale bar, "
"""Beginning of the descriptions of figures."""

_FIGURE_TEXTS = {
    ".svg": _FIGURE_TEXT + "whose lines and texts a drawing program can change",
    ".png": _FIGURE_TEXT + "as a picture",
    ".pdf": _FIGURE_TEXT + "for print",
}
"""Suffix of a figure -> its description."""

_INSIDES_TEXT = "insides of closed contours as a label mask"
"""Description of masks of contours."""

_BRANCHES_TEXT = "branches as lines of a label mask"
"""Description of masks of skeletons."""

_SIZED_TEXT = "of 16 or 32 bits, with the size of a pixel"
"""Addition for masks in TIFF."""

_MASK_FORMAT = partial(Format, volume="the objects inside a surface as a label volume", options=("outlines",))
"""Makes the format of a mask that also holds volumes."""


def _mesh_format(suffix: str, encode: Callable[[ExportMesh], bytes], volume: str) -> Format:
    """Make the format of a surface file."""
    return Format(suffix, lambda result, space: encode(build_mesh(result, space)), volume=volume, options=("space",))


FILE_FORMATS: tuple[Format, ...] = (
    Format(
        ".svg", svg.encode_svg, "contours as a vector drawing", "branches as a vector drawing, with their thickness"
    ),
    Format(
        ".csv",
        contour_csv.encode_vertices,
        "contours as a table of vertices",
        "branches as a table of vertices, with their radii",
        volume="a table with one row per object inside the surface",
    ),
    Format(
        ".measures.csv",
        contour_csv.encode_measures,
        "a table with one row per contour",
        "a table with one row per branch",
    ),
    Format(
        ".table.csv",
        contour_csv.encode_object_table,
        "a table with one row per object: what closed contours enclose",
        volume="a table with one row per object inside the surface",
    ),
    Format(
        ".json",
        contour_json.encode_contour_json,
        "everything: contours, their measures, bridges, and the outcome of the run",
        "everything: branches and their radii",
    ),
    Format(
        ".geojson", geojson.encode_geojson, "contours as annotations for QuPath", "branches as annotations for QuPath"
    ),
    Format(
        ".zip",
        imagej.encode_roi_set,
        "contours as a set of selections of ImageJ and Fiji",
        "branches as a set of selections of ImageJ and Fiji",
    ),
    Format(".roi", imagej.encode_roi, "the only contour as a selection of ImageJ and Fiji"),
    Format(".labelme.json", labelme.encode_labelme, "contours as shapes for labelme", "branches as shapes for labelme"),
    Format(".coco.json", coco.encode_coco, "closed contours as COCO instances"),
    _MASK_FORMAT(".tif", labels.encode_label_tiff, f"{_INSIDES_TEXT} {_SIZED_TEXT}", f"{_BRANCHES_TEXT} {_SIZED_TEXT}"),
    _MASK_FORMAT(".tiff", labels.encode_label_tiff, f"{_INSIDES_TEXT} {_SIZED_TEXT}"),
    _MASK_FORMAT(".nii", nifti.encode_nifti, f"{_INSIDES_TEXT} of one slice"),
    _MASK_FORMAT(".nii.gz", nifti.encode_nifti_gz, "the same, compressed"),
    _MASK_FORMAT(
        ".nrrd",
        nrrd.encode_nrrd,
        f"{_INSIDES_TEXT} of one slice",
        volume="the objects inside a surface as segments of 3D Slicer",
    ),
    Format(
        ".seg.dcm",
        dicom_seg.encode_dicom_seg,
        volume="the objects inside a surface as segments in a DICOM series",
        options=("image",),
        package="highdicom",
    ),
    Format(".dxf", dxf.encode_dxf, "contours as polylines for CAD", "branches as polylines for CAD", package="ezdxf"),
    Format(".png", labels.encode_label_png, _INSIDES_TEXT, _BRANCHES_TEXT, options=("outlines",)),
    *(
        Format(
            f".figure{suffix}",
            partial(figure.encode_figure, suffix),
            text.format("contours"),
            text.format("branches"),
            package="matplotlib",
        )
        for suffix, text in _FIGURE_TEXTS.items()
    ),
    _mesh_format(".ply", ply.encode_ply, "the surface of a volume with its normals"),
    _mesh_format(".stl", stl.encode_stl, "the triangles of the surface of a volume, for printing"),
    _mesh_format(".obj", obj.encode_obj, "the surface of a volume as text"),
    _mesh_format(".vtk", vtk.encode_vtk, "the surface of a volume as poly data"),
    Format(".points.csv", points_csv.encode_points, volume="the particles of a run in a volume, as a table"),
    Format(".swc", swc.encode_swc, lines="center lines in a volume as a tree of points with radii", options=("space",)),
)

_FORMAT_SUFFIXES = tuple(one.suffix for one in FILE_FORMATS)
"""Suffixes of all formats."""

CONTOURS_WRITABLE: dict[str, str] = {one.suffix: one.contours for one in FILE_FORMATS if one.contours}
"""Suffixes that contours can be exported to, some of two parts -> what is written."""

FORMATS_BY_NAME: dict[str, str] = {
    "csv": ".table.csv",
    "masks": ".tif",
    "labelme": ".labelme.json",
    "coco": ".coco.json",
    "imagej": ".zip",
}
"""Names of formats for objects -> their suffixes; every other format is named by its suffix, with or without dot."""

SKELETONS_WRITABLE: dict[str, str] = {one.suffix: one.branches for one in FILE_FORMATS if one.branches}
"""Suffixes that a skeleton can be exported to -> what is written."""

VOLUMES_WRITABLE: dict[str, str] = {one.suffix: one.volume for one in FILE_FORMATS if one.volume}
"""Suffixes that the result of a volume can be exported to -> what is written."""

CENTERLINES_WRITABLE: dict[str, str] = {one.suffix: one.lines for one in FILE_FORMATS if one.lines}
"""Suffixes that center lines can be exported to -> what is written."""

MASK_SUFFIXES = frozenset(one.suffix for one in FILE_FORMATS if "outlines" in one.options)
"""Suffixes of masks, which hold the insides of closed contours, or contours as lines."""

SURFACE_SUFFIXES = frozenset(one.suffix for one in FILE_FORMATS if "space" in one.options and one.volume)
"""Suffixes of surfaces whose coordinates are in LPS or RAS; see `export`."""

FIGURE_SUFFIXES = frozenset(suffix for suffix in CONTOURS_WRITABLE if suffix.startswith(".figure"))
"""Suffixes of figures, which show the image."""

_FILE_ENDINGS = {".table.csv": ".csv", ".measures.csv": ".csv", ".csv": ".vertices.csv", ".nrrd": ".seg.nrrd"}
"""Endings of files whose suffix only tells formats of a writer apart, and the one 3D Slicer expects."""

_DESCRIBED_SUFFIXES = frozenset({".nii", ".nii.gz"})
"""Suffixes of masks without names, which a description of ITK-SNAP next to them holds."""

_CLOSED_ONLY_SUFFIXES = MASK_SUFFIXES | {".coco.json"}
"""Suffixes of files that hold no open contours, and the size of the image."""


def export(
    result: Exportable,
    *paths: AnyPath,
    outlines: bool = False,
    image: AnyPath | Image | None = None,
    space: Convention = "LPS",
    surface_smoothing: int = 0,
    surface_triangles: float = 1.0,
    warn: Callable[[str], object] = _LOG.warning,
    refused: Callable[[Path, str], object] | None = None,
) -> None:
    """Write contours, objects, labels, a surface, a skeleton or center lines, in the format that each suffix names.

    Everything is encoded before anything is written, and no incomplete file is ever left behind. Names or colors of
    objects in a NIfTI label mask are written next to it, as a label description of ITK-SNAP (.txt).

    Parameters
    ----------
    result : Result, Skeleton, Centerlines, Selection, Surface, sequence or ndarray
        Outcome of a run, or of `skeleton`; one or several selected objects, or several contours; a surface; or labels,
        whole numbers of shape (H, W) or (P, H, W), which masks hold as they are.
    *paths : path-like
        Files to write; see `CONTOURS_WRITABLE`, `VOLUMES_WRITABLE` and `CENTERLINES_WRITABLE` for suffixes. Existing
        ones are replaced.
    outlines : bool
        Whether masks hold contours as lines, open ones too, instead of the insides of closed ones.
    image : Image or path-like, optional
        The image that contours, a surface or labels lie in, for its size and place; or the file of the image, or the
        folder of the series, for files that refer to it (labelme, DICOM SEG).
    space : {"LPS", "RAS"}
        Directions of x, y and z of surfaces and center lines, which the files state; see `Geometry`.
    surface_smoothing : int
        Rounds of smoothing of a surface in files of triangles.
    surface_triangles : float
        Share of its triangles that these files keep; below 1, the package ``fast-simplification`` is needed.
    warn : callable, optional
        Called with a sentence for each file that omits something, or whose surface was made simpler, with how far this
        moved it; by default a warning is logged.
    refused : callable, optional
        Called with each file for which the result holds nothing, and the reason in a sentence; by default that is an
        error.

    Raises
    ------
    ValueError
        When a suffix is unknown, a file cannot be written, or the result holds nothing for it (with `refused`, for any
        of the files). Then nothing is written.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("disk"), cpm.circle((32, 32), 8))
    >>> cpm.export(result, "disk.svg", "disk.measures.csv", "disk.tif")
    >>> int(cpm.load_image("disk.tif").values.max())
    1
    >>> cpm.export(cpm.partition(result).select([(32, 32)]), "disk.geojson")
    >>> cpm.export(result.labels + 4 * (result.labels > 0), "five.nii.gz", image=result.image)
    """
    files = list(map(Path, paths))
    for file in files:
        check_export(file)
    named = [(file, find_format_suffix(file)) for file in files]
    simpler = Simplification(surface_smoothing, surface_triangles)
    options: JsonDict = {
        "outlines": outlines, "image": image, "space": space, "simpler": simpler, "refused": refused
    }  # fmt: skip
    write_together(encode_files(result, named, warn=lambda file, sentence: warn(f"{file}: {sentence}"), **options))


def encode_files(
    result: Exportable,
    files: Sequence[tuple[Path, str]],
    *,
    warn: Callable[[Path, str], object],
    outlines: bool = False,
    image: AnyPath | Image | None = None,
    space: Convention = "LPS",
    simpler: Simplification = AS_FOUND,
    refused: Callable[[Path, str], object] | None = None,
) -> list[tuple[Path, bytes]]:
    """Encode files, each given with the suffix of its format, as `export` does; those that are refused are left out."""
    contents: list[tuple[Path, bytes]] = []
    found, path = as_result(result, image if isinstance(image, Image) else None), _path_of(image)
    reduced, moved = found, ""
    if simpler and isinstance(found, Result) and any(suffix in SURFACE_SUFFIXES for _, suffix in files):
        reduced, moved = simplify_result_surface(found, simpler)
    for file, suffix in files:
        written = reduced if suffix in SURFACE_SUFFIXES else found
        if suffix == ".labelme.json" and path is not None and not isinstance(found, Centerlines):
            written = labelme.set_relative_source(found, file, path)
        try:
            _check_extent(result, image, suffix)
            content = to_bytes(written, suffix, outlines=outlines, space=space, image=path)
            contents += [(file, content), *encode_descriptions(found, file, outlines=outlines)]
        except ValueError as error:
            if refused is None or (file is files[-1][0] and not contents):
                raise
            refused(file, str(error))
            continue
        told = describe_omissions(found, suffix, outlines=outlines), moved * (suffix in SURFACE_SUFFIXES)
        if any(told):
            warn(file, " ".join(filter(None, told)))
    return contents


def simplify_result_surface(result: Result, wanted: Simplification) -> tuple[Result, str]:
    """Make the surface of a result simpler; also return how far this moved it, in a sentence."""
    if result.surface is None:
        return result, ""
    surface = simplify_surface(result.surface, wanted)
    change, unit = measure_change(result.surface, surface), surface.unit or "voxels"
    few, many = (f"{len(each.faces):,}" for each in (surface, result.surface))
    return replace(result, surface=surface), (
        f"The surface was made simpler: {few} of {many} triangles, moved by {change.mean:.3g} {unit} on average and by "
        f"{change.largest:.3g} {unit} at most."
    )


def _path_of(image: AnyPath | Image | None) -> Path | None:
    """Return the path of an image that is given by its file."""
    return None if image is None or isinstance(image, Image) else Path(image)


def _check_extent(given: Exportable, image: AnyPath | Image | None, suffix: str) -> None:
    """Raise ValueError for contours or a surface alone in a file that is as large as their image."""
    first = given[0] if isinstance(given, Sequence) else given
    if suffix in _CLOSED_ONLY_SUFFIXES and isinstance(first, Contour | Surface) and not isinstance(image, Image):
        raise ValueError(f"A {suffix} file is as large as an image, and none is known: name one by image=, an Image.")


def encode_descriptions(
    result: Outcome | Centerlines, path: Path, *, outlines: bool = False
) -> list[tuple[Path, bytes]]:
    """Encode the file of names that belongs next to a label mask; empty for other files and without names.

    ValueError when there is another file of that name.
    """
    suffix = find_format_suffix(path)
    if suffix not in _DESCRIBED_SUFFIXES or isinstance(result, Centerlines):
        return []
    named = labels.find_named_labels(result, outlines=outlines)
    beside = path.with_name(path.name[: -len(suffix)] + itk_snap.DESCRIPTION_SUFFIX)
    if named and beside.exists() and not itk_snap.read_label_description(beside):
        raise ValueError(
            f"The names of the labels of {path.name} go into {beside.name}, but this is another file: "
            "choose another name for the labels."
        )
    return [(beside, itk_snap.encode_label_description(named))] if named else []


def count_left_out(result: Outcome | Centerlines, suffix: str, *, outlines: bool = False) -> int:
    """Count the contours that a file with this suffix omits because they are open; see `export`."""
    if (
        isinstance(result, Skeleton | Centerlines)
        or suffix not in _CLOSED_ONLY_SUFFIXES
        or (outlines and suffix in MASK_SUFFIXES)
    ):
        return 0
    return sum(not contour.closed for contour in result.contours)


def describe_omissions(result: Outcome | Centerlines, suffix: str, *, outlines: bool = False) -> str:
    """Describe what a file with this suffix does not keep of a result, in some sentences; empty if nothing."""
    sentences = []
    if suffix in _DESCRIBED_SUFFIXES and not isinstance(result, Centerlines):
        sentences.append(nifti.describe_displacement(result))
    count = count_left_out(result, suffix, outlines=outlines)
    what = "a mask" if suffix in MASK_SUFFIXES else "a COCO file"
    if count:
        sentences.append(
            f"{count} of {len(result.contours)} contours {'is' if count == 1 else 'are'} open and not in {what}."
        )
    if suffix in SURFACE_SUFFIXES and isinstance(result, Result) and result.surface and result.surface.left_out:
        parts = format_count(result.surface.left_out, "part was", "parts were")
        sentences.append(f"{parts} left out, for too few particles.")
    hidden = 0
    if suffix in MASK_SUFFIXES and not outlines and isinstance(result, Result) and result.surface is None:
        hidden = len(set(assign_labels(result.contours)) - {0, *np.unique(result.labels).tolist()})
    if hidden:
        one, several = "has no pixel of its own and is", "contours have no pixel of their own and are"
        sentences.append(f"{format_count(hidden, f'closed contour {one}', f'closed {several}')} not in a mask.")
    return " ".join(filter(None, sentences))


def to_bytes(
    result: Exportable,
    suffix: str,
    *,
    outlines: bool = False,
    space: Convention = "LPS",
    image: AnyPath | Image | None = None,
) -> bytes:
    """Encode what `export` would write, for the clipboard and other places without a file.

    Parameters
    ----------
    result : Result, Skeleton, Centerlines, Selection, Surface, sequence or ndarray
        What `export` takes.
    suffix : str
        One of `CONTOURS_WRITABLE`, or of `VOLUMES_WRITABLE` and `CENTERLINES_WRITABLE` for results of a volume. Text is
        encoded as UTF-8.
    outlines : bool
        Whether masks hold contours as lines.
    space : {"LPS", "RAS"}
        Directions of x, y and z of surfaces and center lines; see `export`.
    image : Image or path-like, optional
        The image, or its file; see `export`.

    Returns
    -------
    bytes
        Content of the file.

    Raises
    ------
    ValueError
        When the suffix is unknown, or the result holds nothing such a file could show.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("disk"), cpm.circle((32, 32), 8))
    >>> cpm.to_bytes(result, ".svg")[:5]
    b'<?xml'
    """
    file_format = find_format(suffix)
    found = as_result(result, image if isinstance(image, Image) else None)
    _check_extent(result, image, suffix)
    if isinstance(found, Skeleton) and found.lines is not None:
        found = found.lines
    if isinstance(found, Centerlines):
        if not file_format.lines:
            raise ValueError(f'A file with the suffix "{suffix}" cannot contain center lines in a volume: choose .swc.')
    elif file_format.lines:
        raise ValueError(f"{found.source} has no center lines in a volume, which {suffix} is for: find its skeleton.")
    elif found.surface is not None and not file_format.volume:
        raise ValueError(
            f'{found.source} is a volume, but a file with the suffix "{suffix}" contains what lies in a plane: '
            f"choose one of {', '.join(VOLUMES_WRITABLE)}."
        )
    if not isinstance(found, Centerlines):
        contours = tuple(
            replace(contour, name=make_printable(contour.name), category=make_printable(contour.category))
            for contour in found.contours
        )
        found = copy_with(found, contours=contours, source=make_printable(found.source))
    options: JsonDict = {"outlines": outlines, "space": space, "image": _path_of(image)}
    return file_format.encode(found, **{name: options[name] for name in file_format.options})


def find_format(suffix: str) -> Format:
    """Return the format of a suffix; ValueError where there is none, or its package is not installed."""
    found = next((one for one in FILE_FORMATS if isinstance(suffix, str) and one.suffix == suffix), None)
    if found is None:
        raise ValueError(
            f"{quote_value(suffix)} names no format that can be written: "
            f"choose {format_choice(suffix, _FORMAT_SUFFIXES)}"
        )
    if found.package:
        require_package(found.package, f"A {suffix} file")
    return found


def find_format_suffix(path: AnyPath) -> str:
    """Return the suffix of a writable format that a file name ends in, in lower case; empty if there is none.

    The longest one counts, so that ``a.coco.json`` is not a plain ``.json``; a name that is nothing but a suffix has
    none.
    """
    return find_suffix(path, _FORMAT_SUFFIXES)


def find_named_suffix(name: str) -> str:
    """Return the suffix of a format that is named by one of `FORMATS_BY_NAME`, or by its suffix."""
    return FORMATS_BY_NAME.get(name.lower(), f".{name.lower().lstrip('.')}")


def choose_file_name(base: str, kind: str, suffix: str) -> str:
    """Return the name of a file that a program names: that of the image, the kind of its content, and a common ending.

    A file of labelme has the name of the image, as labelme opens both together.
    """
    return f"{base}.json" if suffix == ".labelme.json" else f"{base}_{kind}{_FILE_ENDINGS.get(suffix, suffix)}"


def check_export(path: AnyPath) -> None:
    """Check in advance whether `export` could write to a path.

    Raises
    ------
    ValueError
        When the suffix is not known, its package is not installed, the folder does not exist or is not writable, or the
        path is a folder.
    """
    check_target(path, _FORMAT_SUFFIXES)
    find_format(find_format_suffix(path))
