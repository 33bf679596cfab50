"""Contour files: contours of any known format, recognized by suffix and content."""

from __future__ import annotations

import json
import logging
from collections.abc import Callable
from dataclasses import field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpm_core.contours.contour import Contour
from cpm_core.contours.ground_truth import label_gray_levels
from cpm_core.formats.common.content import AnySource, explain_decoding_errors, find_local_file, read_content
from cpm_core.formats.contours import coco, contour_csv, contour_json, dxf, geojson, imagej, labelme, mask, svg
from cpm_core.formats.contours.contents import CollectedContours, PlaneInfo
from cpm_core.formats.images.readers import load_image
from cpm_core.image.image import Image
from cpm_core.numerics.types import NO_POINTS, Array, Texts, record

_LOG = logging.getLogger(__name__)

CONTOURS_READABLE: dict[str, str] = {
    ".csv": "table of vertices, of CPM",
    ".geojson": "GeoJSON, as of QuPath",
    ".json": "JSON of CPM, of labelme or COCO, or GeoJSON",
    ".zip": "set of selections of ImageJ and Fiji",
    ".roi": "selection of ImageJ and Fiji",
    ".svg": "drawing with paths",
    ".dxf": "drawing of CAD, in ASCII",
}
"""Suffixes of files that contours can be read from -> what they are; images are read as label masks."""

UNKNOWN_PLANE = PlaneInfo()
"""Plane without an image: nothing is known of it."""


@record
class ContourFile:
    """Contours read from a file.

    Attributes
    ----------
    contours : tuple of Contour
        The contours, in px.
    shape : tuple of int or None
        Shape of the image that they belong to, if the file states it.
    points : ndarray of float64, shape (N, 2)
        Single points (row, col) [px].
    notes : tuple of str
        Omissions and assumptions, one sentence each.
    """

    contours: tuple[Contour, ...]
    shape: tuple[int, int] | None = None
    points: Array = field(default_factory=lambda: NO_POINTS)
    notes: Texts = ()


def load_contours(
    path: AnySource,
    image: Image | None = None,
    *,
    page: int | None = None,
    warn: Callable[[str], object] = _LOG.warning,
) -> tuple[Contour, ...]:
    """Read contours from a file of any known format.

    Parameters
    ----------
    path : path-like or file-like
        A file with one of the suffixes `CONTOURS_READABLE`, written by `export` or by another program, or a label mask,
        whose objects are outlined. The kind of JSON is recognized by its content.
    image : Image, optional
        The image that they belong to. CAD drawings count rows from its lower side, in its unit; of the images of a
        COCO file its name selects one.
    page : int, optional
        Read only the contours on this page of a stack, from 1.
    warn : callable, optional
        Called with a sentence for each omission; by default a warning is logged.

    Returns
    -------
    tuple of Contour
        Contours with the names, colors, strengths and junctions that the file gives.

    Raises
    ------
    ValueError
        When the file cannot be read or holds no contour; one sentence with its name and what to do.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> import cpm_core as cpm
    >>> text = '<svg viewBox="0 0 64 64"><rect x="8" y="8" width="9" height="4"/></svg>'
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder, "box.svg")
    ...     _ = path.write_text(text)
    ...     (box,) = cpm.load_contours(path)
    >>> box.closed, box.area
    (True, 36.0)
    """
    file = find_local_file(path)
    found = read_contours(file, describe_plane(image), page=page)
    for note in found.notes:
        warn(f"{file.name}: {note}")
    if not found.contours:
        raise _no_contours_error(file.name)
    return found.contours


def describe_plane(image: Image | None) -> PlaneInfo:
    """Return what readers need to know of an image; of a volume the shape and pixel size of its slices."""
    if image is None:
        return UNKNOWN_PLANE
    (rows, cols), (height, width) = image.shape[-2:], image.spacing[-2:]
    return PlaneInfo((rows, cols), (height, width), image.unit, image.source)


