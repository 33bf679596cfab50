"""The layer of the forces on the particle under the pointer."""

from __future__ import annotations

import math

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QPainter, QPainterPath, QPen

from app.model.text.language import tr, written
from app.session.scene import Scene
from app.session.worker.requests import Probe, Probed
from app.views.canvas.items.item import FAINT, INK, Pinned
from app.views.canvas.layers.layer import Amount, Layer, Requests
from app.views.theme import theme
from cpm_core.numerics.types import Array, Position

KINDS = {
    "coulomb": (tr("Coulomb"), theme.COULOMB),
    "lorentz": (tr("Lorentz"), theme.LORENTZ),
    "placed": (tr("Placed charges"), theme.REGION),
    "friction": (tr("Friction"), theme.JUNCTION),
    "damping": (tr("Damping"), theme.DAMPING),
    "total": (tr("Total"), theme.CHOSEN),
}
"""Names and colors of the forces, in the order of the legend."""

_ALWAYS = ("coulomb", "lorentz", "damping", "total")
"""Forces that are listed even where they are zero."""

_REACH = 24.0
"""Largest distance of the particle from the pointer [px of the screen]."""

_NOTHING = 5e-4
"""Force below which none is shown."""

_WEAK = 0.2
"""Force from which the longest arrow has its full length; where all forces are weaker, all arrows are shorter."""

_PAD, _OFF, _SWATCH = 8.0, 18.0, 10.0


class ForceLayer(Layer):
    """Arrows for all forces on one particle, and a legend with their names and magnitudes.

    The particle is the one nearest to the pointer or, without a pointer, to the center of the visible part.
    """

    name = "forces"
    title = tr("Forces under the pointer")
    tip = tr("Coulomb, Lorentz and damping force on the particle nearest to the pointer.")
    shortcut = "Alt+3"
    initially = False
    in_slices = True
    colors = (theme.COULOMB, theme.LORENTZ, theme.DAMPING)
    options = (Amount("length", tr("Length"), 20, 200, 5, 80, tr("Length of the longest arrow, in px of the screen.")),)

    def __init__(self, view: pg.ViewBox, requests: Requests) -> None:
        super().__init__(view, requests)
        self.item = ForceItem()
        self.pin(self.item)
        self.probed: Probed | None = None
        """The forces shown."""
        self._place: Position | None = None
        self._asked = False
        self._again = False
        view.sigRangeChanged.connect(self._move)
        view.sigResized.connect(self._move)

    def point_at(self, place: Position | None) -> None:
        """Set the position (row, col) of the pointer, None when it has left."""
        self._place = place
        self._ask()

    def show_or_hide(self) -> None:
        """Request forces only while the layer is shown."""
        self._use(None)
        self._ask()

    def follow_choice(self, name: str) -> None:
        """Change the length of the arrows."""
        self._move()

    def follow(self, before: Scene) -> None:
        """Show the forces that were requested; request them again when the particles have moved."""
        snapshot, probed = self.scene.snapshot, self.scene.probed
        if snapshot is not before.snapshot:
            if snapshot is None:
                self._use(None)
            self._ask()
        if probed is not None and probed is not before.probed:
            self._asked = False
            if self.shown and snapshot is not None and probed.generation == snapshot.generation:
                self._use(probed if probed.identity >= 0 else None)
            if self._again:
                self._ask()

    def _ask(self) -> None:
        """Request the forces; while an answer is pending, the next request waits for it."""
        snapshot = self.scene.snapshot
        if not self.shown or snapshot is None:
            return
        if self._asked:
            self._again = True
            return
        self._asked, self._again = True, False
        seen = self.view.viewRect().center()
        place = self._place if self._place is not None else (seen.y(), seen.x())
        reach = _REACH * self._pixel() if self._place is not None else math.inf
        here = None if self.scene.slices is None else self.scene.slices.current
        self.requests.post(Probe(snapshot.generation, place if here is None else here.lifted(place), reach))

    def _use(self, probed: Probed | None) -> None:
        self.probed = probed
        self._move()

    def _move(self, *_: object) -> None:
        probed = self.probed if self.shown else None
        self.item.setVisible(probed is not None)
        if probed is not None:
            at = self.view.mapFromView(QPointF(probed.position[1], probed.position[0]))
            self.item.show_forces(at, probed, self.number("length"), QSizeF(self.view.boundingRect().size()))

    def _pixel(self) -> float:
        return float(self.view.viewPixelSize()[0])


