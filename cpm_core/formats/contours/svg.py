"""SVG: contours as paths for browsers and drawing programs, and paths and shapes of drawings as contours."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from html import escape
from typing import Any

import numpy as np

from cpm_core.contours.contour import Contour
from cpm_core.contours.measurements import assign_labels
from cpm_core.formats.common.provenance import Outcome, describe_provenance, dump_provenance
from cpm_core.formats.contours.contents import DEFAULT_COLOR, CollectedContours, PlaneInfo
from cpm_core.formats.contours.curves import flatten_bezier
from cpm_core.formats.images import resolution
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.numerics.types import Array, JsonDict

_PIXELS_PER_INCH = 96.0
"""Resolution of CSS."""

_SHAPE_TAGS = ("path", "polygon", "polyline", "line", "rect", "circle", "ellipse")
"""Elements that become contours."""

_GEOMETRY_ATTRIBUTES = ("d", "points", "x", "y", "x1", "y1", "x2", "y2", "width", "height", "rx", "ry", "r", "cx", "cy")
"""Attributes that describe the geometry of a shape."""

_UNDRAWN_TAGS = {
    *("defs", "symbol", "clipPath", "mask", "pattern", "marker", "linearGradient", "radialGradient", "filter"),
    *("style", "script", "title", "desc", "metadata", "namedview", "foreignObject"),
}
"""Elements that are not drawn in place."""

_SKIPPED_TAGS = {"text": "text", "image": "picture", "use": "copy of another element"}
"""Drawn elements that are not read -> their names in notes."""

_ASPECT_TOLERANCE = 0.01
"""Largest difference of the logarithms of scale along x and y for a drawing to be scaled to the image."""

_MIN_PAGE_SIDE = 10.0
"""Smallest side of a page of true size [mm]: a page of the size of a cell would be invisible."""


def encode_svg(result: Outcome) -> bytes:
    """Draw the contours of a result.

    User units are pixels of the image, x along columns and y along rows, pixel centers at integers: the image covers
    the view box. Every contour is one path without a fill. Its data attributes state whether it is closed, its mean
    edge strength [gray levels / px], its length [px], its contrast if it can be measured, and its label in the label
    mask (0 when open). A name becomes the title, a color the stroke. The page has true size if that is known and large
    enough to see, else one CSS pixel per pixel. Each branch of a skeleton is such a path, with the distance of its
    vertices to the boundary [px]. The metadata are the provenance as JSON.
    """
    rows, cols = result.shape
    width, height = _page_size(result)
    spacing = " ".join(f"{size:.9g}" for size in result.spacing)
    known = f' data-unit="{escape(result.unit)}" data-spacing="{spacing}"' if result.unit else ""
    if isinstance(result, Skeleton):
        title = "Skeleton"
        paths = [
            _format_path(c, n, r) for n, (c, r) in enumerate(zip(result.contours, result.radii, strict=True), start=1)
        ]
    else:
        title = "Contours"
        paths = [
            _format_path(contour, n) for contour, n in zip(result.contours, assign_labels(result.contours), strict=True)
        ]
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="-0.5 -0.5 {cols} {rows}" '
        f'preserveAspectRatio="none"{known}>',
        f"<title>{title} of {escape(result.source, quote=False)}</title>",
        f"<metadata>{escape(dump_provenance(describe_provenance(result)), quote=False)}</metadata>",
        f'<g fill="none" stroke="{DEFAULT_COLOR}" stroke-width="1.5" stroke-linejoin="round" stroke-linecap="round">',
        *paths,
        "</g>",
        "</svg>",
    ]
    return ("\n".join(lines) + "\n").encode()


def _format_path(contour: Contour, label: int, radii: Array | None = None) -> str:
    """Format a contour as a path, with the radii of its vertices, shape (K,), if it is a branch."""
    vertices = contour.points if len(contour.points) > 1 else contour.points.repeat(2, axis=0)  # a single vertex: a dot
    points = " L".join(f"{col:.3f} {row:.3f}" for row, col in vertices)
    known = "" if radii is None else f'data-radii="{" ".join(f"{radius:.3f}" for radius in radii)}" '
    known += "" if contour.measure_contrast is None else f'data-contrast="{contour.contrast:.4f}" '
    known += f'data-number="{contour.number}" ' if contour.number else ""
    known += f'stroke="{contour.color}" ' if contour.color else ""
    end = f"><title>{escape(contour.name, quote=False)}</title></path>" if contour.name else "/>"
    return (
        f'<path fill="none" vector-effect="non-scaling-stroke" data-closed="{str(contour.closed).lower()}" '
        f'data-label="{label}" data-strength="{contour.strength:.6g}" data-length="{contour.length:.3f}" {known}'
        f'd="M{points}{" Z" if contour.closed else ""}"{end}'
    )


def _page_size(result: Outcome) -> tuple[str, str]:
    """Return width and height of the drawing as SVG lengths."""
    size = np.array(result.shape) * result.spacing
    millimeters = size * resolution.conversion_factor(result.unit, "mm")
    if millimeters.min() >= _MIN_PAGE_SIDE:
        return f"{millimeters[1]:.6g}mm", f"{millimeters[0]:.6g}mm"
    pixels = size / min(result.spacing)
    return f"{pixels[1]:.6g}", f"{pixels[0]:.6g}"


def read_svg(text: str, plane: PlaneInfo) -> CollectedContours:
    """Read contours from all paths and shapes, in px.

    The view box begins at the corner of the image; one of another size but the same shape as the image is scaled to it.
    Title, label or identifier is the name of a contour, its stroke or else its fill the color.
    """
    root = ET.fromstring(text)
    if _tag_name(root) != "svg":
        raise ValueError("not a drawing")
    found = CollectedContours()
    own = "data-closed" in text and root.find("{*}metadata") is not None
    frame, size, found.shape = _parse_frame(root, plane, own)
    for element, matrix, look in _iterate_elements(root, frame, {}, found):
        for places, closed in _flatten_element(element, matrix, size):
            dot = own and len(places) == 2 and np.array_equal(places[0], places[1])
            found.add_contour(places[: 1 if dot else None, ::-1], closed, **_parse_attributes(element, look, own))
    return found


def _parse_frame(
    root: ET.Element, plane: PlaneInfo, own: bool
) -> tuple[Any, tuple[float, float], tuple[int, int] | None]:
    """Parse the matrix from drawing coordinates to (x, y) in px, width and height, and the shape of the image."""
    from svgelements import Length, Matrix

    box = [float(part) for part in re.split(r"[\s,]+", root.get("viewBox", "").strip()) if part]
    if len(box) != 4:
        sides = (Length(root.get(side, "0")).value(ppi=_PIXELS_PER_INCH) for side in ("width", "height"))
        box = [0.0, 0.0, *(side if isinstance(side, float) else 0.0 for side in sides)]
    x, y, width, height = box
    across = down = 1.0
    if plane.shape is not None and not own and min(width, height) > 0.0:
        scales = plane.shape[1] / width, plane.shape[0] / height
        if abs(math.log(scales[0] / scales[1])) <= _ASPECT_TOLERANCE:
            across, down = scales
    matrix = Matrix(across, 0.0, 0.0, down, -across * x - 0.5, -down * y - 0.5)
    return matrix, (width, height), (round(height), round(width)) if own else None


def _iterate_elements(
    parent: ET.Element, matrix: Any, look: dict[str, str], found: CollectedContours
) -> Iterator[tuple[ET.Element, Any, dict[str, str]]]:
    """Yield drawn elements with the matrix from their coordinates to px and the style that they inherit."""
    from svgelements import Matrix

    for element in parent:
        tag = _tag_name(element)
        parts = (part.partition(":") for part in element.get("style", "").split(";"))
        style = element.attrib | {name.strip(): value.strip() for name, _, value in parts if value}
        if tag in _UNDRAWN_TAGS or style.get("display") == "none":
            continue
        if tag in _SKIPPED_TAGS:
            found.omissions[_SKIPPED_TAGS[tag]] += 1
            continue
        placed = Matrix(element.get("transform", "")) * matrix
        inherited = look | {name: value for name, value in style.items() if name in ("stroke", "fill")}
        if tag in ("g", "a", "svg", "switch"):
            yield from _iterate_elements(element, placed, inherited, found)
        else:
            yield element, placed, inherited


def _tag_name(element: ET.Element) -> str:
    """Return the tag of an element without its namespace; empty for comments."""
    tag: Any = element.tag
    return tag.rpartition("}")[2] if isinstance(tag, str) else ""  # a comment has a function for a tag


def _parse_attributes(element: ET.Element, look: dict[str, str], own: bool) -> JsonDict:
    """Parse name, color and, in drawings of CPM, number and strength."""
    title = element.find("{*}title")
    label = next((value for key, value in element.attrib.items() if key.endswith("}label")), "")
    name = (title.text or "" if title is not None else "") or label or ("" if own else element.get("id", ""))
    stroke, fill = (look.get(kind, "none") for kind in ("stroke", "fill"))
    if own:  # the color of a group is that of contours without one
        stroke, fill = element.get("stroke", ""), ""
    color = stroke if stroke != "none" else fill
    known: JsonDict = {"name": name, "color": color}
    if own:
        known |= {"strength": element.get("data-strength", 0.0), "number": element.get("data-number", 0)}
    return known


def _flatten_element(element: ET.Element, matrix: Any, size: tuple[float, float]) -> Iterator[tuple[Array, bool]]:
    """Flatten the lines of an element, (x, y) of shape (K, 2) in px, each with whether it is closed."""
    import svgelements

    tag = _tag_name(element)
    if tag not in _SHAPE_TAGS:
        return
    make = getattr(svgelements, "SimpleLine" if tag == "line" else tag.capitalize())
    shape = make({name: value for name, value in element.attrib.items() if name in _GEOMETRY_ATTRIBUTES})
    if tag != "path":
        shape.render(ppi=_PIXELS_PER_INCH, width=size[0], height=size[1])
    path = svgelements.Path(shape)
    path.approximate_arcs_with_cubics()
    for part in abs(path * matrix).as_subpaths():
        # a line after a closed one begins where that one began
        points = [] if isinstance(part[0], svgelements.Move) else [part[0].start]
        closed = False
        for segment in part:
            if isinstance(segment, svgelements.CubicBezier):
                points.extend(flatten_bezier(segment.start, segment.control1, segment.control2, segment.end))
            elif isinstance(segment, svgelements.QuadraticBezier):
                points.extend(flatten_bezier(segment.start, segment.control, segment.end))
            elif isinstance(segment, svgelements.Close):
                closed = True
            else:
                points.append(segment.end)
        places = np.array([(float(x), float(y)) for x, y in points]).reshape(-1, 2)
        meets = len(places) > 3 and bool(np.allclose(places[0], places[-1], atol=1e-6))
        yield (places[:-1], True) if meets else (places, closed)