def read_contours(path: AnySource, plane: PlaneInfo = UNKNOWN_PLANE, *, page: int | None = None) -> ContourFile:
    """Read contours and single points, with the shape of the image where the file gives it; see `load_contours`.

    A file that holds only single points is no error.
    """
    file = find_local_file(path)
    if file.suffix.lower() not in CONTOURS_READABLE:
        return _read_mask_outlines(file)
    return decode_contours(read_content(file), file.name, plane, page=page)


def decode_contours(
    content: bytes, name: str, plane: PlaneInfo = UNKNOWN_PLANE, *, page: int | None = None
) -> ContourFile:
    """Decode contours from the content of a file or the clipboard; without a known suffix the content decides."""
    known = f"{', '.join(CONTOURS_READABLE)}, or a label mask"
    advice = f"is damaged or contains no contours of a known kind: choose contours as {known}."
    with explain_decoding_errors(name, advice):
        found = _parse_contours(content, name, plane)
    return _build_contour_file(found, name, page)


def _parse_contours(content: bytes, name: str, plane: PlaneInfo) -> CollectedContours:
    """Parse contours with the reader that suffix and content select."""
    suffix = Path(name).suffix.lower()
    if suffix in (".zip", ".roi") or content.startswith((b"Iout", b"PK")):
        return imagej.read_rois(content)
    if suffix == ".dxf":
        return dxf.read_dxf(content, plane)
    text = content.decode("utf-8-sig")
    begin = text.lstrip()[:1]
    if suffix == ".svg" or (suffix not in CONTOURS_READABLE and begin == "<"):
        return svg.read_svg(text, plane)
    if suffix == ".csv" or (suffix not in CONTOURS_READABLE and begin not in ("{", "[")):
        return contour_csv.read_contour_csv(text, name)
    plain = json.loads(text)
    if contour_json.is_cpm_json(plain):
        return contour_json.read_contour_json(plain)
    if "shapes" in plain:
        return labelme.read_labelme(plain)
    return coco.read_coco(plain, plane) if "annotations" in plain else geojson.read_geojson(plain)


def _build_contour_file(found: CollectedContours, name: str, page: int | None) -> ContourFile:
    """Keep the contours of one page; ValueError when there are none, or vertices are not finite."""
    pages = {number for number in (*found.pages, *(place[2] for place in found.points)) if number}
    notes = list(found.notes)
    kept = [one for one, number in zip(found.contours, found.pages, strict=True) if page is None or number in (0, page)]
    places = [(row, col) for row, col, number in found.points if page is None or number in (0, page)]
    if page is None and len(pages) > 1:
        notes.append(f"The contours lie on {len(pages)} pages, and those of all were taken.")
    for what, count in sorted(found.omissions.items()):
        notes.append(f"Left out: {what} ({count}).")
    drawn = np.array(places, float).reshape(-1, 2)
    if not all(np.isfinite(points).all() for points in (drawn, *(one.points for one in kept))):
        raise ValueError(f"{name} holds vertices that are not finite numbers: write it again.")
    if page is not None and pages and page not in pages:
        raise ValueError(f"{name} has contours on {len(pages)} pages, none on page {page}: name one of them.")
    if not kept and not places:
        raise _no_contours_error(name)
    return ContourFile(tuple(kept), found.shape, drawn, tuple(notes))


def _no_contours_error(name: str) -> ValueError:
    """Return the error for a file without contours."""
    return ValueError(f"{name} contains no contours: choose a file with at least one line or polygon.")


def read_mask(file: Path) -> tuple[NDArray[Any], Texts]:
    """Read the gray levels of a mask, or the indices of their colors, shape (H, W), and list what was assumed."""
    indices = mask.read_color_indices(file)
    if indices is not None:
        return indices, ()
    image = load_image(file)
    return image.values, image.notes


def _read_mask_outlines(file: Path) -> ContourFile:
    """Read the outlines of the objects in a label mask."""
    values, notes = read_mask(file)
    labels = values if values.dtype.kind == "i" else label_gray_levels(values, file.name)  # indices are labels
    found = CollectedContours(shape=(labels.shape[0], labels.shape[1]), notes=list(notes))
    for _, curves in mask.find_label_outlines(labels):
        found.add_object(curves)
    return _build_contour_file(found, file.name, None)
