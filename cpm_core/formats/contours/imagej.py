"""ImageJ: contours as selections (ROIs) of ImageJ and Fiji, one per file or all in a set."""

from __future__ import annotations

import io
import re
import struct
import zipfile
from collections.abc import Iterable, Iterator
from pathlib import PurePosixPath

import numpy as np
import roifile
from roifile import ROI_OPTIONS, ROI_SUBTYPE, ROI_TYPE, ImagejRoi

from cpm_core.contours.contour import Contour, assign_numbers
from cpm_core.formats.common.provenance import Outcome, describe_provenance, flatten_provenance
from cpm_core.formats.contours.contents import PIXEL_OFFSET, CollectedContours, contour_rgb
from cpm_core.formats.contours.curves import flatten_bezier, flatten_ellipse, rectangle_corners
from cpm_core.numerics.polyline import find_holes
from cpm_core.numerics.types import Array, JsonDict

_COUNTS_CHARACTERS = tuple(map(int, roifile.__version__.split(".")[:2])) < (2026, 11)
"""Whether this release of roifile counts the characters of names, not UTF-16 units."""

_ROI_MAGIC = b"Iout"
"""First bytes of a selection."""

_MAX_BOX_COORDINATE = 32767
"""Largest coordinate of the box of a selection [px]."""

_MAX_ROI_FILE_NAME = 60
"""Longest name of a file in the archive [characters]."""


_AREA_TYPES = (ROI_TYPE.POLYGON, ROI_TYPE.FREEHAND, ROI_TYPE.TRACED, ROI_TYPE.RECT, ROI_TYPE.OVAL)
"""Types of selections that enclose an area."""

_LINE_TYPES = (ROI_TYPE.LINE, ROI_TYPE.FREELINE, ROI_TYPE.POLYLINE, ROI_TYPE.ANGLE)
"""Types of selections that are lines."""

_ASPECT_OFFSET = 52
"""Offset of the aspect ratio of an ellipse, or the width of a rotated rectangle, in a selection [bytes]."""

_PATH_ARGUMENT_COUNTS = {0: 2, 1: 2, 2: 4, 3: 6, 4: 0}
"""Operation of a composite path (move, line, quadratic and cubic curve, close) -> count of numbers that follow."""


def encode_roi(result: Outcome) -> bytes:
    """Encode the only contour of a result as a ROI file; ValueError when there are none or several."""
    if len(result.contours) != 1:
        raise ValueError(
            f"{result.source} has {len(result.contours) or 'no'} contours, but a .roi file holds exactly one: "
            + ("export to .zip, which holds them all." if result.contours else "continue the run.")
        )
    (number,) = assign_numbers(result.contours)
    return encode_contour_roi(result.contours[0], number, format_roi_properties(result))


def encode_roi_set(result: Outcome) -> bytes:
    """Encode all contours as selections in one archive, which the ROI manager of ImageJ opens.

    The ROI manager shows a selection under the name of its file in the archive: class and name of the contour, with a
    number appended to duplicates. Its properties state the provenance. The same result always gives the same bytes.
    ValueError when there is no contour, because ImageJ reports an empty archive as damaged.
    """
    if not result.contours:
        raise ValueError(f"{result.source} has no contours, and ImageJ opens no empty set: continue the run.")
    properties, taken = format_roi_properties(result), {""}
    found = {}
    for number, contour in zip(assign_numbers(result.contours), result.contours, strict=True):
        name = plain = re.sub(r"[^\w .()+-]", "_", roi_name(contour, number))[:_MAX_ROI_FILE_NAME]
        while name.lower() in taken:  # some file systems ignore case
            name = f"{plain}-{number}" if name == plain else f"{name}-"
        taken.add(name.lower())
        found[name] = encode_contour_roi(contour, number, properties)
    return encode_roi_archive(found.items())


def roi_name(contour: Contour, number: int) -> str:
    """Return the name of a contour, or its number, preceded by its class unless the name includes it."""
    name = contour.name or f"contour {number}"
    return name if contour.category in name else f"{contour.category} {name}"


