"""DXF: contours as polylines for CAD, and lines of its drawings as contours, by ezdxf."""

from __future__ import annotations

import io
import re
import textwrap
from typing import TYPE_CHECKING

import numpy as np

from cpm_core.formats.common.provenance import Outcome, describe_provenance, flatten_provenance
from cpm_core.formats.contours.contents import CollectedContours, PlaneInfo
from cpm_core.formats.contours.curves import CURVE_TOLERANCE
from cpm_core.numerics.packages import require_package
from cpm_core.numerics.types import Array

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.entities.dxfgfx import DXFGraphic

_DXF_RELEASE = "R2007"
"""First release of the format whose names may hold any letters (UTF-8)."""

_LAYER_COLORS = {"CLOSED": 4, "OPEN": 30}
"""Layers of contours without a name -> numbers of their colors."""

_DEFAULT_COLOR_NUMBER = 7
"""Number of the usual color: black or white."""

_COLOR_BY_LAYER = (0, 256)
"""Color numbers of entities that have the color of their block or layer."""

_SHAPE_COMMENT = "image_shape"
"""Name of the comment with the numbers of rows and columns of the image."""

_SPACING_COMMENT = "pixel_size"
"""Name of the comment with the size of a pixel along rows and columns."""

_UNIT_NUMBERS = {"nm": 12, "µm": 13, "mm": 4, "cm": 5, "m": 6}
"""Unit of an image -> its number in the header (``$INSUNITS``)."""

_MAX_LAYER_NAME = 255
"""Longest name of a layer [characters]."""

_MAX_COMMENT_LINE = 250
"""Longest line of a comment [characters]."""

_FORBIDDEN_IN_NAMES = re.compile(r'[<>/\\":;?*|,=`\x00-\x1f]')

_LINE_ENTITIES = ("LINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE", "LWPOLYLINE", "POLYLINE")
"""Entities that become contours."""

_RELATIVE_TOLERANCE = 1e-6
"""Largest distance of the vertices from a large curve, as a fraction of its size; else it is `CURVE_TOLERANCE` px."""


def encode_dxf(result: Outcome) -> bytes:
    """Write each contour as a polyline.

    The drawing is upright: x runs along columns and y upward, from the lower left corner of the image, in the unit of
    the image (``$INSUNITS`` in the header) if the pixel size is known, else in px. Unnamed contours lie on the layers
    CLOSED and OPEN, named ones on a layer of that name, with underscores for forbidden characters; colors belong to
    the entities. A single vertex is a point. Provenance and image are comments at the beginning.
    """
    import ezdxf

    ezdxf.options.write_fixed_meta_data_for_testing = True  # the same result always gives the same bytes
    drawing = ezdxf.new(_DXF_RELEASE)
    drawing.units = _UNIT_NUMBERS.get(result.unit or "", 0)
    model = drawing.modelspace()
    height, width = np.array(result.shape) * result.spacing
    drawing.set_modelspace_vport(height, (0.5 * width, 0.5 * height))
    for contour in result.contours:
        layer = _FORBIDDEN_IN_NAMES.sub("_", contour.name).strip()[:_MAX_LAYER_NAME].strip()
        layer = layer or ("CLOSED" if contour.closed else "OPEN")
        if not drawing.layers.has_entry(layer):
            drawing.layers.add(layer, color=_LAYER_COLORS.get(layer, _DEFAULT_COLOR_NUMBER))
        look = {"layer": layer} | ({"true_color": int(contour.color[1:], 16)} if contour.color else {})
        rows, cols = ((contour.points + 0.5) * result.spacing).T
        places = np.column_stack([cols, height - rows])
        if len(places) == 1:
            model.add_point(places[0].tolist(), look)
        else:
            model.add_lwpolyline(places.tolist(), "xy", close=contour.closed, dxfattribs=look)
    comments = flatten_provenance(describe_provenance(result))
    comments |= {
        _SHAPE_COMMENT: " ".join(map(str, result.shape)),
        _SPACING_COMMENT: " ".join(f"{size:.17g}" for size in result.spacing),
    }
    stream = io.StringIO()
    for name, value in comments.items():
        for line in textwrap.wrap(f"{name}: {value}", _MAX_COMMENT_LINE, subsequent_indent="  "):
            stream.write(f"999\n{line}\n")
    drawing.write(stream)
    return stream.getvalue().encode()


