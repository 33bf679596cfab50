"""DXF: contours as polylines for CAD."""

from __future__ import annotations

import math
import re
import textwrap

from cpm_core.contours.contour import Contour
from cpm_core.contours.result import Result
from cpm_core.formats.contours.appearance import rgb
from cpm_core.formats.provenance import ascii_entries_of, facts_of
from cpm_core.medial_axis.skeleton import Skeleton

_CLOSED, _OPEN = "CLOSED", "OPEN"
_NUMBERS = {
    (255, 0, 0): 1,
    (255, 255, 0): 2,
    (0, 255, 0): 3,
    (0, 255, 255): 4,
    (0, 0, 255): 5,
    (255, 0, 255): 6,
    (255, 255, 255): 7,
    (0, 0, 0): 7,  # black on white paper, white on a dark screen
    (128, 128, 128): 8,
    (255, 127, 0): 30,
}
"""Color numbers of this version of the format."""

_BY_LAYER = 256
_LONGEST_NAME = 31
_COMMENT, _LONGEST_LINE = 999, 250


def encode(result: Result | Skeleton) -> bytes:
    """Write each contour as a polyline (DXF of AutoCAD release 12, which all programs read).

    The drawing is the right way up: x runs along columns and y up, from the lower left corner of the image, in the unit
    of the image where the size of a pixel is known, else in px. Closed and open contours lie on layers of these names,
    and one with a name on a layer of that name, with other signs than letters, digits and dashes replaced; a color
    becomes the nearest of `_NUMBERS`. A single vertex is a point. How they were found is told in comments at the
    beginning.
    """
    rows, cols = result.shape
    height, width = rows * result.spacing[0], cols * result.spacing[1]
    layers = [_layer(contour) for contour in result.contours]
    names = sorted({_CLOSED, _OPEN, *layers})
    lines = _comments(result)
    lines += [0, "SECTION", 2, "HEADER", 9, "$ACADVER", 1, "AC1009"]
    lines += [9, "$EXTMIN", 10, "0.0", 20, "0.0", 9, "$EXTMAX", 10, _number(width), 20, _number(height), 0, "ENDSEC"]
    lines += [0, "SECTION", 2, "TABLES", 0, "TABLE", 2, "LTYPE", 70, 1]
    lines += [0, "LTYPE", 2, "CONTINUOUS", 70, 0, 3, "Solid line", 72, 65, 73, 0, 40, "0.0", 0, "ENDTAB"]
    lines += [0, "TABLE", 2, "LAYER", 70, len(names)]
    for name in names:
        lines += [0, "LAYER", 2, name, 70, 0, 62, 4 if name == _CLOSED else 30 if name == _OPEN else 7]
        lines += [6, "CONTINUOUS"]
    lines += [0, "ENDTAB", 0, "ENDSEC", 0, "SECTION", 2, "ENTITIES"]
    for contour, layer in zip(result.contours, layers, strict=True):
        x = (contour.points[:, 1] + 0.5) * result.spacing[1]
        y = height - (contour.points[:, 0] + 0.5) * result.spacing[0]
        lines += _entity(x.tolist(), y.tolist(), contour, layer)
    lines += [0, "ENDSEC", 0, "EOF"]
    return ("\n".join(map(str, lines)) + "\n").encode("ascii")


def _comments(result: Result | Skeleton) -> list[object]:
    """How contours were found, in lines as long as this version of the format allows."""
    lines: list[object] = []
    for name, told in ascii_entries_of(facts_of(result)).items():
        for part in textwrap.wrap(f"{name}: {told}", _LONGEST_LINE, subsequent_indent="  "):
            lines += [_COMMENT, part]
    return lines


def _entity(x: list[float], y: list[float], contour: Contour, layer: str) -> list[object]:
    look: list[object] = [8, layer, 62, _nearest(contour)]
    if len(x) == 1:
        return [0, "POINT", *look, 10, _number(x[0]), 20, _number(y[0]), 30, "0.0"]
    lines = [0, "POLYLINE", *look, 66, 1, 10, "0.0", 20, "0.0", 30, "0.0", 70, int(contour.closed)]
    for along, up in zip(x, y, strict=True):
        lines += [0, "VERTEX", 8, layer, 10, _number(along), 20, _number(up), 30, "0.0"]
    return [*lines, 0, "SEQEND", 8, layer]


def _layer(contour: Contour) -> str:
    """Name of the layer of a contour, in characters that layers may have."""
    named = re.sub(r"[^A-Z0-9_$-]+", "_", contour.name.upper()).strip("_")[:_LONGEST_NAME]
    return named or (_CLOSED if contour.closed else _OPEN)


def _nearest(contour: Contour) -> int:
    """Number of the color nearest to that of a contour; the color of its layer when it has none."""
    if not contour.color:
        return _BY_LAYER
    red, green, blue = rgb(contour)
    return _NUMBERS[min(_NUMBERS, key=lambda known: math.dist(known, (red, green, blue)))]


def _number(value: float) -> str:
    return f"{value:.6f}" if abs(value) >= 1.0 else f"{value:.9f}"
