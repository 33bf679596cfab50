"""ImageJ ROI: one contour as a selection of ImageJ and Fiji.

The layout is that of ImageJ's own decoder, version 228: a header of 64 bytes, the coordinates, a second header of 64
bytes, and the name, all in network order. It has been the same for a decade and takes a page, so no library is needed.
"""

from __future__ import annotations

import struct

import numpy as np

from cpm_core.contours.contour import Contour
from cpm_core.contours.result import Result
from cpm_core.formats.contours.appearance import rgb, title
from cpm_core.medial_axis.skeleton import Skeleton

WRITES = {".roi": "the only contour as a selection of ImageJ and Fiji"}

_VERSION = 228
_POLYGON, _POLYLINE, _POINT = 0, 5, 10
_SUB_PIXEL = 128
_HEADER, _SECOND_HEADER = 64, 64
_MOST_COORDINATES = 65535
_LARGEST = 32767
"""Largest coordinate of a box."""


def encode(result: Result | Skeleton) -> bytes:
    """Write the only contour of a result.

    Returns
    -------
    bytes
        A ROI file.

    Raises
    ------
    ValueError
        When there are none or several.
    """
    if len(result.contours) != 1:
        raise ValueError(
            f"{result.source} has {len(result.contours) or 'no'} contours, but a .roi file holds exactly one: "
            + ("export to .zip, which holds them all." if result.contours else "let it run on.")
        )
    return selection(result.contours[0], 1)


def selection(contour: Contour, number: int) -> bytes:
    """Write a contour as a polygon when it is closed, else as a line of segments, or a point.

    Coordinates are fractions of pixels. As ImageJ means them, those of a polygon count from the corner of a pixel and
    those of lines and points from its centre.

    Parameters
    ----------
    contour : Contour
        Contour to write, with its name and its colour.
    number : int
        Its place among the contours, from 1, for those without a name.

    Returns
    -------
    bytes
        A ROI file.
    """
    areal = contour.closed and len(contour.points) > 2
    points = contour.points if areal or not contour.closed else contour.path
    kind = _POLYGON if areal else _POLYLINE if len(points) > 1 else _POINT
    x, y = (points[:, ::-1] + (0.5 if areal else 0.0)).T.astype(">f4")
    # no corner of the box lies beyond what its two bytes hold
    left, top = (int(np.clip(np.floor(values.min()), -_LARGEST, _LARGEST)) for values in (x, y))
    right, bottom = (int(np.clip(np.ceil(values.max()), -_LARGEST, _LARGEST)) for values in (x, y))
    whole = [
        np.clip(np.rint(values - least), 0, _LARGEST).astype(">i2").tobytes() for values, least in ((x, left), (y, top))
    ]
    coordinates = b"".join([*whole, x.tobytes(), y.tobytes()])
    second = _HEADER + len(coordinates)
    count = len(points)
    header = struct.pack(
        ">4shBxhhhhH",
        *(b"Iout", _VERSION, kind, top, left, bottom, right),
        count if count <= _MOST_COORDINATES else 0,  # more of them are counted further down
    )
    header += struct.pack(">4i", 0, 0, 0, 0) if count <= _MOST_COORDINATES else struct.pack(">4i", count, 0, 0, 0)
    red, green, blue = rgb(contour)
    colour = struct.unpack(">i", bytes([255, red, green, blue]))[0]
    header += struct.pack(">hiiihhBBhii", 0, 0, colour, 0, 0, _SUB_PIXEL, 0, 0, 0, 0, second)
    name = title(contour, number).encode("utf-16-be")
    details = struct.pack(">4i", 0, 0, 0, 0)  # on no channel, slice or frame in particular
    details += struct.pack(">2i", second + _SECOND_HEADER, len(name) // 2)
    return header + coordinates + details.ljust(_SECOND_HEADER, b"\0") + name
