"""ImageJ: contours as selections (ROIs) of ImageJ and Fiji, one in a file of its own or all in a set."""

from __future__ import annotations

import io
import re
import zipfile

import numpy as np
from roifile import ROI_OPTIONS, ROI_TYPE, ImagejRoi

from cpm_core.contours.contour import Contour, numbers_of
from cpm_core.contours.result import Result
from cpm_core.formats.common.provenance import ascii_entries_of, facts_of
from cpm_core.formats.contours.appearance import rgb, title
from cpm_core.medial_axis.skeleton import Skeleton

_LARGEST = 32767
"""Largest coordinate of a box."""

_LONGEST = 60
"""Longest name of a file in the archive [characters]."""


def encode(result: Result | Skeleton) -> bytes:
    """Write the only contour of a result as a ROI file; ValueError when there are none or several."""
    if len(result.contours) != 1:
        raise ValueError(
            f"{result.source} has {len(result.contours) or 'no'} contours, but a .roi file holds exactly one: "
            + ("export to .zip, which holds them all." if result.contours else "let it run on.")
        )
    (number,) = numbers_of(result.contours)
    return selection(result.contours[0], number, properties_of(result))


def encode_set(result: Result | Skeleton) -> bytes:
    """Write each contour as a selection into one archive, which the ROI manager of ImageJ opens.

    The ROI manager shows a selection under the name of its file in the archive: the name of the contour, with a number
    appended where several have the same. Each tells in its properties how it was found. The same result always gives
    the same bytes. ValueError when there is no contour, because ImageJ reports an empty archive as damaged.
    """
    if not result.contours:
        raise ValueError(f"{result.source} has no contours, and ImageJ opens no empty set: let it run on.")
    stream, properties = io.BytesIO(), properties_of(result)
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        each = zip(numbers_of(result.contours), result.contours, _names(result), strict=True)
        for number, contour, name in each:
            add(archive, name, selection(contour, number, properties))
    return stream.getvalue()


def add(archive: zipfile.ZipFile, name: str, content: bytes) -> None:
    """Add a selection to a set, without a date, because the result has none."""
    entry = zipfile.ZipInfo(f"{name}.roi")
    entry.compress_type = zipfile.ZIP_DEFLATED
    entry.external_attr = 0o644 << 16
    archive.writestr(entry, content)


def selection(contour: Contour, number: int, properties: str, **place: int) -> bytes:
    """Write a contour as a polygon when it is closed, else as a polyline, or a point.

    `place` is where it lies in a stack: `position`, or `c_position`, `z_position` and `t_position`.

    Coordinates have subpixel resolution. ImageJ counts those of a polygon from the corner of a pixel and those of lines
    and points from its center.
    """
    areal = contour.closed and len(contour.points) > 2
    points = contour.points if areal or not contour.closed else contour.path
    xy = (points[:, ::-1] + (0.5 if areal else 0.0)).astype(np.float32)
    # the corners of the box are stored as 16-bit integers
    left, top = np.clip(np.floor(xy.min(axis=0)), -_LARGEST, _LARGEST).astype(int).tolist()
    right, bottom = np.clip(np.ceil(xy.max(axis=0)), -_LARGEST, _LARGEST).astype(int).tolist()
    name = title(contour, number)
    roi = ImagejRoi(
        version=228,
        roitype=ROI_TYPE.POLYGON if areal else ROI_TYPE.POLYLINE if len(points) > 1 else ROI_TYPE.POINT,
        options=ROI_OPTIONS.SUB_PIXEL_RESOLUTION,
        left=left,
        top=top,
        right=right,
        bottom=bottom,
        n_coordinates=len(xy),
        integer_coordinates=np.clip(np.rint(xy - (left, top)), 0, _LARGEST).astype(np.int32),
        subpixel_coordinates=xy,
        stroke_color=bytes((255, *rgb(contour))),
        props=properties,
        name=name,
        **place,  # type: ignore[arg-type]
    )
    wide = sum(ord(letter) > 0xFFFF for letter in name)
    if wide and ImagejRoi.frombytes(roi.tobytes()).name != name:
        # early releases of roifile count characters, the file UTF-16 units: a zero makes up for each one of two units
        roi.name = name + "\0" * wide
    return roi.tobytes()


def properties_of(result: Result | Skeleton) -> str:
    """How contours were found, as properties of a selection: a key and a value in each line, in ASCII."""
    return "".join(f"cpm_{name}: {told}\n" for name, told in ascii_entries_of(facts_of(result)).items())


def _names(result: Result | Skeleton) -> list[str]:
    """Name of each contour in characters that file names may have, none twice."""
    found: dict[str, str] = {}  # keys in lower case, because some file systems ignore case
    for number, contour in zip(numbers_of(result.contours), result.contours, strict=True):
        plain = re.sub(r"[^\w .()+-]", "_", title(contour, number))[:_LONGEST]
        name = plain if plain.lower() not in found else f"{plain}-{number}"
        while name.lower() in found:
            name += "-"
        found[name.lower()] = name
    return list(found.values())
