"""COCO: closed contours as instances, to train and evaluate learned segmentation."""

from __future__ import annotations

import numpy as np

from cpm_core.contours.result import Result
from cpm_core.formats.contours.appearance import rgb
from cpm_core.formats.json_text import pairs, rounded, text
from cpm_core.medial_axis.skeleton import Skeleton

_CATEGORY = "object"
"""Category of an instance without a name."""


def encode(result: Result | Skeleton) -> bytes:
    """Write an instance for each closed contour, as one polygon with its area and its box.

    Names are categories. Coordinates are x, y in px from the corner of the image. The polygons of this format have no
    holes: a contour in another is an instance of its own, and the outer one covers it; the holes of objects that were
    chosen, and open contours, are left out. ValueError when no contour is closed.
    """
    closed = [contour for contour in result.contours if contour.closed and not contour.hole and len(contour.points) > 2]
    if not closed:
        raise ValueError(
            f"No contour of {result.source} is closed, and a COCO file holds only closed ones: "
            "let it run on, or export to GeoJSON or CSV."
        )
    categories = sorted({contour.name or _CATEGORY for contour in closed})
    instances = []
    for number, contour in enumerate(closed, start=1):
        corners = np.array(pairs(contour.points))
        low, size = corners.min(axis=0), np.ptp(corners, axis=0)
        instances.append(
            {
                "id": number,
                "image_id": 1,
                "category_id": 1 + categories.index(contour.name or _CATEGORY),
                "segmentation": [rounded(corners.ravel())],
                "area": round(contour.area, 4),
                "bbox": rounded(np.concatenate([low, size])),
                "iscrowd": 0,
                "color": list(rgb(contour)),
            }
        )
    rows, cols = result.shape
    return text(
        {
            "info": {"description": f"Contours of {result.source}"},
            "licenses": [],
            "images": [{"id": 1, "file_name": result.source, "width": cols, "height": rows}],
            "categories": [{"id": k, "name": name, "supercategory": ""} for k, name in enumerate(categories, start=1)],
            "annotations": instances,
        }
    )
