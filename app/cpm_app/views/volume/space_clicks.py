"""Clicks in the view in space: drawing and selecting at the clicked place."""

from __future__ import annotations

from functools import partial

import numpy as np
from PySide6.QtGui import QGuiApplication

from cpm_app.model.space.camera import Camera
from cpm_app.session.features.object_selection import ObjectSelection
from cpm_app.session.session import Session
from cpm_app.views.tools.tool import REMOVE_MODIFIER, draw_shape
from cpm_core import VolumePartition
from cpm_core.numerics import Place
from cpm_core.numerics.types import Sides
from cpm_core.objects.segmented import Click
from cpm_core.shapes import Points, Shape, Sphere

_NEW_SPHERE_FRACTION = 0.03
"""Radius of a new sphere, as a fraction of the shortest side of the volume."""

_MIN_NEW_RADIUS = 2.0
"""Minimum radius of a new sphere [smallest side of a voxel]."""

_INSIDE_DEPTHS = (0.5, 1.0, 1.5, 2.0, 3.0)
"""Depths behind a visible surface that are searched for its inside [smallest side of a voxel]."""


def draw_shape_at(session: Session, tool: str, at: Place) -> None:
    """Draw the shape of a tool at a place of the volume, if the tool needs no slice to draw in."""
    image = session.image
    if image is None or image.ndim != 3 or tool not in ("circle", "points"):
        return
    shape: Shape = Points((at,))
    if tool == "circle":
        shortest = min(n * side for n, side in zip(image.shape, image.spacing, strict=True)) / min(image.spacing)
        shape = Sphere.from_voxel_size(at, max(_NEW_SPHERE_FRACTION * shortest, _MIN_NEW_RADIUS), image.spacing)
    draw_shape(session, shape)


def select_body_at(selection: ObjectSelection, camera: Camera, spacing: Sides, at: Place) -> None:
    """Add a positive point, with Shift a negative one, inside the body behind a clicked place.

    If no body lies behind it, add the place itself.
    """
    partition = selection.partition_updater.partition
    way = min(spacing) * camera.axes[2] / np.array(spacing)
    places = np.array(at) + np.outer((0.0, *_INSIDE_DEPTHS), way)
    within = (
        partition.find_body_numbers(places) > 0 if isinstance(partition, VolumePartition) else np.zeros(len(places))
    )
    place = places[1 + int(np.argmax(within[1:]))] if np.any(within[1:]) else places[0]
    inside = not QGuiApplication.keyboardModifiers() & REMOVE_MODIFIER
    click = Click((tuple(place.tolist()),), inside)
    selection.do_in_order(partial(selection.add_click, click), click, needs_answer=not selection.selecting)
