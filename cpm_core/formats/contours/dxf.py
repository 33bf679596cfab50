"""DXF: contours as polylines for CAD, and lines of its drawings as contours, by ezdxf."""

from __future__ import annotations

import io
import re
import textwrap
from typing import TYPE_CHECKING

import numpy as np

from cpm_core.formats.common.provenance import Outcome, entries_of, facts_of
from cpm_core.formats.contours.contents import Contents, Plane
from cpm_core.numerics.types import Array

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.entities.dxfgfx import DXFGraphic

_RELEASE = "R2007"
"""The first with names in any letters (UTF-8)."""

_LAYERS = {"CLOSED": 4, "OPEN": 30}
"""Layers of contours without a name, and the numbers of their colors."""

_PLAIN = 7
_BY_LAYER = (0, 256)
_SHAPE, _SPACING = "image_shape", "pixel_size"
"""Names in comments: rows and columns of the image, and the size of a pixel along them."""

_UNITS = {"nm": 12, "µm": 13, "mm": 4, "cm": 5, "m": 6}
"""Unit of an image -> its number in the header (``$INSUNITS``)."""

_LONGEST_NAME = 255
_LONGEST_LINE = 250
_NOT_IN_NAMES = re.compile(r'[<>/\\":;?*|,=`\x00-\x1f]')

_LINES = ("LINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE", "LWPOLYLINE", "POLYLINE")
_NEAR = 0.005
"""Largest distance of the vertices from a curve [px]; of large curves `_COARSE` of their size."""

_COARSE = 1e-6


def encode(result: Outcome) -> bytes:
    """Write each contour as a polyline.

    The drawing is the right way up: x runs along columns and y up, from the lower left corner of the image, in the unit
    of the image where the size of a pixel is known, which the header gives (``$INSUNITS``), else in px. Closed and open
    contours lie on layers of these names, and one with a name on a layer of that name, with an underscore for what
    names of layers may not have; a color is its own. A single vertex is a point. How they were found, and the image,
    are comments at the beginning.
    """
    import ezdxf

    ezdxf.options.write_fixed_meta_data_for_testing = True  # the same result always gives the same bytes
    drawing = ezdxf.new(_RELEASE)
    drawing.units = _UNITS.get(result.unit or "", 0)
    model = drawing.modelspace()
    height, width = np.array(result.shape) * result.spacing
    drawing.set_modelspace_vport(height, (0.5 * width, 0.5 * height))
    for contour in result.contours:
        layer = _NOT_IN_NAMES.sub("_", contour.name).strip()[:_LONGEST_NAME].strip()
        layer = layer or ("CLOSED" if contour.closed else "OPEN")
        if not drawing.layers.has_entry(layer):
            drawing.layers.add(layer, color=_LAYERS.get(layer, _PLAIN))
        look = {"layer": layer} | ({"true_color": int(contour.color[1:], 16)} if contour.color else {})
        rows, cols = ((contour.points + 0.5) * result.spacing).T
        places = np.column_stack([cols, height - rows])
        if len(places) == 1:
            model.add_point(places[0].tolist(), look)
        else:
            polyline = model.add_lwpolyline((), close=contour.closed, dxfattribs=look)
            polyline.lwpoints = _Vertices(places.tolist())  # type: ignore[assignment]
    comments = entries_of(facts_of(result))
    comments |= {
        _SHAPE: " ".join(map(str, result.shape)),
        _SPACING: " ".join(f"{size:.17g}" for size in result.spacing),
    }
    stream = io.StringIO()
    for name, value in comments.items():
        for line in textwrap.wrap(f"{name}: {value}", _LONGEST_LINE, subsequent_indent="  "):
            stream.write(f"999\n{line}\n")
    drawing.write(stream)
    return stream.getvalue().encode()


class _Vertices(list[list[float]]):
    """Vertices (x, y) of a polyline, which ezdxf writes at once; of its own it makes an object for each number."""

    def dxftags(self) -> list[_Vertices]:
        """All as one tag."""
        return [self]

    def dxfstr(self) -> str:
        """The lines of the file."""
        return "".join(f" 10\n{x}\n 20\n{y}\n" for x, y in self)


def read(content: bytes, plane: Plane) -> Contents:
    """Contours of the lines of a drawing, whose origin is the lower left corner of the image.

    Where header and image name a unit, lengths are converted to px by the size of a pixel; else the unit of the drawing
    is 1 px, or one unit of the image. CPM writes the image in comments. The layer is the name of a contour.
    """
    import ezdxf.path
    import ezdxf.recover
    import ezdxf.units
    from ezdxf.enums import InsertUnits

    drawing, _ = ezdxf.recover.read(io.BytesIO(content))
    own = dict(re.findall(rf"^999\s+({_SHAPE}|{_SPACING}): ([^\r\n]*)", content.decode("latin-1"), re.MULTILINE))
    found = Contents()
    shape, spacing, scale = plane.shape, np.ones(2), 1.0
    if own:
        rows, cols = map(int, own[_SHAPE].split())
        found.shape = shape = rows, cols
        spacing = np.array(own[_SPACING].split(), float)
    elif drawing.units and plane.unit is not None:
        units = InsertUnits(drawing.units), InsertUnits(_UNITS[plane.unit])
        spacing, scale = np.array(plane.spacing), ezdxf.units.conversion_factor(*units)
    elif drawing.units:
        found.notes.append("The drawing has a unit, but the image has no size of a pixel: one unit is taken for 1 px.")
    lines: list[tuple[DXFGraphic, Array, bool]] = []
    for entity in drawing.modelspace():
        closed = False
        if entity.dxftype() == "POINT":
            vertices = [entity.dxf.location]
        elif entity.dxftype() in _LINES:
            path = ezdxf.path.make_path(entity, level=6)  # subdivisions of splines
            size = max((abs(part) for place in path.control_vertices() for part in place.xyz), default=0.0)
            vertices, closed = list(path.flattening(max(_NEAR * spacing[1] / scale, _COARSE * size))), path.is_closed
        else:
            found.left_out[f"entity {entity.dxftype()}"] += 1
            continue
        places = np.array([(place.x, place.y) for place in vertices]).reshape(-1, 2)
        lines.append((entity, places * scale / spacing[::-1], closed))
    if shape is None:
        found.notes.append("The drawing does not state the height of the image: its own is taken.")
    height = shape[0] if shape else max((places[:, 1].max() for _, places, _ in lines if len(places)), default=0.0)
    for entity, places, closed in lines:
        layer = entity.dxf.layer
        name = "" if layer in ("0", *_LAYERS) else layer
        points = np.column_stack([height - places[:, 1] - 0.5, places[:, 0] - 0.5])
        found.add(points, closed, name=name, color=_color(entity, drawing, bool(own)))
    return found


def _color(entity: DXFGraphic, drawing: Drawing, own: bool) -> tuple[int, int, int] | None:
    """Color of an entity, by its own or that of its layer; that of the layers of CPM, and the usual one, is none."""
    import ezdxf.colors

    rgb, number = entity.rgb, entity.dxf.color
    if rgb is None and number in _BY_LAYER and not own and drawing.layers.has_entry(entity.dxf.layer):
        layer = drawing.layers.get(entity.dxf.layer)
        rgb, number = layer.rgb, layer.color
    return ezdxf.colors.aci2rgb(number) if rgb is None and number not in (_PLAIN, *_BY_LAYER) else rgb
