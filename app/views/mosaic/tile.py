"""The tiles of the mosaic, on their board and enlarged."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import QEvent, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QAction,
    QColor,
    QFont,
    QFontMetrics,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPalette,
    QPen,
    QResizeEvent,
)
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QGridLayout,
    QLabel,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from app.model.display.mosaic import Plan, Tile
from app.model.text.language import tr
from app.session.features.side_by_side.parameter_sweep import Done
from app.views.mosaic.picture import Picture
from app.views.theme import theme

_ENTER = (Qt.Key.Key_Return, Qt.Key.Key_Enter)
_ARROWS = {
    Qt.Key.Key_Up: (-1, 0),
    Qt.Key.Key_Down: (1, 0),
    Qt.Key.Key_Left: (0, -1),
    Qt.Key.Key_Right: (0, 1),
}
_PADDING = 6.0
_ROUND = 5.0


class TileView(QWidget):
    """Shows one run: its picture, its two values, and below `lines` lines of text."""

    picked = Signal(object)
    """The user chooses its parameters: Tile."""
    enlarged = Signal(object)
    """The user asks to enlarge it: Done."""

    moved_on = Signal(int, int)
    """The user moves the focus to another tile: its row and column."""

    def __init__(self, tile: Tile, caption: str, picture: Picture, lines: int = 2) -> None:
        super().__init__()
        self.tile = tile
        self.caption = caption
        self.done: Done | None = None
        self.state = tr("waiting")
        self._picture = picture
        self._lines = lines
        self.chosen = False
        self._over = False
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setCursor(Qt.CursorShape.PointingHandCursor)
        self.setAccessibleName(caption)
        self.setToolTip(
            tr("{caption}: click or press Enter to use these values, press Space to enlarge.").format(caption=caption)
        )
        self.larger = QToolButton(self)
        self.larger.setText("⤢")
        self.larger.setToolTip(tr("Enlarge (Space)."))
        self.larger.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.larger.setCursor(Qt.CursorShape.ArrowCursor)
        self.larger.hide()
        self.larger.clicked.connect(self._enlarge)
        for text, do in ((tr("&Use these values"), self._pick), (tr("&Enlarge"), self._enlarge)):
            action = QAction(text, self)
            action.triggered.connect(do)
            self.addAction(action)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)

    def sizeHint(self) -> QSize:
        """A square with room for two lines."""
        return QSize(190, 210)

    def minimumSizeHint(self) -> QSize:
        """No narrower than its text."""
        texts = (f"✓ {self.caption}", tr("{found}, {steps} steps").format(found="000 contours", steps="0000"))
        widest = max(map(QFontMetrics(self._bold()).horizontalAdvance, texts))
        return QSize(max(110, widest + 16), 120)

    def begin(self) -> None:
        """Show that its run has begun."""
        self.state = tr("running…")
        self.update()

    def finish(self, done: Done) -> None:
        """Show a finished run."""
        self.done = done
        self.state = words(done)
        self.setAccessibleDescription(self.state)
        if done.trouble:
            self.setToolTip(done.trouble)
        self.update()

    def cancel(self) -> None:
        """Show that it will not be run."""
        if self.done is None:
            self.state = tr("canceled")
            self.update()

    def mark(self, chosen: bool) -> None:
        """Show whether its parameters are those of the document."""
        if chosen != self.chosen:
            self.chosen = chosen
            self.update()

    # Qt interface

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Take the focus; the release of the button picks the tile."""
        self.setFocus()
        event.accept()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Pick the tile."""
        if event.button() == Qt.MouseButton.LeftButton and self.rect().contains(event.position().toPoint()):
            self._pick()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Pick on Enter, enlarge on Space, move the focus by arrow keys."""
        if event.key() in _ENTER:
            self._pick()
        elif event.key() == Qt.Key.Key_Space:
            self._enlarge()
        elif move := _ARROWS.get(Qt.Key(event.key())):
            self.moved_on.emit(self.tile.row + move[0], self.tile.col + move[1])
        else:
            super().keyPressEvent(event)

    def event(self, event: QEvent) -> bool:
        """Show the button that enlarges it while the pointer is over the tile."""
        if event.type() in (QEvent.Type.Enter, QEvent.Type.Leave):
            self._over = event.type() == QEvent.Type.Enter
            self.larger.setVisible(self._over and self.done is not None and self.done.result is not None)
            self.update()
        if event.type() in (QEvent.Type.FocusIn, QEvent.Type.FocusOut):
            self.update()
        return super().event(event)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Keep the button in the corner."""
        self.larger.adjustSize()
        self.larger.move(self.width() - self.larger.width() - 10, 10)
        super().resizeEvent(event)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint picture, text and outline."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        palette = self.palette()
        role = QPalette.ColorRole
        outline = QRectF(self.rect()).adjusted(1.5, 1.5, -1.5, -1.5)
        marked = self.chosen or self.hasFocus() or self._over
        width = 3.0 if self.chosen else 1.6 if self.hasFocus() else 1.0
        painter.setPen(QPen(palette.color(role.Highlight if marked else role.Mid), width))
        painter.setBrush(palette.color(role.Base))
        painter.drawRoundedRect(outline, _ROUND, _ROUND)
        lines = self._lines * self.fontMetrics().height() + 4
        room = outline.adjusted(_PADDING, _PADDING, -_PADDING, -_PADDING - lines)
        result = self.done.result if self.done else None
        self._picture.draw(painter, room, result.contours if result else (), pale=result is None)
        self._write(
            painter, QRectF(outline.left() + _PADDING, room.bottom() + 3, outline.width() - 2 * _PADDING, lines)
        )
        painter.end()

    # Internal

    def _write(self, painter: QPainter, room: QRectF) -> None:
        caption = f"✓ {self.caption}" if self.chosen else self.caption
        height = self.fontMetrics().height()
        for index, text in enumerate((caption, *self.state.splitlines())):
            role = QPalette.ColorRole.PlaceholderText if index else QPalette.ColorRole.Text
            font = self.font() if index else self._bold()
            painter.setFont(font)
            painter.setPen(self.palette().color(role))
            line = QRectF(room.left(), room.top() + index * height, room.width(), height)
            shown = QFontMetrics(font).elidedText(text, Qt.TextElideMode.ElideRight, int(room.width()))
            painter.drawText(line, Qt.AlignmentFlag.AlignCenter, shown)

    def _bold(self) -> QFont:
        font = QFont(self.font())
        font.setBold(True)
        return font

    def _pick(self) -> None:
        self.picked.emit(self.tile)

    def _enlarge(self) -> None:
        if self.done is not None and self.done.result is not None:
            self.enlarged.emit(self.done)


def words(done: Done) -> str:
    """Number of contours and steps, and on a second line the Dice overlap with the ground truth, if any."""
    if done.result is None:
        return done.trouble
    count = len(done.result.contours)
    found = tr("1 contour") if count == 1 else tr("{count} contours").format(count=count)
    text = tr("{found}, {steps} steps").format(found=found, steps=done.result.steps)
    return text if done.dice is None else "\n".join((text, tr("Dice {dice:.4f}").format(dice=done.dice)))


class Board(QWidget):
    """The tiles of the present mosaic, in rows and columns."""

    def __init__(self) -> None:
        super().__init__()
        self.tiles: dict[tuple[int, int], TileView] = {}
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setSpacing(6)

    def lay(self, plan: Plan, picture: Picture, lines: int) -> Iterable[TileView]:
        """Replace the tiles by those of a plan, with `lines` lines of text below each."""
        for view in self.tiles.values():
            self._grid.removeWidget(view)
            view.hide()
            view.deleteLater()
        self.tiles.clear()
        for tile in plan.tiles:
            view = self.tiles[tile.row, tile.col] = TileView(tile, plan.caption(tile), picture, lines)
            view.moved_on.connect(self._go_to)
            self._grid.addWidget(view, tile.row, tile.col)
        return self.tiles.values()

    def view_of(self, tile: Tile) -> TileView | None:
        """The view of a tile; None if the tile belongs to a previous mosaic."""
        view = self.tiles.get((tile.row, tile.col))
        return view if view is not None and view.tile is tile else None

    def _go_to(self, row: int, col: int) -> None:
        if (row, col) in self.tiles:
            self.tiles[row, col].setFocus()


class EnlargedTile(QDialog):
    """Shows one run at the size of the dialog; accepted when its values are to be used."""

    def __init__(self, parent: QWidget, done: Done, caption: str, picture: Picture) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(caption)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        self.take = buttons.addButton(tr("Use these values"), QDialogButtonBox.ButtonRole.AcceptRole)
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        about = QLabel(f"<b>{caption}</b> · {words(done).replace(chr(10), ', ')}")
        layout = QVBoxLayout(self)
        layout.addWidget(_Canvas(done, picture), 1)
        layout.addWidget(about)
        layout.addWidget(buttons)


class _Canvas(QWidget):
    def __init__(self, done: Done, picture: Picture) -> None:
        super().__init__()
        self._done = done
        self._picture = picture
        self.setMinimumSize(320, 240)

    def sizeHint(self) -> QSize:
        """A large size."""
        return QSize(640, 560)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint it on the background color of the canvas."""
        painter = QPainter(self)
        painter.fillRect(self.rect(), QColor(theme.CANVAS))
        result = self._done.result
        self._picture.draw(painter, QRectF(self.rect()), result.contours if result else ())
        painter.end()
