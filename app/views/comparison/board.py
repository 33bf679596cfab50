"""The results of a comparison: a picture of each run, and one table of all of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QRectF, QSize, QSizeF, Qt, Signal
from PySide6.QtGui import QColor, QIcon, QImage, QPainter, QPen, QPixmap, QTransform
from PySide6.QtWidgets import (
    QButtonGroup,
    QGridLayout,
    QHeaderView,
    QScrollArea,
    QSplitter,
    QTableWidget,
    QTableWidgetItem,
    QToolButton,
    QWidget,
)

from app.model.display.comparison import Tile
from app.model.display.display_image import DisplayImage
from app.model.text.language import from_core, tr, written
from app.session.features.comparison import Done
from app.views.canvas.items.item import to_xy
from app.views.theme import theme
from app.views.theme.look import look
from cpm_core.contours.contour import Contour

_LINE, _HALO = 1.8, 3.2
_LEAST_WIDTH, _MOST_WIDTH = 130, 420
"""Limits of the width of a tile [px]."""
_LEAST = 1000.0
"""Pixels along the longer side of the crop from which on the image is drawn reduced."""

Lines = Sequence[tuple[Contour, str]]
"""Contours with their colors."""


class Picture:
    """Draws the part `crop` [px] of an image, and lines: those of `below` and those that a run has found."""

    def __init__(self, display: DisplayImage, crop: QRectF, below: Lines = ()) -> None:
        shades = display.reduced(_LEAST * max(display.shape) / max(crop.width(), crop.height(), 1.0))
        self._size = 1.0 if shades is display.shades else max(display.shape) / max(shades.shape[:2])
        gray = np.ascontiguousarray(shades)
        rows, cols = gray.shape[:2]
        kind = QImage.Format.Format_Grayscale8 if gray.ndim == 2 else QImage.Format.Format_RGB888
        self._image = QImage(gray.data, cols, rows, gray.strides[0], kind).copy()
        self._crop = crop
        self.below = below

    def drawn(self, room: QSize, ratio: float, contours: Iterable[Contour] | None) -> QPixmap:
        """A picture as large as fits into a room; pale while there are no contours yet."""
        size = QSizeF(self._crop.size()).scaled(QSizeF(room), Qt.AspectRatioMode.KeepAspectRatio)
        made = QPixmap((size * ratio).toSize().expandedTo(QSize(1, 1)))
        made.setDevicePixelRatio(ratio)
        made.fill(QColor(theme.CANVAS))
        painter = QPainter(made)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setOpacity(0.35 if contours is None else 1.0)
        # The center of the first pixel of an image is (0, 0), as on the canvas.
        part = QTransform.fromScale(1.0 / self._size, 1.0 / self._size).mapRect(self._crop.translated(0.5, 0.5))
        painter.drawImage(QRectF(0.0, 0.0, size.width(), size.height()), self._image, part)
        painter.setOpacity(1.0)
        zoom = size.width() / max(self._crop.width(), 1e-9)
        onto = QTransform(zoom, 0, 0, zoom, -zoom * self._crop.x(), -zoom * self._crop.y())
        found = [(one, one.color or look().color(theme.CLOSED if one.closed else theme.OPEN)) for one in contours or ()]
        paths = [(color, onto.map(pg.arrayToQPath(*map(np.ascontiguousarray, to_xy(contour.path)))))
                 for contour, color in (*self.below, *found)]  # fmt: skip
        for _, path in paths:
            painter.strokePath(path, QPen(QColor(theme.HALO), _HALO))
        for color, path in paths:
            painter.strokePath(path, QPen(QColor(color), _LINE))
        painter.end()
        return made


class TileView(QToolButton):
    """One run: its picture, and below it what it is and how far it has come."""

    def __init__(self, tile: Tile, picture: Picture, width: int) -> None:
        super().__init__()
        self.tile = tile
        self.done: Done | None = None
        self.state = tr("waiting")
        self.picture = picture
        self.used = False
        self.setCheckable(True)
        self.setAutoRaise(True)
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextUnderIcon)
        self.setIconSize(QSize(width, width))
        self.setAccessibleName(tile.caption)
        self._refresh()

    def show_state(self, state: str) -> None:
        """Show how far the run has come."""
        self.state = state
        self._refresh()

    def finish(self, done: Done) -> None:
        """Show a finished run."""
        self.done = done
        self.setToolTip(done.trouble or (from_core(done.facts.stop_reason) if done.facts else ""))
        self.show_state(words(done))

    def mark(self, used: bool) -> None:
        """Show whether its values are those of the window."""
        if used != self.used:
            self.used = used
            self._refresh()

    def _refresh(self) -> None:
        result = self.done.result if self.done else None
        pixels = self.picture.drawn(self.iconSize(), self.devicePixelRatioF(), result.contours if result else None)
        self.setIcon(QIcon(pixels))
        caption = f"✓ {self.tile.caption}" if self.used else self.tile.caption
        # An ampersand in a text of a button would mark a key.
        lines = [caption, *self.state.splitlines(), ""][:3]
        width = max(self.iconSize().width(), _LEAST_WIDTH)
        shown = (self.fontMetrics().elidedText(line, Qt.TextElideMode.ElideRight, width) for line in lines)
        self.setText("\n".join(shown).replace("&", "&&"))
        self.setAccessibleDescription(self.state)


def words(done: Done) -> str:
    """Number of contours and steps, and on a second line the Dice overlap with the ground truth, if any."""
    if done.facts is None:
        return done.trouble
    count = done.facts.contours
    found = tr("1 contour") if count == 1 else tr("{count} contours").format(count=count)
    text = tr("{found}, {steps} steps").format(found=found, steps=done.facts.steps)
    return text if done.facts.dice is None else "\n".join((text, tr("Dice {dice:.4f}").format(dice=done.facts.dice)))


class Board(QSplitter):
    """The tiles of the present comparison in rows and columns, and below them the table of its results."""

    selected = Signal()
    """Another tile has been selected."""
    taken = Signal()
    """The selected tile has been pressed twice, or chosen by Enter."""

    def __init__(self) -> None:
        super().__init__(Qt.Orientation.Vertical)
        self.tiles: tuple[TileView, ...] = ()
        self._area = QScrollArea()
        self._area.setWidgetResizable(True)
        self._area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        titles = (tr("Run"), tr("Steps"), tr("Time [s]"), tr("Contours"), tr("Closed"), "Dice", "F",
                  tr("Hausdorff") + " [px]", tr("Mean distance") + " [px]")  # fmt: skip
        self.table = QTableWidget(0, len(titles))
        self.table.setHorizontalHeaderLabels(titles)
        self.table.setAccessibleName(tr("Results of the comparison"))
        self.table.setSelectionBehavior(QTableWidget.SelectionBehavior.SelectRows)
        self.table.setSelectionMode(QTableWidget.SelectionMode.SingleSelection)
        self.table.setEditTriggers(QTableWidget.EditTrigger.NoEditTriggers)
        self.table.setTabKeyNavigation(False)
        self.table.verticalHeader().hide()
        self.table.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        self.table.currentCellChanged.connect(self._select_row)
        self.table.cellActivated.connect(self.taken)
        self.addWidget(self._area)
        self.addWidget(self.table)
        self.setStretchFactor(0, 4)
        self.setStretchFactor(1, 1)
        self.lay((), None)

    @property
    def current(self) -> TileView | None:
        """The selected tile."""
        return next((view for view in self.tiles if view.isChecked()), None)

    def lay(self, tiles: Sequence[Tile], picture: Picture | None) -> None:
        """Replace the tiles and the rows of the table."""
        body = QWidget()
        grid, group = QGridLayout(body), QButtonGroup(body)
        across = 1 + max((tile.col for tile in tiles), default=0)
        width = min(max((self._area.width() - 40) // across - 16, _LEAST_WIDTH), _MOST_WIDTH)
        self.tiles = tuple(TileView(tile, picture, width) for tile in tiles) if picture else ()
        self.table.setRowCount(len(self.tiles))
        for row, view in enumerate(self.tiles):
            group.addButton(view)
            grid.addWidget(view, view.tile.row, view.tile.col)
            view.toggled.connect(self._show_selected)
            self.table.setItem(row, 0, QTableWidgetItem(view.tile.caption))
        grid.setAlignment(Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignLeft)
        self._area.setWidget(body)
        if self.tiles:
            self.tiles[0].setChecked(True)
            self.tiles[0].setFocus()

    def view_of(self, tile: Tile) -> TileView | None:
        """The view of a tile; None if the tile belongs to a previous comparison."""
        return next((view for view in self.tiles if view.tile is tile), None)

    def finish(self, done: Done) -> None:
        """Show a finished run in its tile and in the table."""
        view, facts = self.view_of(done.tile), done.facts
        if view is None:
            return
        view.finish(done)
        if facts is None:
            return
        figures = [str(facts.steps), f"{facts.seconds:.2f}", str(facts.contours), str(facts.closed)]
        for value, decimals in ((facts.dice, 4), (facts.f, 3), (facts.hausdorff, 1), (facts.mean_distance, 2)):
            figures.append("–" if value is None or not np.isfinite(value) else f"{value:.{decimals}f}")
        for column, figure in enumerate(figures, start=1):
            cell = QTableWidgetItem(written(figure))
            cell.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            self.table.setItem(self.tiles.index(view), column, cell)

    def _select_row(self, row: int) -> None:
        if 0 <= row < len(self.tiles):
            self.tiles[row].setChecked(True)

    def _show_selected(self) -> None:
        view = self.current
        if view is not None:
            self.table.selectRow(self.tiles.index(view))
            self.selected.emit()