def encode_roi_archive(selections: Iterable[tuple[str, bytes]]) -> bytes:
    """Zip selections by their names, without a date, so that the same selections give the same bytes."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, content in selections:
            entry = zipfile.ZipInfo(f"{name}.roi")
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, content, zipfile.ZIP_DEFLATED)
    return stream.getvalue()


def encode_contour_roi(contour: Contour, number: int, properties: str, **place: int) -> bytes:
    """Encode a contour as a polygon if it is closed, else as a polyline or a point.

    `place` is its position in a stack: ``position``, or ``c_position``, ``z_position`` and ``t_position``.

    Coordinates have subpixel resolution. ImageJ counts those of polygons from the corner of a pixel and those of lines
    and points from its center.
    """
    areal = contour.encloses_area
    points = contour.points if areal or not contour.closed else contour.path
    xy = (points[:, ::-1] + (0.5 if areal else 0.0)).astype(np.float32)
    # the corners of the box are stored as 16-bit integers
    left, top = np.clip(np.floor(xy.min(axis=0)), -_MAX_BOX_COORDINATE, _MAX_BOX_COORDINATE).astype(int).tolist()
    right, bottom = np.clip(np.ceil(xy.max(axis=0)), -_MAX_BOX_COORDINATE, _MAX_BOX_COORDINATE).astype(int).tolist()
    name = roi_name(contour, number)
    if _COUNTS_CHARACTERS:  # the file counts UTF-16 units: a zero makes up for each character of two units
        name += "\0" * sum(ord(letter) > 0xFFFF for letter in name)
    roi = ImagejRoi(
        version=228,
        roitype=ROI_TYPE.POLYGON if areal else ROI_TYPE.POLYLINE if len(points) > 1 else ROI_TYPE.POINT,
        options=ROI_OPTIONS.SUB_PIXEL_RESOLUTION,
        left=left,
        top=top,
        right=right,
        bottom=bottom,
        n_coordinates=len(xy),
        integer_coordinates=np.clip(np.rint(xy - (left, top)), 0, _MAX_BOX_COORDINATE).astype(np.int32),
        subpixel_coordinates=xy,
        stroke_color=bytes((255, *contour_rgb(contour))),
        props=properties,
        name=name,
        **place,  # type: ignore[arg-type]
    )
    return roi.tobytes()


def format_roi_properties(result: Outcome) -> str:
    """Format the provenance of a result as properties of a selection: a key and a value per line, in ASCII."""
    return "".join(f"cpm_{name}: {value}\n" for name, value in flatten_provenance(describe_provenance(result)).items())


def read_rois(content: bytes) -> CollectedContours:
    """Read the contours of all selections, with their names, colors and pages.

    ImageJ counts coordinates of areas from the corner of a pixel and those of lines and points from its center.
    """
    found = CollectedContours()
    for name, selection in _iterate_rois(content, found):
        roi = ImagejRoi.frombytes(selection)
        found.is_own = "cpm_program" in (roi.props or "")
        title = (roi.name or "").rstrip("\0") or name
        color = "" if not roi.stroke_color or roi.stroke_color[0] == 0 else list(roi.stroke_color[1:4])
        page = max(roi.position, roi.z_position, roi.t_position, 0)
        _add_roi(found, roi, selection, {"page": page, "name": title, "color": color})
    return found


def _iterate_rois(content: bytes, found: CollectedContours) -> Iterator[tuple[str, bytes]]:
    """Yield name and bytes of each selection."""
    if content.startswith(_ROI_MAGIC):
        yield "", content
        return
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        for entry in archive.infolist():
            if entry.filename.lower().endswith(".roi"):
                yield PurePosixPath(entry.filename).stem, archive.read(entry)
            elif not entry.is_dir():
                found.omissions["file of the set that is no selection"] += 1


def _add_roi(found: CollectedContours, roi: ImagejRoi, selection: bytes, known: JsonDict) -> None:
    """Add the contours or points of a selection."""
    if roi.multi_coordinates is not None:
        curves = [curve - PIXEL_OFFSET for curve in _flatten_composite(roi.multi_coordinates.astype(float))]
        found.add_object(zip(curves, find_holes(curves), strict=True), **known)
    elif roi.roitype in _AREA_TYPES:
        found.add_contour(_outline_area(roi, selection) - PIXEL_OFFSET, True, **known)
    elif roi.roitype in _LINE_TYPES:
        found.add_contour(_swap_axes(roi.coordinates()), False, **known)
    elif roi.roitype == ROI_TYPE.POINT:
        for place in _swap_axes(roi.coordinates()):
            found.add_point(place, known["page"])
    else:
        found.omissions["empty selection"] += 1


def _swap_axes(xy: object) -> Array:
    """Convert (x, y) to (row, col), shape (K, 2)."""
    return np.asarray(xy, float)[:, ::-1]


def _outline_area(roi: ImagejRoi, selection: bytes) -> Array:
    """Outline the area of a selection, as (row, col) from the corner of the image, shape (K, 2)."""
    if roi.subtype in (ROI_SUBTYPE.ELLIPSE, ROI_SUBTYPE.ROTATED_RECT) and roi.roitype == ROI_TYPE.FREEHAND:
        (share,) = struct.unpack_from(">f", selection, _ASPECT_OFFSET)
        one, other = np.array([(roi.y1, roi.x1), (roi.y2, roi.x2)], float)
        half = 0.5 * (other - one)
        across = np.array([half[1], -half[0]])
        if roi.subtype == ROI_SUBTYPE.ELLIPSE:
            return flatten_ellipse(0.5 * (one + other), half, share * across)
        side = 0.5 * share * across / max(float(np.hypot(*across)), 1e-12)
        return np.array([one - side, one + side, other + side, other - side])
    if roi.roitype not in (ROI_TYPE.RECT, ROI_TYPE.OVAL):
        return _swap_axes(roi.coordinates())
    corners = np.array([(roi.top, roi.left), (roi.bottom, roi.right)], float)
    if roi.subpixelrect:
        corners = np.array([(roi.yd, roi.xd), (roi.yd + roi.heightd, roi.xd + roi.widthd)])
    if roi.roitype == ROI_TYPE.RECT:
        return rectangle_corners(*corners)
    down, right = np.diag(0.5 * (corners[1] - corners[0]))
    return flatten_ellipse(corners.mean(axis=0), right, down)


def _flatten_composite(numbers: Array) -> list[Array]:
    """Flatten the closed curves of a composite selection, as (row, col) from the corner of the image."""
    curves: list[list[Array]] = []
    at = 0
    while at < len(numbers):
        step = int(numbers[at])
        count = _PATH_ARGUMENT_COUNTS[step]
        corners = [corner[::-1].astype(float) for corner in np.reshape(numbers[at + 1 : at + 1 + count], (-1, 2))]
        at += 1 + count
        if step == 0:
            curves.append(corners)
        elif step == 1:
            curves[-1] += corners
        elif step in (2, 3):
            curves[-1] += list(flatten_bezier(curves[-1][-1], *corners))
    return [np.array(curve) for curve in curves if len(curve) > 2]
