"""The magnifier: a round lens at the pointer that shows image, contours and drafts four times as large."""

from __future__ import annotations

from PySide6.QtCore import QObject, QPoint, QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QCursor, QPainter, QPaintEvent, QPen, QRegion
from PySide6.QtWidgets import QWidget

from app.model.text.language import tr, written
from app.session.scene import Scene
from app.views.canvas.canvas import Canvas
from app.views.canvas.mirrors.mirror import Mirror
from app.views.theme import theme
from cpm_core.numerics.types import Position

FACTOR = 4.0
"""How much larger the lens shows than the canvas."""

_SIDE = 208
"""Diameter of the lens [px]."""

_ARM, _GAP = 14.0, 4.0
"""Distances from its center at which the lines of the cross end and begin [px]."""


class Magnifier(QObject):
    """Follows the pointer over a canvas, and the cross-hair that keys move."""

    def __init__(self, canvas: Canvas) -> None:
        super().__init__(canvas)
        self._canvas = canvas
        self._at: Position | None = None
        self._scene = Scene()
        self._mirror: Mirror | None = None
        self.lens = _Lens(canvas)
        canvas.pointed.connect(self._point)
        canvas.view.sigRangeChanged.connect(self._place)

    @property
    def shown(self) -> bool:
        """Whether it is switched on."""
        return self._mirror is not None

    @property
    def mirror(self) -> Mirror | None:
        """What is seen through it; None while it is switched off."""
        return self._mirror

    def switch(self, shown: bool) -> None:
        """Switch it on or off."""
        if shown == self.shown or self._canvas.shape is None:
            return
        if not shown and self._mirror is not None:
            self.lens.hide()
            self._mirror.deleteLater()
            self._mirror = None
            return
        self._mirror = Mirror(self._canvas, self.lens)
        self._mirror.setGeometry(0, 0, _SIDE, _SIDE)
        self._mirror.lower()
        self._mirror.show()
        self.draw(self._scene)
        if self._at is None:
            inside = self._canvas.mapFromGlobal(QCursor.pos())
            under = self._canvas.rect().contains(inside)
            self._at = self._canvas.position((inside if under else self._canvas.rect().center()).toPointF())
        self._place()

    def draw(self, scene: Scene) -> None:
        """Draw another scene."""
        self._scene = scene
        if self._mirror is not None:
            self._mirror.draw(scene)

    def _point(self, at: Position | None) -> None:
        self._at = at
        self._place()

    def _place(self, *_: object) -> None:
        mirror, at = self._mirror, self._at
        if mirror is None:
            return
        self.lens.setVisible(at is not None)
        if at is None:
            return
        center = self._canvas.point(at)
        self.lens.move(center.toPoint() - QPoint(_SIDE // 2, _SIDE // 2))
        span = _SIDE * float(self._canvas.view.viewPixelSize()[0]) / FACTOR
        mirror.view.setRange(QRectF(at[1] - span / 2, at[0] - span / 2, span, span), padding=0.0)
        self._canvas.layers.drawing.copy_draft(mirror.layers.drawing)
        self.lens.show_place(at)


class _Lens(QWidget):
    """A round window with a cross and the place under it."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.resize(_SIDE, _SIDE)
        self.setMask(QRegion(0, 0, _SIDE, _SIDE, QRegion.RegionType.Ellipse))
        self._rim = _Rim(self)
        self._rim.resize(_SIDE, _SIDE)
        self.hide()

    @property
    def text(self) -> str:
        """The place that is shown."""
        return self._rim.text

    def show_place(self, at: Position) -> None:
        """Show a place (row, col)."""
        self._rim.text = tr("{row}, {col}").format(row=written(f"{at[0]:.2f}"), col=written(f"{at[1]:.2f}"))
        self._rim.raise_()
        self._rim.update()


class _Rim(QWidget):
    """Rim, cross and place, over what is seen through the lens."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.text = ""

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw them."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle = QPointF(self.width() / 2, self.height() / 2)
        for color, width in ((theme.HALO, 3.4), (theme.CHOSEN, 1.4)):
            painter.setPen(QPen(QColor(color), width))
            for across in (QPointF(1, 0), QPointF(-1, 0), QPointF(0, 1), QPointF(0, -1)):
                painter.drawLine(middle + across * _GAP, middle + across * _ARM)
        room = QRectF(0.0, self.height() - 40.0, float(self.width()), 18.0)
        wide = painter.fontMetrics().horizontalAdvance(self.text) + 14.0
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(16, 18, 22, 205))
        painter.drawRoundedRect(QRectF(middle.x() - wide / 2, room.top(), wide, room.height()), 5.0, 5.0)
        painter.setPen(QColor("#f2f4f7"))
        painter.drawText(room, int(Qt.AlignmentFlag.AlignCenter), self.text)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for color, width in ((theme.HALO, 5.0), (theme.CHOSEN, 2.0)):
            painter.setPen(QPen(QColor(color), width))
            painter.drawEllipse(QRectF(self.rect()).adjusted(2.0, 2.0, -2.0, -2.0))
        painter.end()
