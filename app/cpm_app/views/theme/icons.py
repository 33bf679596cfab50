"""Icons from the SVG files of the program, swatches, and a menu of colors.

They are drawn in the colors of the moment, so that they follow the theme and the preferences by themselves.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from PySide6.QtCore import QByteArray, QRect, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QCursor, QGuiApplication, QIcon, QIconEngine, QPainter, QPalette, QPixmap
from PySide6.QtSvg import QSvgRenderer
from PySide6.QtWidgets import QColorDialog, QMenu, QWidget

from cpm_app.model.text.assets import find_asset
from cpm_app.model.text.language import tr
from cpm_app.views.theme.theme import get_canvas_style

SWATCH_RIM = "#858b93"
"""Color of the rim of a swatch, which sets any color off from a light and from a dark background."""

_SWATCH_GAP = 5.0
"""Space between the discs of a swatch [px]."""


class _IconEngine(QIconEngine):
    """Draws an icon when it is needed; `draw` returns its picture for a size and a mode."""

    def __init__(self, draw: Callable[[QSize, QIcon.Mode], QPixmap]) -> None:
        super().__init__()
        self._draw = draw

    def clone(self) -> QIconEngine:
        """Return an engine that draws the same icon."""
        return _IconEngine(self._draw)

    def paint(self, painter: QPainter, rect: QRect, mode: QIcon.Mode, state: QIcon.State) -> None:
        """Draw the icon on a widget."""
        painter.drawPixmap(rect, self.pixmap(rect.size() * painter.device().devicePixelRatio(), mode, state))

    def pixmap(self, size: QSize, mode: QIcon.Mode, state: QIcon.State) -> QPixmap:
        """Return the picture of the icon."""
        return self._draw(size, mode)


@cache
def load_icon(name: str, role: QPalette.ColorRole = QPalette.ColorRole.WindowText) -> QIcon:
    """Return the icon of an SVG file in a color of the palette: pale if disabled, that of text on selected rows."""
    special = {QIcon.Mode.Disabled: QPalette.ColorRole.Mid, QIcon.Mode.Selected: QPalette.ColorRole.HighlightedText}

    def draw(size: QSize, mode: QIcon.Mode) -> QPixmap:
        color = QGuiApplication.palette().color(special.get(mode, role))
        return _draw_symbol(name, color.name(), size.height())

    return QIcon(_IconEngine(draw))


@cache
def _draw_symbol(name: str, color: str, side: int) -> QPixmap:
    """Draw an SVG file with a color in place of its ``currentColor``."""
    source = find_asset(f"icons/{name}.svg").read_text(encoding="utf-8")
    pixmap = QPixmap(side, side)
    pixmap.fill(Qt.GlobalColor.transparent)
    painter = QPainter(pixmap)
    QSvgRenderer(QByteArray(source.replace("currentColor", color).encode())).render(painter)
    painter.end()
    # a pixmap that was painted on keeps the memory of its painter, which exceeds that of its pixels
    return pixmap.copy()


@cache
def create_pointer(name: str) -> QCursor:
    """Create a pointer from an icon, light with a dark rim; its hot spot is the middle."""
    side = 24
    pixmap = QPixmap(side, side)
    pixmap.fill(Qt.GlobalColor.transparent)
    painter = QPainter(pixmap)
    for x, y in ((-1, 0), (1, 0), (0, -1), (0, 1)):
        painter.drawPixmap(x, y, _draw_symbol(name, "#101216", side))
    painter.drawPixmap(0, 0, _draw_symbol(name, "#ffffff", side))
    painter.end()
    return QCursor(pixmap)


def create_swatch(*colors: str) -> QIcon:
    """Create a legend icon: small discs side by side in the colors that the user has selected for these."""

    def draw(size: QSize, _: QIcon.Mode) -> QPixmap:
        width = size.width() / len(colors)
        side = min(width, size.height()) - _SWATCH_GAP
        pixmap = QPixmap(size)
        pixmap.fill(Qt.GlobalColor.transparent)
        painter = QPainter(pixmap)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QColor(SWATCH_RIM))
        for index, color in enumerate(colors):
            painter.setBrush(QColor(get_canvas_style().resolve_color(color)))
            painter.drawEllipse(QRectF((index + 0.5) * width - side / 2, (size.height() - side) / 2, side, side))
        painter.end()
        return pixmap

    return QIcon(_IconEngine(draw))


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


def fill_colors(menu: QMenu, parent: QWidget, choose: Callable[[str], None]) -> None:
    """Fill a menu with colors; `choose` is called with ``"#rrggbb"``, or with an empty text for the default."""
    for title, color in SWATCH_COLORS:
        menu.addAction(create_swatch(color), title).triggered.connect(lambda _=False, color=color: choose(color))
    menu.addSeparator()
    menu.addAction(tr("Other color…")).triggered.connect(lambda: _ask_for_color(parent, choose))
    menu.addAction(tr("Color of its kind")).triggered.connect(lambda: choose(""))


def _ask_for_color(parent: QWidget, choose: Callable[[str], None]) -> None:
    color = QColorDialog.getColor(parent=parent, title=tr("Color"))
    if color.isValid():
        choose(color.name())
