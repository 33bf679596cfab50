"""The layer of the letters at the edges: which side of a patient lies there, or the names of the axes of a volume."""

from __future__ import annotations

import pyqtgraph as pg
from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QPainter

from app.model.text.language import tr
from app.model.volume.slices import edges_of
from app.session.scene import Scene
from app.views.canvas.items.pinned import INK, Pinned
from app.views.canvas.layers.layer import Layer, Requests

_GAP = 4.0
"""Distance from the border of the canvas [px of the screen]."""


class OrientationLayer(Layer):
    """A letter in the middle of each edge: R, L, A, P, S or I where the file tells how the image lies."""

    name = "orientation"
    title = tr("Orientation")
    tip = tr("Which side lies at each edge: right, left, anterior, posterior, superior, inferior; or the axes.")
    in_slices = True

    def __init__(self, view: pg.ViewBox, requests: Requests) -> None:
        super().__init__(view, requests)
        self.items = tuple(_Letter() for _ in range(4))
        """At the top, the bottom, the left and the right."""
        self.pin(*self.items)
        view.sigResized.connect(self._place)

    @property
    def letters(self) -> tuple[str, ...]:
        """What is shown at the top, the bottom, the left and the right."""
        return tuple(item.text if item.isVisible() else "" for item in self.items)

    def show_or_hide(self) -> None:
        """Show the letters that there are."""
        self._place()

    def follow(self, before: Scene) -> None:
        """Show how another image, or another slice, lies."""
        if self.scene.ground != before.ground:
            self._place()

    def _place(self, *_: object) -> None:
        whole = self.scene.whole
        edges = None if whole is None or not self.shown else edges_of(whole, self.scene.slices)
        texts = ("",) * 4 if edges is None else (*edges[0], *edges[1])
        room = self.view.boundingRect()
        for item, text, (x, y) in zip(self.items, texts, ((0.5, 0.0), (0.5, 1.0), (0.0, 0.5), (1.0, 0.5)), strict=True):
            item.setVisible(bool(text))
            item.show_text(text)
            free = QSizeF(room.width() - item.size.width(), room.height() - item.size.height())
            left, top = x * free.width() + _GAP * (1.0 - 2.0 * x), y * free.height() + _GAP * (1.0 - 2.0 * y)
            item.put(room.topLeft() + QPointF(left, top))


class _Letter(Pinned):
    """A short text."""

    def __init__(self) -> None:
        super().__init__()
        self.text = ""

    def show_text(self, text: str) -> None:
        """Show another text."""
        if text != self.text:
            self.text = text
            metrics = self.metrics()
            self.resize(QSizeF(metrics.horizontalAdvance(text) + 10.0, metrics.height() + 2.0))

    def draw(self, painter: QPainter) -> None:
        """Draw the text."""
        painter.setPen(QColor(INK))
        painter.drawText(QRectF(self.boundingRect()), Qt.AlignmentFlag.AlignCenter, self.text)
