"""The panel that lists the changes of the document and undoes or redoes up to any of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtCore import QPoint
from PySide6.QtGui import QAction, QIcon, QPalette
from PySide6.QtWidgets import QAbstractItemView, QFrame, QListWidget, QListWidgetItem, QVBoxLayout, QWidget

from app.model.text.language import tr
from app.session.undo_history import ChangeInWords
from app.views.theme.icons import icon
from app.views.theme.theme import Theme
from app.views.widgets.containers import arrange


class HistoryPanel(QWidget):
    """One line per change, below a line for the beginning; the last change in effect is marked, undone ones are gray.

    `go_to` is called with the number of changes that are to be in effect.
    """

    def __init__(self, go_to: Callable[[int], None]) -> None:
        super().__init__()
        self._go_to = go_to
        self._list = QListWidget()
        self.setFocusProxy(self._list)
        self._list.setAccessibleName(tr("History"))
        self._list.setFrameShape(QFrame.Shape.NoFrame)
        self._list.setSpacing(2)
        self._list.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self._list.setToolTip(tr("Click a line, or select it and press Enter, to undo or redo up to it."))
        self._there = QAction(tr("Undo or redo up to &here"), self)
        self._there.triggered.connect(lambda: self._choose(self._list.currentItem()))
        self.addAction(self._there)
        self._list.itemClicked.connect(self._choose)
        self._list.itemActivated.connect(self._choose)
        arrange(QVBoxLayout(self), self._list)
        self._theme: Theme | None = None
        self._shown: tuple[tuple[ChangeInWords, ...], int] = ((), -1)

    @property
    def lines(self) -> list[str]:
        """The listed lines, the beginning first."""
        return [self._list.item(row).text() for row in range(self._list.count())]

    @property
    def current(self) -> int:
        """Index of the marked line."""
        return self._list.currentRow()

    def menu_at(self, point: QPoint | None) -> tuple[str, QPoint]:
        """The marked line; the line at a point is marked first. See `MenuOwner`."""
        viewport = self._list.viewport()
        item = self._list.itemAt(viewport.mapFrom(self, point)) if point is not None else self._list.currentItem()
        if item is None:
            return "", QPoint()
        self._list.setCurrentItem(item)
        return "history", viewport.mapTo(self, self._list.visualItemRect(item).center()) if point is None else point

    def show_changes(self, changes: Sequence[ChangeInWords], done: int) -> None:
        """List changes, of which the first `done` are in effect."""
        shown = (tuple(changes), done)
        if shown == self._shown:
            return
        self._shown = shown
        self._list.clear()
        self._list.addItems([tr("Beginning"), *(change.text for change in changes)])
        self.mark()

    def use_theme(self, theme: Theme) -> None:
        """Color the lines and their icons."""
        self._theme = theme
        self.mark()

    def mark(self) -> None:
        """Mark the changes in effect, in the colors of the present palette."""
        names = ["", *(change.icon for change in self._shown[0])]
        done = self._shown[1]
        gray = self.palette().brush(QPalette.ColorGroup.Disabled, QPalette.ColorRole.Text)
        for row in range(self._list.count()):
            item = self._list.item(row)
            font = item.font()
            font.setBold(row == done)
            item.setFont(font)
            if self._theme is not None:
                color = self._theme.faded if row > done else self._theme.text
                item.setIcon(icon(names[row] or "step", color) if row else QIcon())
            item.setForeground(gray if row > done else self.palette().text())
        self._list.setCurrentRow(done)

    def _choose(self, item: QListWidgetItem) -> None:
        self._go_to(self._list.row(item))
