"""The table of what was found on all pages of a stack."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from PySide6.QtCore import QAbstractTableModel, QModelIndex, Qt, Signal
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QAbstractItemView

from app.model.display.lengths import PixelSize
from app.model.display.page_rows import PageRow
from app.model.text.language import tr
from app.views.panels.item_table.model import VALUE, Index, Role, Sorted
from app.views.panels.item_table.row_table import RowTable
from app.views.panels.pages.columns import COLUMNS, HAPPENS

_ENTER = (Qt.Key.Key_Return, Qt.Key.Key_Enter)


class PageModel(QAbstractTableModel):
    """The rows of all pages; nothing of them is edited here."""

    def __init__(self) -> None:
        super().__init__()
        self._rows: Sequence[PageRow] = ()
        self._size = PixelSize((1.0, 1.0), None)

    def show_rows(self, rows: Sequence[PageRow], size: PixelSize) -> None:
        """Show these rows, with lengths in the unit of a size of a pixel."""
        self.beginResetModel()
        self._rows, self._size = rows, size
        self.endResetModel()

    def row(self, number: int) -> PageRow:
        """A row by its number."""
        return self._rows[number]

    def rowCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008  # as Qt declares it
        """Number of rows."""
        return 0 if parent.isValid() else len(self._rows)

    def columnCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008  # as Qt declares it
        """Number of columns."""
        return 0 if parent.isValid() else len(COLUMNS)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = Role.DisplayRole) -> Any:
        """Headings with the unit of lengths, and their tooltips."""
        if orientation == Qt.Orientation.Vertical:
            return None
        if role == Role.DisplayRole:
            return COLUMNS[section].title.format(unit=self._size.unit or "px")
        return COLUMNS[section].tip if role == Role.ToolTipRole else None

    def data(self, index: Index, role: int = Role.DisplayRole) -> Any:
        """Text, sort key and alignment of a cell."""
        column, row = COLUMNS[index.column()], self._rows[index.row()]
        if role in (Role.DisplayRole, Role.ToolTipRole):
            return column.shown(row, self._size.factor)
        if role == VALUE:
            return column.value(row)
        if role == Role.TextAlignmentRole and column.numeric:
            return Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        return None


class PageTable(RowTable):
    """Shows the rows; a double click or Enter goes to the contour of a row."""

    wanted = Signal(object)
    """The user wants to see what a row tells of: a PageRow."""

    def __init__(self) -> None:
        self.rows = PageModel()
        super().__init__(self.rows, Sorted(self.rows), COLUMNS, HAPPENS, tr("Contours on all pages"))
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.doubleClicked.connect(self._go)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Go to the contour of the row on Enter."""
        if event.key() in _ENTER and self.currentIndex().isValid():
            self._go(self.currentIndex())
        else:
            super().keyPressEvent(event)

    def _go(self, index: Index) -> None:
        self.wanted.emit(self.rows.row(self._sorted.mapToSource(index).row()))
