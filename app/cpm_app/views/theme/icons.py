"""Icons from the SVG files of the program in the color of the text around them, swatches, and a menu of colors."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

from PySide6.QtCore import QByteArray, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QCursor, QGuiApplication, QIcon, QPainter, QPixmap
from PySide6.QtSvg import QSvgRenderer
from PySide6.QtWidgets import QColorDialog, QMenu, QWidget

from cpm_app.model.text.assets import find_asset
from cpm_app.model.text.language import tr
from cpm_app.views.theme.theme import get_canvas_style

_ICON_SIZES = (16, 20, 24)
"""Sizes of icons in menus, on buttons, and of pointers [device-independent px]."""

SWATCH_RIM = "#858b93"
"""Color of the rim of a swatch, which sets any color off from a light and from a dark background."""


@cache
def load_icon(name: str, color: str, faded: str | None = None) -> QIcon:
    """Return an icon by its name, rendered once.

    Parameters
    ----------
    name : str
        Name of the SVG file without its suffix.
    color : str
        Color that replaces ``currentColor`` in the file.
    faded : str, optional
        Color of the disabled icon.
    """
    source = find_asset(f"icons/{name}.svg").read_text(encoding="utf-8")
    ratio = max(screen.devicePixelRatio() for screen in QGuiApplication.screens())
    made = QIcon()
    for mode, tint in ((QIcon.Mode.Normal, color), (QIcon.Mode.Disabled, faded)):
        if tint is not None:
            renderer = QSvgRenderer(QByteArray(source.replace("currentColor", tint).encode()))
            for size in _ICON_SIZES:
                made.addPixmap(_render_svg(renderer, math.ceil(ratio * size)), mode)
    return made


@cache
def create_pointer(name: str) -> QCursor:
    """Create a pointer from an icon, light with a dark rim; its hot spot is the middle."""
    side = 24
    pixmap = QPixmap(side, side)
    pixmap.fill(Qt.GlobalColor.transparent)
    painter = QPainter(pixmap)
    rim, picture = (load_icon(name, color).pixmap(QSize(side, side), 1.0) for color in ("#101216", "#ffffff"))
    for x, y in ((-1, 0), (1, 0), (0, -1), (0, 1)):
        painter.drawPixmap(x, y, rim)
    painter.drawPixmap(0, 0, picture)
    painter.end()
    return QCursor(pixmap)


@cache
def load_program_icon() -> QIcon:
    """Return the icon of the program itself."""
    renderer = QSvgRenderer(str(find_asset("icons/cpm.svg")))
    made = QIcon()
    for size in (*_ICON_SIZES, 32, 48, 64, 128, 256):
        made.addPixmap(_render_svg(renderer, size))
    return made


def create_swatch(*colors: str) -> QIcon:
    """Create a legend icon: small discs side by side in the colors that the user has selected for these."""
    return _draw_discs(*(get_canvas_style().resolve_color(color) for color in colors))


@cache
def _draw_discs(*colors: str) -> QIcon:
    side = 14
    pixmap = QPixmap(QSize((side + 2) * len(colors), side))
    pixmap.fill(Qt.GlobalColor.transparent)
    painter = QPainter(pixmap)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setPen(QColor(SWATCH_RIM))
    for index, color in enumerate(colors):
        painter.setBrush(QColor(color))
        painter.drawEllipse(QRectF(index * (side + 2) + 1.5, 1.5, side - 3, side - 3))
    painter.end()
    return QIcon(pixmap)


def _render_svg(renderer: QSvgRenderer, size: int) -> QPixmap:
    pixmap = QPixmap(size, size)
    pixmap.fill(Qt.GlobalColor.transparent)
    painter = QPainter(pixmap)
    renderer.render(painter)
    painter.end()
    return (
        pixmap.copy()
    )  # a pixmap that was painted on keeps the memory of its painter, which exceeds that of its pixels


SWATCH_COLORS: tuple[tuple[str, str], ...] = (
    (tr("Orange"), "#e69f00"),
    (tr("Sky blue"), "#56b4e9"),
    (tr("Bluish green"), "#009e73"),
    (tr("Yellow"), "#f0e442"),
    (tr("Blue"), "#0072b2"),
    (tr("Vermilion"), "#d55e00"),
    (tr("Reddish purple"), "#cc79a7"),
    (tr("White"), "#ffffff"),
)
"""Titles and colors after Okabe and Ito, with white instead of black because the canvas is dark."""


def fill_colors(menu: QMenu, parent: QWidget, choose: Callable[[str], None], enabled: bool) -> None:
    """Fill a menu with colors; `choose` is called with ``"#rrggbb"``, or with an empty text for the default."""
    for title, color in SWATCH_COLORS:
        menu.addAction(create_swatch(color), title).triggered.connect(lambda _=False, color=color: choose(color))
    menu.addSeparator()
    menu.addAction(tr("Other color…")).triggered.connect(lambda: _ask_for_color(parent, choose))
    menu.addAction(tr("Color of its kind")).triggered.connect(lambda: choose(""))
    for action in menu.actions():
        action.setEnabled(enabled)


def _ask_for_color(parent: QWidget, choose: Callable[[str], None]) -> None:
    color = QColorDialog.getColor(parent=parent, title=tr("Color"))
    if color.isValid():
        choose(color.name())
