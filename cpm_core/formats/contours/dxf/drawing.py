"""DXF: contours as polylines for CAD."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator

from cpm_core.contours.contour import Contour
from cpm_core.contours.result import Result
from cpm_core.formats.common.provenance import ascii_entries_of, facts_of
from cpm_core.formats.contours.appearance import rgb
from cpm_core.formats.contours.dxf.colors import BY_LAYER, NUMBER_OF, nearest
from cpm_core.formats.contours.dxf.frame import Frame
from cpm_core.medial_axis.skeleton import Skeleton

CLOSED, OPEN = "CLOSED", "OPEN"
"""Layers of contours without a name."""

SHAPE, SPACING = "image_shape", "pixel_size"
"""Names in comments: rows and columns of the image, and the size of a pixel along them."""

_COLOR_OF = {CLOSED: 4, OPEN: 30}
_PLAIN = 7
_LONGEST_NAME = 255
_LONGEST_LINE = 250
_NOT_IN_NAMES = re.compile(r'[<>/\\":;?*|,=`\x00-\x1f]')


def encode(result: Result | Skeleton) -> bytes:
    """Write each contour as a polyline (DXF of release 2007).

    The drawing is the right way up: x runs along columns and y up, from the lower left corner of the image, in the unit
    of the image where the size of a pixel is known, which the header tells (``$INSUNITS``), else in px. Closed and open
    contours lie on layers of these names, and one with a name on a layer of that name, with an underscore for what
    names of layers may not have; a color is its own. A single vertex is a point. How they were found, and the image, is
    told in comments at the beginning.
    """
    rows, cols = result.shape
    height, width = rows * result.spacing[0], cols * result.spacing[1]
    frame = Frame()
    layers = [_layer(contour) for contour in result.contours]
    for contour, layer in zip(result.contours, layers, strict=True):
        x = ((contour.points[:, 1] + 0.5) * result.spacing[1]).tolist()
        y = (height - (contour.points[:, 0] + 0.5) * result.spacing[0]).tolist()
        look = _look(contour)
        if len(x) == 1:
            frame.add("POINT", layer, look, "AcDbPoint", 10, _number(x[0]), 20, _number(y[0]), 30, "0.0")
            continue
        corners = [part for place in zip(x, y, strict=True) for part in (10, _number(place[0]), 20, _number(place[1]))]
        frame.add("LWPOLYLINE", layer, look, "AcDbPolyline", 90, len(x), 70, int(contour.closed), *corners)
    header = {
        "$EXTMIN": (10, "0.0", 20, "0.0", 30, "0.0"),
        "$EXTMAX": (10, _number(width), 20, _number(height), 30, "0.0"),
        "$INSUNITS": (70, NUMBER_OF.get(result.unit or "", 0)),
        "$MEASUREMENT": (70, 1),
    }
    names = dict.fromkeys(["0", CLOSED, OPEN, *sorted(layers)])
    return frame.text(_comments(result), header, {name: _COLOR_OF.get(name, _PLAIN) for name in names})


def _comments(result: Result | Skeleton) -> Iterator[str]:
    """How contours were found, and in what image, in lines that are not too long."""
    told = ascii_entries_of(facts_of(result))
    told |= {SHAPE: " ".join(map(str, result.shape)), SPACING: " ".join(f"{size:.17g}" for size in result.spacing)}
    for name, text in told.items():
        yield from textwrap.wrap(f"{name}: {text}", _LONGEST_LINE, subsequent_indent="  ")


def _layer(contour: Contour) -> str:
    """Name of the layer of a contour, in characters that layers may have."""
    named = _NOT_IN_NAMES.sub("_", contour.name).strip()[:_LONGEST_NAME].strip()
    return named or (CLOSED if contour.closed else OPEN)


def _look(contour: Contour) -> list[object]:
    """The color of a contour, as the nearest number and as red, green and blue; that of its layer when it has none."""
    if not contour.color:
        return [62, BY_LAYER]
    red, green, blue = rgb(contour)
    return [62, nearest((red, green, blue)), 420, red << 16 | green << 8 | blue]


def _number(value: float) -> str:
    return f"{value:.12g}"
