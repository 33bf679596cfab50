"""Where what is selected lies in the image."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QRectF

from app.model.volume.shape_sections import wires
from app.session.features.slices import ShownSlices
from app.session.features.workspace import Workspace
from app.views.canvas.image_view import ImageView
from cpm_core.numerics.types import Array


def selected_places(workspace: Workspace) -> list[Array]:
    """Positions of the selected contours, else of the chosen objects, else of the selected shape.

    They are (row, col) in an image; those of a shape in a volume are (plane, row, col).
    """
    session = workspace.session
    found = [item.contour.points for item in workspace.review.chosen]
    found = found or [np.array(curve) for item in workspace.object_list.items for curve in item.boundary]
    found = found or [item.body.vertices for item in workspace.object_list.items if item.body is not None]
    if not found and session.selected is not None:
        shape = session.document.shapes[session.selected]
        volume = session.image if session.scene.slices is not None else None
        if volume is not None:
            sides = tuple(side / min(volume.spacing) for side in volume.spacing)
            return [places for places in [wires(shape, sides).reshape(-1, 3)] if len(places)]
        found = [shape.outline if shape.outline.size else np.array(shape.handles(), dtype=float).reshape(-1, 2)]
    return [places for places in found if len(places)]


def part_around(places: Array, canvas: ImageView, slices: ShownSlices) -> QRectF:
    """The part of the image around places; in a volume, in the slice through their middle, which is shown."""
    if places.shape[1] == 3:
        slices.through(tuple((0.5 * (places.min(axis=0) + places.max(axis=0))).tolist()))
        places = places if canvas.here is None else canvas.here.flattened(places)
    (top, left), (bottom, right) = places.min(axis=0), places.max(axis=0)
    return QRectF(left, top, right - left, bottom - top)