class ForceItem(Pinned):
    """A ring around the particle, arrows from it, and a legend beside it that stays on the canvas."""

    def __init__(self) -> None:
        super().__init__()
        self.setCacheMode(pg.QtWidgets.QGraphicsItem.CacheMode.NoCache)
        self._at = QPointF()
        self._arrows: dict[str, Array] = {}
        self._legend = QRectF()
        self.lines: list[tuple[str, str, str]] = []
        self._title = ""

    def show_forces(self, at: QPointF, probed: Probed, length: float, room: QSizeF) -> None:
        """Show forces on a particle at a point of a canvas of size `room`; the longest arrow is `length` px long."""
        sizes = {name: probed.size(name) for name in KINDS}
        listed = [name for name in KINDS if name in _ALWAYS or sizes[name] >= _NOTHING]
        self.lines = [(*KINDS[name], written(f"{sizes[name]:.3f}")) for name in listed]
        self._title = tr("Particle {number}").format(number=written(f"{probed.identity:,}"))
        longest = max(_WEAK, *sizes.values())
        self._arrows = {name: length / longest * probed.forces[name] for name in listed if sizes[name] >= _NOTHING}
        self._at = at
        metrics = self.metrics()
        names = max(metrics.horizontalAdvance(name) for name, _, _ in self.lines)
        width = max(
            names + _SWATCH + 2 * _PAD + metrics.horizontalAdvance("00.000") + 12.0,
            metrics.horizontalAdvance(self._title) + 2 * _PAD,
        )
        height = metrics.height() * (len(self.lines) + 1) + _PAD
        self._legend = self._free_place(QSizeF(width, height), room)
        self.put(QPointF(0.0, 0.0))
        self.resize(room)

    def _free_place(self, size: QSizeF, room: QSizeF) -> QRectF:
        """The place beside the particle where a legend hides least of the arrows and lies on the canvas."""
        fractions = np.linspace(0.1, 1.0, 10)[:, None, None]
        along = fractions * np.array([*self._arrows.values(), np.zeros(2)])
        places = []
        for right, below in ((True, True), (True, False), (False, True), (False, False)):
            x = self._at.x() + (_OFF if right else -_OFF - size.width())
            y = self._at.y() + (_OFF if below else -_OFF - size.height())
            x = min(max(x, 4.0), max(room.width() - size.width() - 4.0, 4.0))
            y = min(max(y, 4.0), max(room.height() - size.height() - 4.0, 4.0))
            row, col = along[..., 0] + self._at.y() - y, along[..., 1] + self._at.x() - x
            hidden = (row > 0) & (row < size.height()) & (col > 0) & (col < size.width())
            places.append((int(hidden.sum()), QRectF(round(x), round(y), size.width(), size.height())))
        return min(places, key=lambda place: place[0])[1]

    def paint(self, painter: QPainter, option: object, widget: object = None) -> None:
        """Draw ring, arrows and legend."""
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for color, width in ((theme.HALO, 3.4), (theme.CHOSEN, 1.4)):
            painter.setPen(QPen(QColor(color), width))
            painter.drawEllipse(self._at, 7.0, 7.0)
        for name, vector in self._arrows.items():
            path = _arrow(self._at, QPointF(vector[1], vector[0]))
            for color, width in ((theme.HALO, 4.6), (KINDS[name][1], 2.2)):
                pen = QPen(QColor(color), width)
                pen.setCapStyle(Qt.PenCapStyle.RoundCap)
                pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
                painter.setPen(pen)
                painter.drawPath(path)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor("#e0101216"))
        painter.drawRoundedRect(self._legend, 5.0, 5.0)
        self.draw(painter)

    def draw(self, painter: QPainter) -> None:
        """Draw the text of the legend."""
        painter.setFont(self.font())
        line = self.metrics().height()
        inner = self._legend.adjusted(_PAD, 0.5 * _PAD, -_PAD, -0.5 * _PAD)
        painter.setPen(QColor(FAINT))
        painter.drawText(
            QRectF(inner.left(), inner.top(), inner.width(), line), Qt.AlignmentFlag.AlignLeft, self._title
        )
        for index, (name, color, figure) in enumerate(self.lines, start=1):
            row = QRectF(inner.left(), inner.top() + index * line, inner.width(), line)
            painter.fillRect(QRectF(row.left(), row.center().y() - 1.5, _SWATCH, 3.0), QColor(color))
            painter.setPen(QColor(INK))
            painter.drawText(row.adjusted(_SWATCH + 6.0, 0, 0, 0), Qt.AlignmentFlag.AlignLeft, name)
            painter.drawText(row, Qt.AlignmentFlag.AlignRight, figure)


def _arrow(start: QPointF, vector: QPointF) -> QPainterPath:
    end = start + vector
    path = QPainterPath(start)
    path.lineTo(end)
    length = math.hypot(vector.x(), vector.y())
    head = min(8.0, 0.5 * length) / max(length, 1e-9)
    along, across = vector * head, QPointF(vector.y(), -vector.x()) * (0.5 * head)
    path.moveTo(end - along + across)
    path.lineTo(end)
    path.lineTo(end - along - across)
    return path
