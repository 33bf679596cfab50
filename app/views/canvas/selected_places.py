"""Where what is selected lies in the image."""

from __future__ import annotations

import numpy as np

from app.model.volume.shape_wires import wires
from app.session.workspace import Workspace
from cpm_core.numerics.types import Array


def selected_places(workspace: Workspace) -> list[Array]:
    """Positions of the selected contours, else of the chosen objects, else of the selected shape.

    They are (row, col) in an image; those of a shape in a volume are (plane, row, col).
    """
    session = workspace.session
    found = [item.contour.points for item in workspace.review.chosen]
    found = found or [np.array(curve) for item in workspace.object_list.items for curve in item.boundary]
    if not found and session.selected is not None:
        shape = session.document.shapes[session.selected]
        volume = session.image if session.scene.slices is not None else None
        if volume is not None:
            sides = tuple(side / min(volume.spacing) for side in volume.spacing)
            return [places for places in [wires(shape, sides).reshape(-1, 3)] if len(places)]
        found = [shape.outline if shape.outline.size else np.array(shape.handles(), dtype=float).reshape(-1, 2)]
    return [places for places in found if len(places)]
