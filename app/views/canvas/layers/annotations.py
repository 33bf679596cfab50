"""The layers of the scale bar, and of the letters at the edges that say how an image lies."""

from __future__ import annotations

import pyqtgraph as pg
from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QPainter, QPen

from app.model.display.lengths import bar, shown_in
from app.model.text.language import tr
from app.model.volume.slices import edges_of
from app.session.scene import Scene
from app.views.canvas.items.item import INK, MARGIN, Pinned
from app.views.canvas.layers.layer import Layer, Requests, Switch
from cpm_core.image.drawing import Bar

LONGEST = 160.0
"""Largest length of the bar [px of the screen]; it is never shorter than 2/5 of it."""

_LEAST, _BESIDE = 40.0, 70.0
"""The same in a narrow view, and what is left in half its width for the letter in the middle [px of the screen]."""

_PAD, _TICK = 9.0, 4.0


class ScaleBarLayer(Layer):
    """A bar of round length in the unit of the image; for an image without a unit it is optional."""

    name = "scale_bar"
    title = tr("Scale bar")
    tip = tr("A bar of round length, when the size of a pixel is known.")
    shortcut = "Alt+Shift+0"
    in_slices = True
    options = (
        Switch("pixels", tr("In px when the size of a pixel is not known"), False, tr("Show the bar for any image.")),
    )

    def __init__(self, view: pg.ViewBox, requests: Requests) -> None:
        super().__init__(view, requests)
        self.item = BarItem()
        self.pin(self.item)
        view.sigRangeChanged.connect(self._fit)
        view.sigResized.connect(self._fit)

    def show_or_hide(self) -> None:
        """Show the bar where the size of a pixel is known, or on request."""
        self._fit()

    def follow_choice(self, name: str) -> None:
        """Show the bar in px, or hide it."""
        self._fit()

    def follow(self, before: Scene) -> None:
        """Measure another image."""
        if self.scene.image is not before.image:
            self._fit()

    def _fit(self, *_: object) -> None:
        image = self.scene.image
        shown = self.shown and image is not None and (image.unit is not None or bool(self.chosen["pixels"]))
        self.item.setVisible(shown)
        if shown and image is not None:
            pixel = float(self.view.viewPixelSize()[0])
            size = shown_in(image.spacing, image.unit)
            room = self.view.boundingRect()
            longest = min(LONGEST, max(0.5 * room.width() - _BESIDE, _LEAST))
            scaled = bar(longest * pixel, size.spacing[1], size.unit)
            self.item.show_bar(scaled, scaled.pixels / pixel)
            self.item.put(room.bottomLeft() + QPointF(MARGIN, -MARGIN - self.item.size.height()))


class BarItem(Pinned):
    """The bar with its label above it."""

    def __init__(self) -> None:
        super().__init__()
        self.label = ""
        self.length = 0.0

    def show_bar(self, bar: Bar, length: float) -> None:
        """Show a bar, `length` px of the screen long."""
        if (bar.label, length) != (self.label, self.length):
            self.label, self.length = bar.label, length
            metrics = self.metrics()
            width = max(length, metrics.horizontalAdvance(bar.label)) + 2 * _PAD
            self.resize(QSizeF(width, metrics.height() + 2 * _TICK + _PAD))

    def draw(self, painter: QPainter) -> None:
        """Draw bar and label."""
        line = self.metrics().height()
        room = self.boundingRect()
        painter.setPen(QColor(INK))
        painter.drawText(QRectF(0.0, 3.0, room.width(), line), Qt.AlignmentFlag.AlignHCenter, self.label)
        left = (room.width() - self.length) / 2
        right, y = left + self.length, room.bottom() - _TICK - 4.0
        pen = QPen(QColor(INK), 2.0)
        pen.setCapStyle(Qt.PenCapStyle.FlatCap)
        painter.setPen(pen)
        painter.drawLine(QPointF(left, y), QPointF(right, y))
        for x in (left + 1.0, right - 1.0):
            painter.drawLine(QPointF(x, y - _TICK), QPointF(x, y + _TICK))


_LETTER_GAP = 4.0
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
            left, top = (
                x * free.width() + _LETTER_GAP * (1.0 - 2.0 * x),
                y * free.height() + _LETTER_GAP * (1.0 - 2.0 * y),
            )
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
