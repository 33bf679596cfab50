"""Entities of DXF as lines of vertices (x, y) in the unit of the drawing."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from cpm_core.formats.contours.reading.curves import bulged, ellipse, spline
from cpm_core.formats.contours.reading.dxf.groups import Entry
from cpm_core.numerics.types import Array

Line = tuple[Array, bool]
"""Vertices (x, y), and whether the line is closed; of a point a single vertex."""

_CLOSED = 1
_MESH = 16 | 64
"""Flags of a polyline that is a surface."""

_NO_VERTEX = 16
"""Flag of a vertex that only controls a spline, of which the polyline has the vertices as well."""


def whole(entries: Sequence[Entry]) -> Iterator[tuple[Entry, list[Entry]]]:
    """Each entity, with the vertices that follow a polyline."""
    at = 0
    while at < len(entries):
        entry, vertices = entries[at], list[Entry]()
        at += 1
        while entry.kind in ("POLYLINE", "INSERT") and at < len(entries) and entries[at].kind in ("VERTEX", "ATTRIB"):
            vertices.append(entries[at])
            at += 1
        if entry.kind != "SEQEND":
            yield entry, vertices


def line_of(entry: Entry, vertices: Sequence[Entry], scale: float) -> Line | None:
    """The line of an entity with all lengths multiplied by `scale`; None for one that is none."""
    if entry.kind == "POLYLINE":
        if int(entry.number(70)) & _MESH:
            return None
        drawn = [vertex for vertex in vertices if not int(vertex.number(70)) & _NO_VERTEX]
        corners = np.array([(vertex.number(10), vertex.number(20)) for vertex in drawn])
        line = _polyline(corners * scale, [v.number(42) for v in drawn], bool(int(entry.number(70)) & _CLOSED))
    else:
        draw = _KINDS.get(entry.kind)
        line = None if draw is None else draw(entry, scale)
    if line is not None and entry.number(230, 1.0) < 0.0:  # seen from below
        line = line[0] * (-1.0, 1.0), line[1]
    return line


def _polyline(corners: Array, bulges: Sequence[float], closed: bool) -> Line | None:
    if len(corners) == 0:
        return None
    parts = [corners[:1]]
    for start, end, bulge in zip(corners, corners[1:], bulges, strict=False):
        parts.append(bulged(start, end, bulge))
    if closed and bulges[-1]:
        parts.append(bulged(corners[-1], corners[0], bulges[-1])[:-1])
    return np.concatenate(parts), closed


def _light(entry: Entry, scale: float) -> Line | None:
    """A polyline whose vertices are in the entry itself; a bulge follows the vertex that it begins at."""
    corners: list[list[float]] = []
    bulges: list[float] = []
    for code, value in entry.pairs:
        if code == 10:
            corners.append([float(value), 0.0])
            bulges.append(0.0)
        elif code == 20 and corners:
            corners[-1][1] = float(value)
        elif code == 42 and corners:
            bulges[-1] = float(value)
    return _polyline(np.reshape(corners, (-1, 2)) * scale, bulges, bool(int(entry.number(70)) & _CLOSED))


def _straight(entry: Entry, scale: float) -> Line:
    ends = [(entry.number(10), entry.number(20)), (entry.number(11), entry.number(21))]
    return np.array(ends) * scale, False


def _circle(entry: Entry, scale: float) -> Line:
    center, radius = _center(entry) * scale, entry.number(40) * scale
    return ellipse(center, (radius, 0.0), (0.0, radius)), True


def _arc(entry: Entry, scale: float) -> Line:
    center, radius = _center(entry) * scale, entry.number(40) * scale
    start, end = math.radians(entry.number(50)), math.radians(entry.number(51))
    sweep = (end - start) % (2.0 * math.pi) or 2.0 * math.pi
    return ellipse(center, (radius, 0.0), (0.0, radius), start, sweep), False


def _ellipse(entry: Entry, scale: float) -> Line:
    axis = np.array([entry.number(11), entry.number(21)]) * scale
    other = np.array([-axis[1], axis[0]]) * entry.number(40, 1.0)
    start, end = entry.number(41, 0.0), entry.number(42, 2.0 * math.pi)
    sweep = (end - start) % (2.0 * math.pi)
    whole_turn = sweep < 1e-9 or sweep > 2.0 * math.pi - 1e-9
    swept = 2.0 * math.pi if whole_turn else sweep
    return ellipse(_center(entry) * scale, axis, other, start, swept), whole_turn


def _spline(entry: Entry, scale: float) -> Line | None:
    controls = np.array([entry.numbers(10), entry.numbers(20)]).T
    degree, knots = int(entry.number(71, 3)), entry.numbers(40)
    closed = bool(int(entry.number(70)) & _CLOSED)
    if len(controls) > degree and len(knots) == len(controls) + degree + 1:
        return spline(degree, knots, controls * scale, entry.numbers(41)), closed
    fit = np.array([entry.numbers(11), entry.numbers(21)]).T
    return (fit * scale, closed) if len(fit) > 1 else None


def _point(entry: Entry, scale: float) -> Line:
    return _center(entry)[None] * scale, False


def _center(entry: Entry) -> Array:
    return np.array([entry.number(10), entry.number(20)])


_KINDS: dict[str, Callable[[Entry, float], Line | None]] = {
    "LWPOLYLINE": _light,
    "LINE": _straight,
    "CIRCLE": _circle,
    "ARC": _arc,
    "ELLIPSE": _ellipse,
    "SPLINE": _spline,
    "POINT": _point,
}
