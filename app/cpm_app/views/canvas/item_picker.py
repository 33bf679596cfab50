"""Selection of the item at a place of the canvas, and positions of the selected items."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QRectF

from cpm_app.model.volume.shape_sections import build_shape_wires
from cpm_app.model.volume.slices import Slice
from cpm_app.session.features.slices import SliceNavigation, hit_shape
from cpm_app.session.features.workspace import Workspace
from cpm_app.views.canvas.image_view import ImageView
from cpm_core.numerics import Array, Place
from cpm_core.shapes import Charge, relative_sides


class ItemPicker:
    """Finds and selects the item at a place: lines before areas, front to back."""

    def __init__(self, workspace: Workspace) -> None:
        self._session = workspace.session
        self._list = workspace.object_list
        self._selection = workspace.object_selection

    @property
    def selected_kind(self) -> str:
        """Kind of the selection: "charge", "shape", "object" or "image"."""
        shapes, selected = self._session.document.shapes, self._session.selected_shape
        if selected is not None and selected < len(shapes):
            return "charge" if isinstance(shapes[selected], Charge) else "shape"
        return "object" if self._list.selected_keys or self._selection.selecting else "image"

    def select_item_at(self, at: Place, reach: float, here: Slice | None = None) -> str:
        """Select the item at a place unless it already is, and return its kind; `reach` is in px of the image.

        In a volume, `here` is the slice under the pointer.
        """
        if self._selection.selecting:
            return "object"
        shapes = self._session.document.shapes
        found = hit_shape(self._session.scene, at, reach, here)
        near = found is not None and (found.part == "handle" or shapes[found.index].distance_to(at) <= reach)
        key = None if near else self._list.item_at(at, reach)
        if key is None:
            self._session.select_shape(None if found is None else found.index)
            return "image" if found is None else self.selected_kind
        self._session.select_shape(None)
        if key not in self._list.selected_keys:
            self._list.select_items((key,))
        return "object"


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
