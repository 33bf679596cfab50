"""The layer of the trails: the latest positions of particles."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pyqtgraph as pg
from pyqtgraph.Qt import internals
from PySide6.QtCore import QLineF
from PySide6.QtGui import QColor, QPainter, QPen
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from app.model.display.trails import Trails
from app.model.text.language import tr
from app.session.scene import Scene
from app.views.canvas.items.item import OverImage
from app.views.canvas.layers.layer import Layer, Requests
from app.views.canvas.layers.options import Amount
from app.views.theme import theme
from cpm_core.numerics.types import Array

_Z = 2.9
_LENGTH = 20.0
_BANDS = 4
"""Number of opacities of a trail; each needs one call of the painter."""

_MOST = 24_000
"""Largest number of lines in a frame; beyond it the trails are shorter."""

_RIM = 16.0


class TrailLayer(Layer):
    """Lines along the latest positions of each particle; older ones are fainter."""

    name = "trails"
    title = tr("Trails")
    tip = tr("The latest positions of each particle.")
    shortcut = "Alt+2"
    initially = False
    in_slices = True
    colors = (theme.TRAIL,)
    options = (Amount("length", tr("Length"), 2, 100, 1, _LENGTH, tr("Number of moments that a trail shows.")),)

    def __init__(self, view: pg.ViewBox, requests: Requests) -> None:
        super().__init__(view, requests)
        self.trails = Trails(int(_LENGTH))
        self._item = Segments(theme.TRAIL, _Z)
        self.add(self._item)
        self._item.setVisible(False)

    def show_or_hide(self) -> None:
        """Store positions only while the layer is shown."""
        super().show_or_hide()
        if not self.shown:
            self.trails.forget()
            self._item.show(())

    def follow_choice(self, name: str) -> None:
        """Change the length."""
        self.trails.keep(int(self.number("length")))
        self._item.show(self.trails)

    def follow(self, before: Scene) -> None:
        """Add the newest positions."""
        snapshot = self.scene.snapshot
        if snapshot is before.snapshot:
            return
        now, then = self.scene.slices, before.slices
        if snapshot is None or (now is not None and then is not None and now.current != then.current):
            self.trails.forget()  # those of another slice are not seen in this one
        if snapshot is not None and self.shown:
            near, identity = self.scene.near, snapshot.state.particles.identity
            self.trails.add(snapshot.state.step, identity if near is None else identity[near.index], snapshot.position)
        if self.shown:
            self._item.show(self.trails)


class Segments(OverImage):
    """Many short lines of one color in bands of decreasing opacity."""

    def __init__(self, color: str, z: float) -> None:
        super().__init__(z, _RIM)
        self._color = color
        self._bands: list[Array] = []
        self._lines = internals.PrimitiveArray(QLineF, 4)

    def show(self, newest_first: Iterable[Array]) -> None:
        """Show pairs of positions, each of shape (M, 2, 2), newest first."""
        pieces: list[Array] = []
        room = _MOST
        for pairs in newest_first:
            if len(pairs) > room and pieces:
                break
            pieces.append(pairs[:: len(pairs) // _MOST + 1])
            room -= len(pairs)
        bands = np.array_split(np.arange(len(pieces)), _BANDS)
        self._bands = [np.concatenate([pieces[i] for i in band]) for band in bands if len(band)]
        self.update()

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Draw the oldest first."""
        transform = painter.worldTransform()
        painter.save()
        painter.resetTransform()
        # A thousand lines look better with antialiasing; for ten thousand it would take several frames.
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, sum(map(len, self._bands)) < _MOST // 10)
        color = QColor(self._color)
        for age in range(len(self._bands) - 1, -1, -1):
            pairs = self._bands[age]
            if not len(pairs):
                continue
            self._lines.resize(len(pairs))
            table = self._lines.ndarray()
            for end in (0, 1):
                table[:, 2 * end] = transform.dx() + pairs[:, end, 1] * transform.m11()
                table[:, 2 * end + 1] = transform.dy() + pairs[:, end, 0] * transform.m22()
            color.setAlphaF(0.85 * (1.0 - age / _BANDS) + 0.1)
            painter.setPen(QPen(color, 1.0))
            painter.drawLines(*self._lines.drawargs())
        painter.restore()
