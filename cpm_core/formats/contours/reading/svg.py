"""SVG: paths and shapes of drawings as contours."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from typing import Any

import numpy as np

from cpm_core.formats.contours.reading.contents import Contents, Plane
from cpm_core.formats.contours.reading.curves import ellipse, rectangle
from cpm_core.formats.contours.reading.svg_path import lines_of
from cpm_core.formats.images.decoded import UnreadableError
from cpm_core.numerics.types import Array

_NOT_DRAWN = {
    *("defs", "symbol", "clipPath", "mask", "pattern", "marker", "linearGradient", "radialGradient", "filter"),
    *("style", "script", "title", "desc", "metadata", "namedview", "foreignObject"),
}
_LEFT_OUT = {"text": "text", "image": "picture", "use": "copy of another element"}
_CALL = re.compile(r"(\w+)\s*\(([^)]*)\)")
_SAME_ASPECT = 0.01
"""Largest relative difference between the sides of a drawing and those of the image, up to which it is scaled to it."""

_DEEPEST = 100


def read(text: str, plane: Plane) -> Contents:
    """Contours of all paths and shapes, in px.

    The view box begins at the corner of the image; one of another size but of the same shape as the image is scaled to
    it. Title, label or identifier is the name of a contour, its stroke or else its fill the color.
    """
    if "<!ENTITY" in text:
        raise UnreadableError("The drawing defines entities, which are not read: save it as plain SVG.")
    root = ET.fromstring(text)
    if _tag(root) != "svg":
        raise ValueError("not a drawing")
    found = Contents()
    own = "data-closed" in text and root.find("{*}metadata") is not None
    frame, found.shape = _frame(root, plane, own)
    for element, matrix, look in _elements(root, np.eye(3), {}, found):
        shape = _shape(element)
        if shape is None:
            continue
        known = _known(element, look, own)
        scaled = frame @ matrix
        for points, closed in shape:
            places = points @ scaled[:2, :2].T + scaled[:2, 2]
            if own and len(places) == 2 and np.array_equal(places[0], places[1]):
                places = places[:1]  # a dot
            found.add(places[:, ::-1], closed, **known)
    return found


def _elements(
    parent: ET.Element, matrix: Array, look: dict[str, str], found: Contents, depth: int = 0
) -> Iterator[tuple[ET.Element, Array, dict[str, str]]]:
    """Elements that are drawn, with the matrix from their coordinates to those of the drawing and what they inherit."""
    if depth > _DEEPEST:
        raise ValueError("groups are nested too deeply")
    for element in parent:
        tag = _tag(element)
        style = _style(element)
        if tag in _NOT_DRAWN or style.get("display") == "none":
            continue
        if tag in _LEFT_OUT:
            found.left_out[_LEFT_OUT[tag]] += 1
            continue
        placed = matrix @ _matrix(element.get("transform", ""))
        inherited = look | {name: value for name, value in style.items() if name in ("stroke", "fill")}
        if tag in ("g", "a", "svg", "switch"):
            yield from _elements(element, placed, inherited, found, depth + 1)
        else:
            yield element, placed, inherited


def _tag(element: ET.Element) -> str:
    tag: Any = element.tag
    return tag.rpartition("}")[2] if isinstance(tag, str) else ""  # a comment has a function for a tag


def _style(element: ET.Element) -> dict[str, str]:
    """Attributes of an element with those of its style, which win."""
    parts = (part.partition(":") for part in element.get("style", "").split(";"))
    return {**element.attrib, **{name.strip(): value.strip() for name, _, value in parts if value}}


def _known(element: ET.Element, look: dict[str, str], own: bool) -> dict[str, Any]:
    """Name, color and, in drawings of CPM, number and strength."""
    title = element.find("{*}title")
    label = next((value for key, value in element.attrib.items() if key.endswith("}label")), "")
    name = (title.text or "" if title is not None else "") or label or ("" if own else element.get("id", ""))
    stroke, fill = (look.get(kind, "none") for kind in ("stroke", "fill"))
    if own:  # the color of a group is that of contours without one
        stroke, fill = element.get("stroke", ""), ""
    color = stroke if stroke != "none" else fill
    known: dict[str, Any] = {"name": name, "color": color}
    if own:
        known |= {"strength": element.get("data-strength", 0.0), "number": element.get("data-number", 0)}
    return known


def _shape(element: ET.Element) -> list[tuple[Array, bool]] | None:
    """The lines of an element (x, y), and whether each is closed; None for one that is no shape."""
    tag = _tag(element)
    if tag == "path":
        return [(points, closed or _meets(points)) for points, closed in lines_of(element.get("d", ""))]
    if tag in ("polygon", "polyline"):
        numbers = [float(part) for part in re.split(r"[\s,]+", element.get("points", "").strip()) if part]
        points = np.reshape(numbers[: len(numbers) // 2 * 2], (-1, 2))
        return [(points, tag == "polygon" or _meets(points))] if len(points) else None
    if tag == "line":
        x1, y1, x2, y2 = _values(element, "x1", "y1", "x2", "y2")
        return [(np.array([(x1, y1), (x2, y2)]), False)]
    if tag == "rect":
        x, y, width, height = _values(element, "x", "y", "width", "height")
        return [(rectangle((x, y), (x + width, y + height)), True)]
    if tag in ("circle", "ellipse"):
        x, y, across, down = _values(element, "cx", "cy", *(("r", "r") if tag == "circle" else ("rx", "ry")))
        return [(ellipse((x, y), (across, 0.0), (0.0, down)), True)]
    return None


def _values(element: ET.Element, *names: str) -> list[float]:
    """Lengths that attributes of an element have, 0 where there are none."""
    return [_length(element.get(name, "0")) for name in names]


def _meets(points: Array) -> bool:
    """Whether a line of more than two vertices ends where it begins."""
    return len(points) > 3 and bool(np.allclose(points[0], points[-1], atol=1e-6))


def _length(text: str) -> float:
    """A length in px; other units are those of style sheets, 96 px an inch."""
    found = re.fullmatch(r"\s*([+-]?[\d.]+(?:[eE][+-]?\d+)?)\s*(px|mm|cm|in|pt|pc|Q)?\s*", text)
    if found is None:
        return 0.0
    sides = {"mm": 96 / 25.4, "cm": 96 / 2.54, "in": 96.0, "pt": 96 / 72, "pc": 16.0, "Q": 96 / 101.6}
    return float(found[1]) * sides.get(found[2] or "", 1.0)


def _frame(root: ET.Element, plane: Plane, own: bool) -> tuple[Array, tuple[int, int] | None]:
    """Matrix from the coordinates of a drawing to (x, y) in px, and the shape of its image as far as it tells."""
    box = [float(part) for part in re.split(r"[\s,]+", root.get("viewBox", "").strip()) if part]
    if len(box) != 4:
        box = [0.0, 0.0, _length(root.get("width", "0")), _length(root.get("height", "0"))]
    x, y, width, height = box
    matrix = np.array([[1.0, 0.0, -x - 0.5], [0.0, 1.0, -y - 0.5], [0.0, 0.0, 1.0]])
    if own:
        return matrix, (round(height), round(width))
    if plane.shape is None or min(width, height) <= 0.0:
        return matrix, None
    scales = plane.shape[1] / width, plane.shape[0] / height
    if abs(math.log(scales[0] / scales[1])) > _SAME_ASPECT:
        return matrix, None
    return np.array([[scales[0], 0.0, -scales[0] * x - 0.5], [0.0, scales[1], -scales[1] * y - 0.5], [0, 0, 1]]), None


def _matrix(text: str) -> Array:
    """The matrix of an attribute ``transform``."""
    whole = np.eye(3)
    for name, given in _CALL.findall(text):
        numbers = [float(part) for part in re.split(r"[\s,]+", given.strip()) if part]
        whole = whole @ _part(name, numbers)
    return np.asarray(whole)


def _part(name: str, numbers: list[float]) -> Array:
    """The matrix of one transformation."""
    if name == "matrix":
        a, b, c, d, e, f = numbers
        return np.array([[a, c, e], [b, d, f], [0.0, 0.0, 1.0]])
    first, second = numbers[0], numbers[1] if len(numbers) > 1 else None
    if name == "translate":
        return np.array([[1.0, 0.0, first], [0.0, 1.0, second or 0.0], [0.0, 0.0, 1.0]])
    if name == "scale":
        return np.diag([first, first if second is None else second, 1.0])
    angle = math.radians(first)
    if name == "rotate":
        turn = np.array(
            [[math.cos(angle), -math.sin(angle), 0.0], [math.sin(angle), math.cos(angle), 0.0], [0.0, 0.0, 1.0]]
        )
        if len(numbers) < 3:
            return turn
        return np.asarray(_part("translate", numbers[1:]) @ turn @ _part("translate", [-numbers[1], -numbers[2]]))
    skewed = np.eye(3)
    if name == "skewX":
        skewed[0, 1] = math.tan(angle)
    elif name == "skewY":
        skewed[1, 0] = math.tan(angle)
    return skewed
