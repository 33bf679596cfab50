"""Content of contour files: colors and coordinates as they are written, and contours as a reader collects them."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from PIL import ImageColor

from cpm_core.contours.contour import Contour
from cpm_core.numerics.types import Array, JsonDict, frozen

DEFAULT_COLOR = "#d6006c"
"""Color of contours that have none of their own: visible on gray and on white."""

PIXEL_OFFSET = 0.5
"""Center of the first pixel in formats that count from its corner [px]."""


def contour_rgb(contour: Contour) -> tuple[int, int, int]:
    """Return red, green and blue of a contour, each from 0 to 255."""
    color = contour.color or DEFAULT_COLOR
    return int(color[1:3], 16), int(color[3:5], 16), int(color[5:7], 16)


def to_xy_pairs(points: Array) -> list[list[float]]:
    """Convert points (row, col), shape (N, 2), to pairs [x, y] from the corner of the image [px]."""
    return round_coordinates(points[:, ::-1] + PIXEL_OFFSET)


def round_coordinates(values: Array) -> list[Any]:
    """Round numbers of any shape to four decimals, as nested lists."""
    return list(np.round(values, 4).tolist())


@frozen
class PlaneInfo:
    """What is known of the image that contours belong to: its shape, the size of a pixel and its unit, and its name."""

    shape: tuple[int, int] | None = None
    spacing: tuple[float, float] = (1.0, 1.0)
    unit: str | None = None
    name: str = ""


@dataclass(eq=False)
class CollectedContours:
    """Contours and points collected by a reader.

    Attributes
    ----------
    contours : list of Contour
        Contours, in px.
    pages : list of int
        Page of each contour in a stack, from 1; 0 where the file names none.
    points : list of tuple
        Row, column and page of single points.
    omissions : Counter
        Number of entries of each kind that were not read.
    shape : tuple of int or None
        Shape of the image, where the file gives it.
    notes : list of str
        Further messages, one sentence each.
    is_own : bool
        Whether CPM wrote the file: the names and colors it gives to contours without any are then dropped.
    """

    contours: list[Contour] = field(default_factory=list)
    pages: list[int] = field(default_factory=list)
    points: list[tuple[float, float, int]] = field(default_factory=list)
    omissions: Counter[str] = field(default_factory=Counter)
    shape: tuple[int, int] | None = None
    notes: list[str] = field(default_factory=list)
    is_own: bool = False
    _objects: int = field(default=0, repr=False)

    def add_contour(self, points: Any, closed: bool, *, page: int = 0, junctions: Any = (), **properties: Any) -> None:
        """Add a line of vertices (row, col), shape (K, 2) [px]; a single vertex is added as a point.

        `properties` are fields of `Contour`. ValueError when `points` are not pairs.
        """
        vertices = np.array(points, float)
        if vertices.ndim != 2 or vertices.shape[1] != 2:
            raise ValueError("vertices are not pairs")
        if not len(vertices):
            self.omissions["empty line"] += 1
            return
        if len(vertices) == 1:
            self.add_point(vertices[0], page)
            return
        if closed and len(vertices) > 2 and np.array_equal(vertices[0], vertices[-1]):
            vertices = vertices[:-1]
        first, last = (*map(bool, junctions), False, False)[:2]
        known = clean_properties(properties)
        if self.is_own and re.fullmatch(r"(contour|track) \d+", known["name"]):
            known["name"] = ""
        if self.is_own and known["color"] == DEFAULT_COLOR:
            known["color"] = ""
        self.contours.append(Contour(vertices, closed and len(vertices) > 2, junctions=(first, last), **known))
        self.pages.append(page)

    def add_object(self, curves: Iterable[tuple[Any, bool]], *, page: int = 0, **properties: Any) -> None:
        """Add closed curves, each with whether it bounds a hole, as the boundaries of one object."""
        rings = [(points, hole) for points, hole in curves if len(points) > 2]
        group = 0
        if len(rings) > 1:
            self._objects += 1
            group = self._objects
        for points, hole in rings:
            own = {**properties, "number": 0} if hole else properties
            self.add_contour(points, True, page=page, group=group, hole=hole, **own)

    def add_point(self, place: Sequence[float] | Array, page: int = 0) -> None:
        """Add a single point (row, col), shape (2,) [px]."""
        row, col = map(float, place)
        self.points.append((row, col, page))


def clean_properties(properties: JsonDict) -> JsonDict:
    """Clean the properties of a contour, dropping values that it cannot have."""
    return {
        **properties,
        "name": str(properties.get("name") or ""),
        "category": str(properties.get("category") or ""),
        "color": parse_color(properties.get("color")),
        "strength": _finite_or_zero(properties.get("strength")),
        "bridged": _finite_or_zero(properties.get("bridged")),
        "gray": None if properties.get("gray") is None else _finite_or_zero(properties["gray"]),
        "number": max(0, int(properties.get("number") or 0)),
    }


def _finite_or_zero(value: Any) -> float:
    """Return a number, 0 if it is missing or not finite."""
    number = float(value or 0.0)
    return number if math.isfinite(number) else 0.0


def parse_color(value: object) -> str:
    """Parse a color from red, green and blue, a whole number 0xRRGGBB, or a name; empty if it is none."""
    if isinstance(value, str):
        try:
            value = ImageColor.getrgb(value)
        except ValueError:
            return ""
    if isinstance(value, (list, tuple)) and len(value) >= 3:
        return "#{:02x}{:02x}{:02x}".format(*(min(255, max(0, int(part))) for part in value[:3]))
    return f"#{value & 0xFFFFFF:06x}" if isinstance(value, int) and not isinstance(value, bool) else ""
