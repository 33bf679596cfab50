"""DXF: lines of drawings as contours."""

from __future__ import annotations

import numpy as np

from cpm_core.formats.contours.dxf.colors import BY_BLOCK, BY_LAYER, UNITS, color
from cpm_core.formats.contours.dxf.drawing import CLOSED, OPEN, SHAPE, SPACING
from cpm_core.formats.contours.reading.contents import Contents, Plane
from cpm_core.formats.contours.reading.dxf.entities import Line, line_of, whole
from cpm_core.formats.contours.reading.dxf.groups import Entry, comments_of, decoded, sections_of
from cpm_core.formats.images import resolution

_NO_NAME = ("0", CLOSED, OPEN)
"""Layers that are no names of contours."""


def read(content: bytes, plane: Plane) -> Contents:
    """Contours of the lines of a drawing, whose origin is the lower left corner of the image.

    Where header and image name a unit, lengths are converted to px by the size of a pixel; else the unit of the drawing
    is 1 px, or one unit of the image. CPM tells the image in comments. The layer is the name of a contour.
    """
    text = decoded(content)
    sections, told = sections_of(text), comments_of(text)
    header = {entry.kind: entry for entry in sections.get("HEADER", [])}
    found = Contents()
    spacing, scale = _pixel(header, told, plane, found)
    lines: list[tuple[Entry, Line]] = []
    for entry, vertices in whole(sections.get("ENTITIES", [])):
        if int(entry.number(67)):
            continue  # on paper, around the drawing
        line = line_of(entry, vertices, scale / spacing[1])
        if line is None:
            found.left_out[f"entity {entry.kind}"] += 1
        else:
            lines.append((entry, line))
    found.shape = _shape(told)
    height = _height(found, header, plane, spacing, lines)
    looks = {entry.text(2): entry for entry in sections.get("TABLES", []) if entry.kind == "LAYER"}
    for entry, (points, closed) in lines:
        row = height - points[:, 1] * spacing[1] / spacing[0] - 0.5
        layer = entry.text(8, "0")
        name = "" if layer in _NO_NAME else layer
        places = np.column_stack([row, points[:, 0] - 0.5])
        ends_meet = len(points) > 3 and bool(np.allclose(points[0], points[-1], atol=1e-3))
        found.add(places, closed or ends_meet, name=name, color=_color(entry, looks.get(layer), told))
    return found


def _pixel(
    header: dict[str, Entry], told: dict[str, str], plane: Plane, found: Contents
) -> tuple[tuple[float, float], float]:
    """Size of a pixel, and how many of its unit one of the drawing is."""
    if SPACING in told:
        row, col = map(float, told[SPACING].split())
        return (row, col), 1.0
    number = int(header["$INSUNITS"].number(70)) if "$INSUNITS" in header else 0
    if number in UNITS and plane.unit is not None:
        count, unit = UNITS[number]
        return plane.spacing, count * resolution.factor(unit, plane.unit)
    if plane.unit is None and number in UNITS:
        found.notes.append("The drawing has a unit, but the image has no size of a pixel: one unit is taken for 1 px.")
    return (1.0, 1.0), 1.0


def _shape(told: dict[str, str]) -> tuple[int, int] | None:
    if SHAPE not in told:
        return None
    rows, cols = map(int, told[SHAPE].split())
    return rows, cols


def _height(
    found: Contents,
    header: dict[str, Entry],
    plane: Plane,
    spacing: tuple[float, float],
    lines: list[tuple[Entry, Line]],
) -> float:
    """Height of the image in px: what the file or the image tells, else that of the drawing."""
    shape = found.shape or plane.shape
    if shape is not None:
        return float(shape[0])
    highest = max((float(points[:, 1].max()) * spacing[1] / spacing[0] for _, (points, _) in lines), default=0.0)
    known = header["$EXTMAX"].number(20) / spacing[0] if "$EXTMAX" in header else 0.0
    found.notes.append("The drawing does not tell the height of the image: its own is taken.")
    return known if known >= highest else highest


def _color(entry: Entry, layer: Entry | None, told: dict[str, str]) -> str:
    """Color of an entity, by its own or that of its layer; that of the layers of CPM is none."""
    packed = entry.number(420, -1.0)
    if packed >= 0.0:
        return f"#{int(packed) & 0xFFFFFF:06x}"
    number = int(entry.number(62, BY_LAYER))
    if number in (BY_LAYER, BY_BLOCK):
        if layer is None or SPACING in told:
            return ""
        packed = layer.number(420, -1.0)
        if packed >= 0.0:
            return f"#{int(packed) & 0xFFFFFF:06x}"
        number = abs(int(layer.number(62, 7)))
        if number == 7:  # the usual one
            return ""
    return "#{:02x}{:02x}{:02x}".format(*color(number)) if 1 <= number <= 255 else ""
