"""A view that shows the image with the same layers as a canvas."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QWidget

from app.session.scene import Scene
from app.session.worker.commands import Command
from app.views.canvas.image_view import ImageView


class _NoRequests:
    """Ignores requests: the layers of the canvas have already made them."""

    def post(self, command: Command) -> None:
        """Do nothing."""

    def want_overlay(self, name: str, wanted: bool) -> None:
        """Do nothing."""


class Mirror(ImageView):
    """Follows the settings of all layers of a canvas; the pointer goes through it."""

    def __init__(self, canvas: ImageView, parent: QWidget) -> None:
        super().__init__(_NoRequests())
        self.setParent(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setMinimumSize(1, 1)
        self.setFrameStyle(0)
        self._canvas = canvas
        self._fitted = False
        for layer in canvas.layers:
            # Qt disconnects a method with its view; a function it would keep, and with it the view.
            layer.changed.connect(self._copy)

    def draw(self, scene: Scene) -> None:
        """Draw a scene, with the settings of the canvas where the image is another one."""
        if scene.whole is not self._scene.whole:
            super().draw(Scene(scene.image, scene.display, document=scene.document, slices=scene.slices))
            self._copy()
        super().draw(scene)

    def fit(self) -> None:
        """Do nothing: the place is that of the canvas."""

    def _copy(self) -> None:
        for layer in self._canvas.layers:
            self.layers[layer.name].use_view_state(layer.view_state())
