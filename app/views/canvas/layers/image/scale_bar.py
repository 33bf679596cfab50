"""The layer of the scale bar."""

from __future__ import annotations

import pyqtgraph as pg
from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QPainter, QPen

from app.model.display.display_image import DisplayImage
from app.model.display.lengths import Bar, bar
from app.model.text.language import tr
from app.session.session import Session
from app.views.canvas.items.pinned import INK, MARGIN, Pinned
from app.views.canvas.layers.layer import Layer
from app.views.canvas.layers.options import Switch
from cpm_core.image.image import Image

LONGEST = 160.0
"""Most that the bar may measure [px of the screen]; it is never shorter than 2/5 of it."""

_PAD, _TICK = 9.0, 4.0


class ScaleBarLayer(Layer):
    """A bar of round length, in the unit of the image; without one it is only shown when asked for."""

    name = "scale_bar"
    title = tr("Scale bar")
    tip = tr("A bar of round length, when the size of a pixel is known.")
    shortcut = "Ctrl+9"
    options = (
        Switch("pixels", tr("In px when the size of a pixel is not known"), False, tr("Show the bar for any image.")),
    )

    def __init__(self, view: pg.ViewBox, session: Session) -> None:
        super().__init__(view, session)
        self._item = BarItem()
        self.pin(self._item)
        self._image: Image | None = None
        session.image_changed.connect(self._use_image)
        view.sigRangeChanged.connect(self._fit)
        view.sigResized.connect(self._fit)

    @property
    def item(self) -> BarItem:
        """What is drawn."""
        return self._item

    def show_or_hide(self) -> None:
        """Show it where there is something to be told."""
        self._fit()

    def follow_choice(self, name: str) -> None:
        """In px or not at all."""
        self._fit()

    def _use_image(self, image: Image, _: DisplayImage) -> None:
        self._image = image
        self._fit()

    def _fit(self, *_: object) -> None:
        image = self._image
        wanted = self.shown and image is not None and (image.unit is not None or bool(self.chosen["pixels"]))
        self._item.setVisible(wanted)
        if wanted and image is not None:
            pixel = float(self.view.viewPixelSize()[0])
            shown = bar(LONGEST * pixel, image.spacing[1], image.unit)
            self._item.show_bar(shown, shown.pixels / pixel)
            room = self.view.boundingRect()
            self._item.put(room.bottomLeft() + QPointF(MARGIN, -MARGIN - self._item.size.height()))


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
        """Draw it."""
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
