"""Positions of the selected items, and the rectangle around them."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QRectF

from cpm_app.model.volume.shape_sections import build_shape_wires
from cpm_app.session.features.slices import SliceNavigation
from cpm_app.session.features.workspace import Workspace
from cpm_app.views.canvas.image_view import ImageView
from cpm_core.numerics import Array
from cpm_core.shapes import relative_sides


def selected_places(workspace: Workspace) -> list[Array]:
    """Return the positions of the selected objects, proposals and contours, else of the selected shape.

    Returns
    -------
    list of ndarray, shape (N, 2) or (N, 3)
        One array for each curve or box: (row, col) in an image, (plane, row, col) in a volume, in pixels.
    """
    session = workspace.session
    items = [row.item for row in workspace.object_list.selected_rows]
    found = [contour.points for contour in workspace.contour_selection.selected_contours]
    found += [path for item in items for path in item.paths]
    found += [np.array(item.region.bounds) for item in items if item.region.ndim == 3]
    if not found and session.selected_shape is not None:
        shape = session.document.shapes[session.selected_shape]
        volume = session.image if session.scene.slices is not None else None
        if volume is not None:
            sides = relative_sides(volume.spacing)
            return [places for places in [build_shape_wires(shape, sides).reshape(-1, 3)] if len(places)]
        found = [shape.outline if shape.outline.size else np.array(shape.handles(), dtype=float).reshape(-1, 2)]
    return [places for places in found if len(places)]


def rectangle_around(places: Array, canvas: ImageView, slices: SliceNavigation) -> QRectF:
    """Return the rectangle around places; in a volume, first show the slices through their middle.

    Parameters
    ----------
    places : ndarray, shape (N, 2) or (N, 3)
        (row, col) in an image or (plane, row, col) in a volume [px].
    canvas : ImageView
        View that will show the rectangle.
    slices : SliceNavigation
        Slices of the volume, moved to the middle of the places.
    """
    if places.shape[1] == 3:
        slices.go_through(tuple((0.5 * (places.min(axis=0) + places.max(axis=0))).tolist()))
        places = places if canvas.shown_slice is None else canvas.shown_slice.project_points(places)
    (top, left), (bottom, right) = places.min(axis=0), places.max(axis=0)
    return QRectF(left, top, right - left, bottom - top)