def read_dxf(content: bytes, plane: PlaneInfo) -> CollectedContours:
    """Read contours from the lines of a drawing, whose origin is the lower left corner of the image.

    If header and image both state a unit, lengths are converted to px by the pixel size; otherwise a unit of the
    drawing is 1 px, or one unit of the image. Files of CPM state the image in comments. The layer of a contour is its
    name.
    """
    require_package("ezdxf", "A .dxf file")
    import ezdxf.path
    import ezdxf.recover
    import ezdxf.units
    from ezdxf.enums import InsertUnits

    drawing, _ = ezdxf.recover.read(io.BytesIO(content))
    own = dict(
        re.findall(
            rf"^999\s+({_SHAPE_COMMENT}|{_SPACING_COMMENT}): ([^\r\n]*)", content.decode("latin-1"), re.MULTILINE
        )
    )
    found = CollectedContours()
    shape, spacing, scale = plane.shape, np.ones(2), 1.0
    if own:
        rows, cols = map(int, own[_SHAPE_COMMENT].split())
        found.shape = shape = rows, cols
        spacing = np.array(own[_SPACING_COMMENT].split(), float)
    elif drawing.units and plane.unit is not None:
        units = InsertUnits(drawing.units), InsertUnits(_UNIT_NUMBERS[plane.unit])
        spacing, scale = np.array(plane.spacing), ezdxf.units.conversion_factor(*units)
    elif drawing.units:
        found.notes.append("The drawing has a unit, but the image has no size of a pixel: one unit is taken for 1 px.")
    lines: list[tuple[DXFGraphic, Array, bool]] = []
    for entity in drawing.modelspace():
        closed = False
        if entity.dxftype() == "POINT":
            vertices = [entity.dxf.location]
        elif entity.dxftype() in _LINE_ENTITIES:
            path = ezdxf.path.make_path(entity, level=6)  # subdivisions of splines
            size = max((abs(part) for place in path.control_vertices() for part in place.xyz), default=0.0)
            vertices, closed = (
                list(path.flattening(max(CURVE_TOLERANCE * spacing[1] / scale, _RELATIVE_TOLERANCE * size))),
                path.is_closed,
            )
        else:
            found.omissions[f"entity {entity.dxftype()}"] += 1
            continue
        places = np.array([(place.x, place.y) for place in vertices]).reshape(-1, 2)
        lines.append((entity, places * scale / spacing[::-1], closed))
    if shape is None:
        found.notes.append("The drawing does not state the height of the image: its own is taken.")
    height = shape[0] if shape else max((places[:, 1].max() for _, places, _ in lines if len(places)), default=0.0)
    for entity, places, closed in lines:
        layer = entity.dxf.layer
        name = "" if layer in ("0", *_LAYER_COLORS) else layer
        points = np.column_stack([height - places[:, 1] - 0.5, places[:, 0] - 0.5])
        found.add_contour(points, closed, name=name, color=_find_color(entity, drawing, bool(own)))
    return found


def _find_color(entity: DXFGraphic, drawing: Drawing, own: bool) -> tuple[int, int, int] | None:
    """Find the color of an entity, its own or its layer's; None for the layers of CPM and the usual color."""
    import ezdxf.colors

    rgb, number = entity.rgb, entity.dxf.color
    if rgb is None and number in _COLOR_BY_LAYER and not own and drawing.layers.has_entry(entity.dxf.layer):
        layer = drawing.layers.get(entity.dxf.layer)
        rgb, number = layer.rgb, layer.color
    return (
        ezdxf.colors.aci2rgb(number) if rgb is None and number not in (_DEFAULT_COLOR_NUMBER, *_COLOR_BY_LAYER) else rgb
    )
