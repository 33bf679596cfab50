"""Samples of contours as other programs write them: one small sound file for each of what their readers know."""

from __future__ import annotations

import base64
import io
import json
import zipfile
from typing import Any

import ezdxf
import numpy as np
from ezdxf.document import Drawing
from pycocotools import mask as coco_mask
from roifile import ROI_TYPE, ImagejRoi

from .encoders import Sample, picture

_DISK = np.hypot(*np.mgrid[-5:6, -7:7]) < 4.5
_DISK[5:7, 6:9] = False
_RING = [[1.0, 1.0], [9.0, 1.0], [9.0, 8.0], [1.0, 8.0], [1.0, 1.0]]
_INNER = [[3.0, 3.0], [3.0, 6.0], [6.0, 6.0], [6.0, 3.0], [3.0, 3.0]]


def _selections() -> list[Sample]:
    """Selections of ImageJ, one by one and as a set."""
    box = {"left": 2, "top": 3, "right": 9, "bottom": 8}
    places = np.array([[1.5, 2.0], [9.0, 3.0], [7.25, 8.0], [2.0, 6.0]])
    kinds = (ROI_TYPE.POLYGON, ROI_TYPE.FREEHAND, ROI_TYPE.POLYLINE, ROI_TYPE.POINT, ROI_TYPE.ANGLE)
    made = [
        *(ImagejRoi(version=228, roitype=kind, name=kind.name, **box) for kind in (ROI_TYPE.RECT, ROI_TYPE.OVAL)),
        ImagejRoi(version=228, roitype=ROI_TYPE.LINE, x1=3.0, y1=4.0, x2=6.0, y2=8.0),
        *(ImagejRoi.frompoints(places, name="a") for _ in kinds),
    ]
    for selection, kind in zip(made[3:], kinds, strict=True):
        selection.roitype = kind
    contents = [selection.tobytes() for selection in made]
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for number, content in enumerate(contents):
            archive.writestr(zipfile.ZipInfo(f"{number:04d}.roi"), content)
    return [*(Sample(".roi", content) for content in contents), Sample(".zip", stream.getvalue())]


def _annotations() -> list[Sample]:
    """Annotations of QuPath, labelme and COCO."""
    properties = {"objectType": "annotation", "classification": {"name": "cell", "color": [200, 0, 0]}, "name": "a"}
    geometries = [
        {"type": "Polygon", "coordinates": [_RING, _INNER]},
        {"type": "MultiPolygon", "coordinates": [[_RING, _INNER], [_INNER]]},
        {"type": "LineString", "coordinates": _RING[:3]},
        {"type": "MultiLineString", "coordinates": [_RING[:3], _INNER[:2]]},
        {"type": "MultiPoint", "coordinates": _RING},
    ]
    geometries.append({"type": "GeometryCollection", "geometries": list(geometries)})
    features: list[Any] = [{"type": "Feature", "geometry": one, "properties": properties} for one in geometries]
    return [
        Sample(".geojson", _json({"type": "FeatureCollection", "features": features})),
        Sample(".geojson", _json(features)),
        Sample(".json", _json(_labelme())),
        *(Sample(".json", _json(_coco(compressed))) for compressed in (True, False)),
    ]


def _labelme() -> dict[str, Any]:
    mask = base64.b64encode(picture(_DISK.astype(np.uint8) * 255, "PNG")).decode()
    corners: dict[str, Any] = {
        "polygon": _RING[:4],
        "rectangle": _RING[:3:2],
        "oriented_rectangle": _RING[:4],
        "circle": _RING[:2],
        "line": _RING[:2],
        "linestrip": _RING[:3],
        "point": _RING[:1],
        "points": _RING[:2],
        "mask": [[0.0, 0.0], [14.0, 11.0]],
    }
    shapes = [
        {"label": kind, "points": points, "group_id": 4, "shape_type": kind, "flags": {}, "mask": mask}
        for kind, points in corners.items()
    ]
    return {"version": "6.3.1", "flags": {}, "shapes": shapes, "imageHeight": 11, "imageWidth": 14, "imageData": mask}


