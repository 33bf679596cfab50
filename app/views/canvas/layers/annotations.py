"""The layers of the scale bar, and of the letters at the edges that say how an image lies."""

from __future__ import annotations

import pyqtgraph as pg
from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QPainter, QPen

from app.model.display.lengths import bar, shown_in
from app.model.text.language import tr
from app.model.volume.slices import edges_of
from app.session.scene import Scene
from app.views.canvas.items.item import BACKGROUND, INK, MARGIN, Pinned
from app.views.canvas.layers.layer import Layer, Requests, Switch

LONGEST = 160.0
"""Largest length of the bar [px of the screen]; it is never shorter than 2/5 of it."""

_LEAST, _BESIDE = 40.0, 70.0
"""The same in a narrow view, and what is left in half its width for the letter in the middle [px of the screen]."""

_PAD, _TICK, _LETTER_GAP = 9.0, 4.0, 4.0


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
            self.item.show_bar(scaled.label, scaled.pixels / pixel)
            self.item.put(room.bottomLeft() + QPointF(MARGIN, -MARGIN - self.item.size.height()))


class BarItem(Pinned):
    """The bar with its label above it."""

    def __init__(self) -> None:
        super().__init__()
        self.label = ""
        self.length = 0.0

    def show_bar(self, label: str, length: float) -> None:
        """Show a bar, `length` px of the screen long."""
        self.label, self.length = label, length
        metrics = self.metrics()
        width = max(length, metrics.horizontalAdvance(label)) + 2 * _PAD
        self.resize(QSizeF(width, metrics.height() + 2 * _TICK + _PAD))

    def draw(self, painter: QPainter) -> None:
        """Draw bar and label."""
        room = self.boundingRect()
        painter.setPen(QPen(QColor(INK), 2.0, c=Qt.PenCapStyle.FlatCap))
        painter.drawText(room.translated(0.0, 3.0), Qt.AlignmentFlag.AlignHCenter, self.label)
        left = (room.width() - self.length) / 2
        right, y = left + self.length, room.bottom() - _TICK - 4.0
        painter.drawLine(QPointF(left, y), QPointF(right, y))
        for x in (left + 1.0, right - 1.0):
            painter.drawLine(QPointF(x, y - _TICK), QPointF(x, y + _TICK))


class OrientationLayer(Layer):
    """A letter in the middle of each edge: R, L, A, P, S or I where the file tells how the image lies."""

    name = "orientation"
    title = tr("Orientation")
    tip = tr("Which side lies at each edge: right, left, anterior, posterior, superior, inferior; or the axes.")
    in_slices = True

    _EDGES = ((0.5, 0.0), (0.5, 1.0), (0.0, 0.5), (1.0, 0.5))
    """Top, bottom, left and right, as fractions of width and height."""

    def __init__(self, view: pg.ViewBox, requests: Requests) -> None:
        super().__init__(view, requests)
        self.letters: tuple[str, ...] = ("",) * 4
        """What is shown at the top, the bottom, the left and the right."""
        self._letters = [pg.TextItem(color=INK, fill=QColor(BACKGROUND), anchor=edge) for edge in self._EDGES]
        self.pin(*self._letters)
        view.sigResized.connect(self._place)
        self._place()

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
        self.letters = ("",) * 4 if edges is None else (*edges[0], *edges[1])
        room: QRectF = self.view.boundingRect().adjusted(_LETTER_GAP, _LETTER_GAP, -_LETTER_GAP, -_LETTER_GAP)
        for item, text, (x, y) in zip(self._letters, self.letters, self._EDGES, strict=True):
            item.setVisible(bool(text))
            item.setText(text)
            item.setPos(room.left() + x * room.width(), room.top() + y * room.height())
