"""The panel that lists the changes of the document and undoes or redoes up to any of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QAbstractItemView, QFrame, QListWidget, QListWidgetItem, QVBoxLayout, QWidget

from app.model.text.language import tr


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
        self._list.itemClicked.connect(self._choose)
        self._list.itemActivated.connect(self._choose)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self._list)
        self._shown: tuple[tuple[str, ...], int] = ((), -1)

    @property
    def lines(self) -> list[str]:
        """The listed lines, the beginning first."""
        return [self._list.item(row).text() for row in range(self._list.count())]

    @property
    def current(self) -> int:
        """Index of the marked line."""
        return self._list.currentRow()

    def show_changes(self, names: Sequence[str], done: int) -> None:
        """List changes, of which the first `done` are in effect."""
        shown = (tuple(names), done)
        if shown == self._shown:
            return
        lines = [tr("Beginning"), *(f"{name[:1].upper()}{name[1:]}" for name in names)]
        for row, line in enumerate(lines):
            if row == self._list.count():
                self._list.addItem(line)
            elif self._list.item(row).text() != line:
                self._list.item(row).setText(line)
        while self._list.count() > len(lines):
            self._list.takeItem(self._list.count() - 1)
        self._shown = shown
        self.mark()

    def mark(self) -> None:
        """Mark the changes in effect, in the colors of the present palette."""
        done = self._shown[1]
        gray = self.palette().brush(QPalette.ColorGroup.Disabled, QPalette.ColorRole.Text)
        for row in range(self._list.count()):
            item = self._list.item(row)
            font = item.font()
            font.setBold(row == done)
            item.setFont(font)
            item.setForeground(gray if row > done else self.palette().text())
        self._list.setCurrentRow(done)

    def _choose(self, item: QListWidgetItem) -> None:
        self._go_to(self._list.row(item))
