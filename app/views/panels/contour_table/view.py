"""The contour table; its selection is shared with the canvas."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QItemSelection, QItemSelectionModel, QModelIndex, QPersistentModelIndex, Qt
from PySide6.QtGui import QKeyEvent, QResizeEvent, QShowEvent
from PySide6.QtWidgets import QAbstractItemView, QLineEdit, QStyledItemDelegate, QTableView, QWidget

from app.model.text.language import tr
from app.session.features.contour_review import ContourReview
from app.views.panels.contour_table.columns import COLUMNS, NAME
from app.views.panels.contour_table.model import ContourModel, SortedContours

_ENTER = (Qt.Key.Key_Return, Qt.Key.Key_Enter)
_DELETE = (Qt.Key.Key_Delete, Qt.Key.Key_Backspace)
_PAD = 18


class NameDelegate(QStyledItemDelegate):
    """Editor of names that is not disturbed by reconstructions."""

    def setEditorData(self, editor: QWidget, index: QModelIndex | QPersistentModelIndex) -> None:
        """Start with the present name; text that the user has typed is not overwritten."""
        if not (isinstance(editor, QLineEdit) and editor.isModified()):
            super().setEditorData(editor, index)


class ContourTable(QTableView):
    """Shows the contours of a review, selects and names them."""

    def __init__(self, review: ContourReview) -> None:
        super().__init__()
        self._review = review
        self._showing = False
        self._stale = False
        self._rows = ContourModel(review, self)
        self._sorted = SortedContours(self._rows, self)
        self.setModel(self._sorted)
        self.setItemDelegate(NameDelegate(self))
        self.setAccessibleName(tr("Contours"))
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.EditKeyPressed)
        self.setSortingEnabled(True)
        self.sortByColumn(0, Qt.SortOrder.AscendingOrder)
        self.setShowGrid(False)
        self.setAlternatingRowColors(True)
        self.setWordWrap(False)
        self.setMouseTracking(True)
        self.setTabKeyNavigation(False)
        self.setMinimumHeight(96)
        self._lay_out()
        self.entered.connect(lambda index: review.hover(self._key(index)))
        self.doubleClicked.connect(lambda index: self._edit_name(index.row()))
        self.selectionModel().selectionChanged.connect(self._report_selection)
        review.changed.connect(self._show)
        review.selection_changed.connect(self._show_selection)

    def column(self, name: str) -> list[str]:
        """The texts of a column, from top to bottom."""
        number = next(index for index, column in enumerate(COLUMNS) if column.name == name)
        return [str(self._sorted.index(row, number).data()) for row in range(self._sorted.rowCount())]

    def show_only(self, verdict: str | None) -> None:
        """Show the contours with a verdict (empty for the undecided ones), or all for None."""
        self._showing = True
        self._sorted.show_only(verdict)
        self._showing = False
        self._show_selection()

    def name_selected(self) -> None:
        """Edit the name in the selected row."""
        rows = self.selectionModel().selectedRows()
        if rows:
            self._edit_name(rows[0].row())

    # Qt interface

    def event(self, event: QEvent) -> bool:
        """Handle the keys of the table before they act as shortcuts of the window."""
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent) and event.key() in _DELETE:
            event.accept()
            return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Edit the name on Enter, reject on Delete."""
        if event.key() in _ENTER:
            self._edit_name(self.currentIndex().row())
        elif event.key() in _DELETE:
            self._review.judge("rejected")
        else:
            super().keyPressEvent(event)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Give the remaining width to the names."""
        others = sum(self.columnWidth(index) for index in range(len(COLUMNS)) if index != NAME)
        self.setColumnWidth(NAME, max(self._name_width, event.size().width() - others))
        super().resizeEvent(event)

    def showEvent(self, event: QShowEvent) -> None:
        """Update the table if contours have changed while it was hidden."""
        super().showEvent(event)
        if self._stale:
            self._show()

    def leaveEvent(self, event: QEvent) -> None:
        """Clear the highlight when the pointer leaves."""
        self._review.hover(None)
        super().leaveEvent(event)

    # Internal

    def _lay_out(self) -> None:
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(self.fontMetrics().height() + 8)
        header = self.horizontalHeader()
        header.setHighlightSections(False)
        header.setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        for index, column in enumerate(COLUMNS):
            texts = (column.sample, column.title.format(unit="px"))
            self.setColumnWidth(index, max(map(self.fontMetrics().horizontalAdvance, texts)) + _PAD)
        self._name_width = self.columnWidth(NAME) + 2 * _PAD
        header.setMinimumSectionSize(44)

    def _key(self, index: QModelIndex) -> int:
        return self._rows.key(self._sorted.mapToSource(index).row())

    def _edit_name(self, row: int) -> None:
        if row >= 0 and self.state() != QAbstractItemView.State.EditingState:
            self.edit(self._sorted.index(row, NAME))

    def _show(self) -> None:
        self._stale = not self.isVisible()  # a hidden table must not take time from the run
        if self._stale:
            return
        self._showing = True
        self._rows.refresh()
        self._showing = False
        self._show_selection()

    def _report_selection(self) -> None:
        if not self._showing:
            self._review.select(self._key(index) for index in self.selectionModel().selectedRows())

    def _show_selection(self) -> None:
        if self._stale:
            return
        wanted = self._review.selected
        if {self._key(index) for index in self.selectionModel().selectedRows()} == wanted:
            return
        rows = [row for key in wanted if (row := self._rows.row(key)) is not None]
        selection = QItemSelection()
        last = len(COLUMNS) - 1
        for row in rows:
            first = self._sorted.mapFromSource(self._rows.index(row, 0))
            if first.isValid():  # else the row is not shown
                selection.select(first, first.siblingAtColumn(last))
        self._showing = True
        self.selectionModel().select(selection, QItemSelectionModel.SelectionFlag.ClearAndSelect)
        if rows and self.state() != QAbstractItemView.State.EditingState:
            at = self._sorted.mapFromSource(self._rows.index(rows[0], NAME))
            self.selectionModel().setCurrentIndex(at, QItemSelectionModel.SelectionFlag.NoUpdate)
            self.scrollTo(at)
        self._showing = False
