"""The hand in the view in space: shapes are taken by their lines and dragged in the plane of the screen."""

from __future__ import annotations

import itertools

import numpy as np
from PySide6.QtCore import QEvent, QObject, QPointF, Qt
from PySide6.QtGui import QGuiApplication, QMouseEvent

from app.model.document import edits
from app.model.text.language import from_core, tr
from app.model.volume.shape_sections import wires
from app.session.features.object_selection import ObjectSelection
from app.session.session import Session
from app.views.canvas.tools.tool import TAKING_AWAY
from app.views.volume.space_view import SpaceView
from cpm_core.image.image import Image
from cpm_core.numerics.segments import distances_to_segments
from cpm_core.numerics.types import Place
from cpm_core.objects.faces.space import VolumePartition
from cpm_core.shapes import Points, Shape, Sphere

REACH = 6.0
"""Distance from a line of a shape within which the pointer takes hold of it [px of the screen]."""

_SMALL, _LEAST = 0.03, 2.0
"""Radius of a new sphere, as a fraction of the shortest side of the volume, and at least [sides of a voxel]."""

_BEHIND = (0.5, 1.0, 1.5, 2.0, 3.0)
"""How far behind what is seen the inside of it is looked for [smallest sides of a voxel]."""

_gestures = itertools.count()


class SpaceHand(QObject):
    """Takes the left button from the view where the line of a shape lies under it, and draws where it is clicked."""

    def __init__(self, session: Session, view: SpaceView) -> None:
        super().__init__(view)
        self._session = session
        self._view = view
        self._held: Shape | None = None
        self._index = 0
        self._from = QPointF()
        self._gesture = ""
        view.setMouseTracking(True)
        view.installEventFilter(self)

    def put(self, tool: str, at: Place) -> None:
        """Draw what a tool draws at a place of the volume; most tools need a slice to draw in."""
        image = self._session.image
        if image is None or image.ndim != 3 or tool not in ("circle", "points"):
            return
        if tool == "points":
            shape: Shape = Points((at,))
            name = tr("place point")
        else:
            shortest = min(n * side for n, side in zip(image.shape, image.spacing, strict=True)) / min(image.spacing)
            shape, name = Sphere.round(at, max(_SMALL * shortest, _LEAST), image.spacing), tr("draw sphere")
        self._session.edit(name, lambda document: edits.add_shape(document, shape))
        self._session.select(len(self._session.document.shapes) - 1)

    def select(self, selection: ObjectSelection, at: Place) -> None:
        """Say that the body behind a place on something seen belongs to the object; with Shift, not.

        Where none lies behind it, the place itself is meant.
        """
        partition, camera, image = selection.partitions.partition, self._view.camera, self._session.image
        if camera is None or image is None:
            return
        way = min(image.spacing) * camera.axes[2] / np.array(image.spacing)
        places = np.array(at) + np.outer((0.0, *_BEHIND), way)
        within = partition.bodies_at(places) > 0 if isinstance(partition, VolumePartition) else np.zeros(len(places))
        place = places[1 + int(np.argmax(within[1:]))] if np.any(within[1:]) else places[0]
        inside = not QGuiApplication.keyboardModifiers() & TAKING_AWAY
        selection.click((tuple(place.tolist()),), inside)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Follow the pointer over the view."""
        if not isinstance(event, QMouseEvent):
            return False
        if event.type() == QEvent.Type.MouseButtonPress:
            return self._press(event)
        if event.type() == QEvent.Type.MouseMove:
            return self._move(event)
        if event.type() == QEvent.Type.MouseButtonRelease and self._held is not None:
            self._held = None
            self._session.seal()
            return True
        return False

    def _press(self, event: QMouseEvent) -> bool:
        found = self._under(event.position())
        plain = event.modifiers() == Qt.KeyboardModifier.NoModifier
        if found is None or event.button() != Qt.MouseButton.LeftButton or not plain:
            return False
        self._index, self._held, self._from = found, self._session.document.shapes[found], event.position()
        self._gesture = f"space {next(_gestures)}"
        self._session.select(found)
        return True

    def _move(self, event: QMouseEvent) -> bool:
        shape, camera, image = self._held, self._view.camera, self._session.image
        if shape is None or camera is None or image is None:
            taken = not event.buttons() and self._under(event.position()) is not None
            self._view.setCursor(Qt.CursorShape.SizeAllCursor if taken else Qt.CursorShape.ArrowCursor)
            return False
        way = (event.position() - self._from) * self._view.devicePixelRatioF()
        by = (way.x() * camera.axes[0] + way.y() * camera.axes[1]) / camera.scale / np.array(image.spacing)
        moved, index = shape.moved(tuple(by.tolist())), self._index
        if index < len(self._session.document.shapes):
            name = tr("move {shape}").format(shape=from_core(shape.title))
            self._session.edit(name, lambda document: edits.replace_shape(document, index, moved), self._gesture)
        return True

    def _under(self, point: QPointF) -> int | None:
        """Number of the shape with a line at a point of the view: the selected one first, then the last drawn."""
        image, shapes = self._session.image, self._session.document.shapes
        if image is None or image.ndim != 3:
            return None
        near = [index for index, shape in enumerate(shapes) if self._away(shape, image, point) <= REACH]
        selected = self._session.selected
        return selected if selected in near else near[-1] if near else None

    def _away(self, shape: Shape, image: Image, point: QPointF) -> float:
        """Distance of a point from the lines of a shape [px of the screen]."""
        camera, ratio = self._view.camera, self._view.devicePixelRatioF()
        ends = wires(shape, tuple(side / min(image.spacing) for side in image.spacing))
        if camera is None or not len(ends):
            return float("inf")
        seen = camera.seen(ends.reshape(-1, 3) * np.array(image.spacing), self._view.room)
        lines = seen[:, :2].astype(float).reshape(-1, 2, 2) / ratio
        here = np.array([point.x(), point.y()])
        return float(distances_to_segments(here, lines[:, 0], lines[:, 1] - lines[:, 0]).min())
