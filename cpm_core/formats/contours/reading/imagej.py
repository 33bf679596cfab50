"""ImageJ: selections (ROIs), one in a file of its own or all of a set, as contours."""

from __future__ import annotations

import io
import re
import struct
import zipfile
from collections.abc import Iterator
from pathlib import PurePosixPath
from typing import Any

import numpy as np
from roifile import ROI_SUBTYPE, ROI_TYPE, ImagejRoi

from cpm_core.formats.contours.appearance import DEFAULT
from cpm_core.formats.contours.json_text import PIXEL
from cpm_core.formats.contours.reading.contents import Contents
from cpm_core.formats.contours.reading.curves import bezier, ellipse, nested, rectangle
from cpm_core.formats.images.decoded import UnreadableError
from cpm_core.numerics.types import Array

MAGIC = b"Iout"
_SET = b"PK"
_LARGEST = 2**28
"""Most bytes of all selections of a set."""

_AREAL = (ROI_TYPE.POLYGON, ROI_TYPE.FREEHAND, ROI_TYPE.TRACED, ROI_TYPE.RECT, ROI_TYPE.OVAL)
_LINES = (ROI_TYPE.LINE, ROI_TYPE.FREELINE, ROI_TYPE.POLYLINE, ROI_TYPE.ANGLE)
_SHARE = 52
"""Where a selection tells how the axes of an ellipse are related, or how wide a turned rectangle is."""

_PARAMETERS = {0: 2, 1: 2, 2: 4, 3: 6, 4: 0}
"""Step of a composite path -> numbers that follow it: begin, line, curves of degree two and three, close."""


def is_imagej(head: bytes) -> bool:
    """Whether a file is of this format, by its first bytes."""
    return head.startswith((MAGIC, _SET))


def read(content: bytes) -> Contents:
    """Contours of all selections with their names, colors and pages.

    ImageJ counts coordinates of areas from the corner of a pixel and those of lines and points from its center.
    """
    found = Contents()
    for name, selection in _selections(content, found):
        roi = ImagejRoi.frombytes(selection)
        own = "cpm_program" in (roi.props or "")
        title = (roi.name or "").rstrip("\0") or name
        color = "" if not roi.stroke_color or roi.stroke_color[0] == 0 else list(roi.stroke_color[1:4])
        known: dict[str, Any] = {"name": title, "color": color}
        if own:
            known["name"] = "" if re.fullmatch(r"(contour|track) \d+", title) else title
            known["color"] = "" if bytes(roi.stroke_color[1:4]).hex() == DEFAULT[1:] else color
        page = max(roi.position, roi.z_position, roi.t_position, 0)
        _add(found, roi, selection, page, known)
    return found


def _selections(content: bytes, found: Contents) -> Iterator[tuple[str, bytes]]:
    """Name and bytes of each selection."""
    if content.startswith(MAGIC):
        yield "", content
        return
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        whole = sum(entry.file_size for entry in archive.infolist())
        if whole > _LARGEST:
            raise UnreadableError(f"The set has {whole >> 20} MB unpacked, more than the {_LARGEST >> 20} MB allowed.")
        for entry in archive.infolist():
            if entry.filename.lower().endswith(".roi"):
                yield PurePosixPath(entry.filename).stem, archive.read(entry)
            elif not entry.is_dir():
                found.left_out["file of the set that is no selection"] += 1


def _add(found: Contents, roi: ImagejRoi, selection: bytes, page: int, known: dict[str, Any]) -> None:
    if roi.multi_coordinates is not None:
        curves = [curve - PIXEL for curve in _composite(roi.multi_coordinates.astype(np.float64))]
        found.add_object(nested(curves), page=page, **known)
    elif roi.roitype in _AREAL:
        found.add(_area(roi, selection) - PIXEL, True, page=page, **known)
    elif roi.roitype in _LINES:
        found.add(_rows(roi.coordinates()), False, page=page, **known)
    elif roi.roitype == ROI_TYPE.POINT:
        for place in _rows(roi.coordinates()):
            found.add_place(place, page)
    else:
        found.left_out["empty selection"] += 1


def _rows(xy: object) -> Array:
    return np.asarray(np.asarray(xy, dtype=np.float64)[:, ::-1])


def _area(roi: ImagejRoi, selection: bytes) -> Array:
    """The line around an area, (row, col) from the corner of the image."""
    if roi.subtype in (ROI_SUBTYPE.ELLIPSE, ROI_SUBTYPE.ROTATED_RECT) and roi.roitype == ROI_TYPE.FREEHAND:
        (share,) = struct.unpack_from(">f", selection, _SHARE)
        one, other = np.array([roi.y1, roi.x1], dtype=float), np.array([roi.y2, roi.x2], dtype=float)
        half = 0.5 * (other - one)
        across = np.array([half[1], -half[0]])
        if roi.subtype == ROI_SUBTYPE.ELLIPSE:
            return ellipse(0.5 * (one + other), half, share * across)
        side = 0.5 * share * across / max(float(np.hypot(*across)), 1e-12)
        return np.array([one - side, one + side, other + side, other - side])
    if roi.roitype in (ROI_TYPE.RECT, ROI_TYPE.OVAL):
        top, left, bottom, right = float(roi.top), float(roi.left), float(roi.bottom), float(roi.right)
        if roi.subpixelrect:
            top, left, bottom, right = roi.yd, roi.xd, roi.yd + roi.heightd, roi.xd + roi.widthd
        if roi.roitype == ROI_TYPE.RECT:
            return rectangle((top, left), (bottom, right))
        center = np.array([0.5 * (top + bottom), 0.5 * (left + right)])
        return ellipse(center, (0.0, 0.5 * (right - left)), (0.5 * (bottom - top), 0.0))
    return _rows(roi.coordinates())


def _composite(numbers: Array) -> list[Array]:
    """The closed curves of a composite selection, (row, col) from the corner of the image."""
    curves: list[list[Array]] = []
    at = 0
    while at < len(numbers):
        step = int(numbers[at])
        count = _PARAMETERS[step]
        corners = [corner[::-1].astype(float) for corner in np.reshape(numbers[at + 1 : at + 1 + count], (-1, 2))]
        at += 1 + count
        if step == 0:
            curves.append(corners)
        elif step == 1:
            curves[-1] += corners
        elif step in (2, 3):
            curves[-1] += list(bezier(curves[-1][-1], *corners))
    return [np.array(curve) for curve in curves if len(curve) > 2]