def _coco(compressed: bool) -> dict[str, Any]:
    packed: dict[str, Any] = {"size": list(_DISK.shape)}
    if compressed:
        packed["counts"] = coco_mask.encode(np.asfortranarray(_DISK.astype(np.uint8)))["counts"].decode()
    else:
        flat = _DISK.T.ravel()
        bounds = np.flatnonzero(np.diff(flat, prepend=False, append=False))
        packed["counts"] = np.diff([0, *bounds, flat.size]).tolist()
    flat_ring = [coordinate for place in _RING for coordinate in place]
    annotations = [
        {"id": number, "image_id": 7, "category_id": 3, "segmentation": given, "iscrowd": 0}
        for number, given in enumerate((packed, [flat_ring]))
    ]
    images = [{"id": 7, "file_name": "a.png", "height": 11, "width": 14}]
    return {"images": images, "categories": [{"id": 3, "name": "cell"}], "annotations": annotations}


def _drawings() -> list[Sample]:
    """Drawings: SVG with all shapes and commands of paths, DXF of several versions."""
    path = "M1 1 L9 1 V8 h-8 z m2 2 q1 1 2 2 t3 1 c1 1 2 1 3 0 s1 -1 2 0 a4 3 20 0 1 2 2 Z"
    body = (
        f'<path d="{path}" fill="none" stroke="red"/><g transform="translate(1,2) scale(2) rotate(30 5 5)">'
        '<rect x="1" y="2" width="4" height="3" rx="1"/><circle cx="5" cy="5" r="3" style="stroke:#00ff00"/></g>'
        '<ellipse cx="6" cy="5" rx="4" ry="2" transform="matrix(1 0 .2 1 0 0) skewX(3)"/>'
        '<line x1="1" y1="1" x2="9" y2="8"/><polyline points="1,1 2,2 3,1"/>'
        '<polygon points="1 1 9 1 9 8"><title>a</title></polygon><text x="1" y="2">a</text>'
        '<defs><rect id="b" width="9" height="9"/></defs><use href="#b" x="1"/>'
    )
    attributes = 'xmlns="http://www.w3.org/2000/svg" viewBox="0 0 14 11" width="14mm" height="11mm"'
    return [
        Sample(".svg", f"<svg {attributes}>{body}</svg>".encode()),
        *(Sample(".dxf", _cad(version)) for version in ("R12", "R2000", "R2018")),
    ]


def _cad(version: str) -> bytes:
    document: Drawing = ezdxf.new(version)
    space, corners = document.modelspace(), [(1.0, 1.0), (9.0, 1.0), (9.0, 8.0), (1.0, 8.0)]
    space.add_line(*corners[:2])
    space.add_polyline2d(corners, close=True)
    space.add_circle((5.0, 5.0), 3.0)
    space.add_arc((5.0, 5.0), 3.0, 20.0, 200.0)
    space.add_point((2.0, 2.0))
    space.add_text("a")
    block = document.blocks.new("B")
    block.add_circle((1.0, 1.0), 0.5)
    space.add_blockref("B", (3.0, 3.0), {"rotation": 30.0, "xscale": 2.0})
    if version != "R12":
        document.units = 13
        space.add_lwpolyline([(*corner, 0.0, 0.0, 0.3) for corner in corners], close=True)
        space.add_ellipse((5.0, 5.0), (3.0, 1.0), 0.5)
        space.add_spline(corners)
        space.add_rational_spline([(*corner, 0.0) for corner in corners], [1.0, 2.0, 1.0, 0.5])
        hatch = space.add_hatch()
        hatch.paths.add_polyline_path(corners)
    stream, fixed = io.StringIO(), ezdxf.options.write_fixed_meta_data_for_testing
    ezdxf.options.write_fixed_meta_data_for_testing = True  # no time in the file
    try:
        document.write(stream)
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = fixed
    return stream.getvalue().encode(document.output_encoding)


def _json(plain: Any) -> bytes:
    return json.dumps(plain).encode()


def contours_of_others() -> list[Sample]:
    """The samples."""
    return [*_selections(), *_annotations(), *_drawings()]
