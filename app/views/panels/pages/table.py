"""The table of what was found on all pages of a stack."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QAbstractItemView

from app.model.display.page_rows import PageRow
from app.model.text.language import tr
from app.views.panels.item_table.model import Index, Sorted
from app.views.panels.item_table.row_model import RowModel
from app.views.panels.item_table.row_table import RowTable
from app.views.panels.pages.columns import COLUMNS, HAPPENS

_ENTER = (Qt.Key.Key_Return, Qt.Key.Key_Enter)


class PageTable(RowTable):
    """Shows the rows; a double click or Enter goes to the contour of a row."""

    wanted = Signal(object)
    """The user wants to see what a row tells of: a PageRow."""

    def __init__(self) -> None:
        self.rows = RowModel[PageRow](COLUMNS)
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
