"""Icons from the SVG files of the program, in the color of the text around them."""

from __future__ import annotations

from functools import cache

from PySide6.QtCore import QByteArray, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QIcon, QPainter, QPixmap
from PySide6.QtSvg import QSvgRenderer

from app.model.text.assets import asset
from app.views.theme.look import look

_SIZES = (16, 20, 24, 32, 40, 48)

RIM = "#858b93"
"""Color around a swatch, which separates any color from a light and from a dark background."""


@cache
def icon(name: str, color: str, faded: str | None = None) -> QIcon:
    """Icon by name, rendered once.

    Parameters
    ----------
    name : str
        Name of the SVG file without its suffix.
    color : str
        Replaces ``currentColor`` in the file.
    faded : str, optional
        The same for the disabled icon.
    """
    source = asset(f"icons/{name}.svg").read_text(encoding="utf-8")
    made = QIcon()
    for mode, tint in ((QIcon.Mode.Normal, color), (QIcon.Mode.Disabled, faded)):
        if tint is not None:
            renderer = QSvgRenderer(QByteArray(source.replace("currentColor", tint).encode()))
            for size in _SIZES:
                made.addPixmap(_pixmap(renderer, size), mode)
    return made


@cache
def program_icon() -> QIcon:
    """Icon of the program itself."""
    renderer = QSvgRenderer(str(asset("icons/cpm.svg")))
    made = QIcon()
    for size in (*_SIZES, 64, 128, 256):
        made.addPixmap(_pixmap(renderer, size))
    return made


def swatch(*colors: str) -> QIcon:
    """Small discs of the given colors side by side, in the look in use, as a legend."""
    return _discs(*(look().color(color) for color in colors))


@cache
def _discs(*colors: str) -> QIcon:
    side = 14
    pixmap = QPixmap(QSize((side + 2) * len(colors), side))
    pixmap.fill(Qt.GlobalColor.transparent)
    painter = QPainter(pixmap)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setPen(QColor(RIM))
    for index, color in enumerate(colors):
        painter.setBrush(QColor(color))
        painter.drawEllipse(QRectF(index * (side + 2) + 1.5, 1.5, side - 3, side - 3))
    painter.end()
    return QIcon(pixmap)


def _pixmap(renderer: QSvgRenderer, size: int) -> QPixmap:
    pixmap = QPixmap(size, size)
    pixmap.fill(Qt.GlobalColor.transparent)
    painter = QPainter(pixmap)
    renderer.render(painter)
    painter.end()
    return pixmap.copy()  # what has been painted on keeps its painter's memory, more than its pixels take
