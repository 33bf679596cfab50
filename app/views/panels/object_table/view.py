"""The table of objects; what is chosen in it is chosen on the canvas."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QItemSelection, QItemSelectionModel, QModelIndex, Qt, Signal
from PySide6.QtGui import QContextMenuEvent, QKeyEvent, QResizeEvent
from PySide6.QtWidgets import QAbstractItemView, QTableView

from app.model.text.language import tr
from app.session.features.objects.object_list import ObjectList
from app.session.session import Session
from app.views.panels.contour_table.model import Sorted
from app.views.panels.contour_table.view import NameDelegate
from app.views.panels.object_table.columns import NAME, OBJECT_COLUMNS
from app.views.panels.object_table.model import ObjectModel

_ENTER = (Qt.Key.Key_Return, Qt.Key.Key_Enter)
_DELETE = (Qt.Key.Key_Delete, Qt.Key.Key_Backspace)
_PAD = 18


class ObjectTable(QTableView):
    """Shows the objects of a list, chooses, names, classifies and removes them."""

    menu_wanted = Signal(object)
    """The menu of the chosen objects is wanted at a point of the screen: QPoint."""

    def __init__(self, session: Session, object_list: ObjectList) -> None:
        super().__init__()
        self._list = object_list
        self._showing = False
        self._rows = ObjectModel(session, object_list, self)
        self._sorted = Sorted(self._rows, self)
        self.setModel(self._sorted)
        self.setItemDelegate(NameDelegate(self))
        self.setAccessibleName(tr("Objects"))
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
        self.entered.connect(lambda index: object_list.hover(self._number(index)))
        self.doubleClicked.connect(lambda index: self._edit_name(index.row()))
        self.selectionModel().selectionChanged.connect(self._report_selection)
        object_list.changed.connect(self._show)
        object_list.selection_changed.connect(self._show_selection)
        session.image_changed.connect(self._show)
        self._show()

    def column(self, name: str) -> list[str]:
        """The texts of a column, from top to bottom."""
        number = next(index for index, column in enumerate(OBJECT_COLUMNS) if column.name == name)
        return [str(self._sorted.index(row, number).data()) for row in range(self._sorted.rowCount())]

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
        """Edit the name on Enter, remove on Delete, set the class by digits."""
        digit = event.key() - Qt.Key.Key_0
        if event.key() in _ENTER:
            self._edit_name(self.currentIndex().row())
        elif event.key() in _DELETE:
            self._list.delete()
        elif 1 <= digit <= len(self._list.objects.classes):
            self._list.classify(digit)
        else:
            super().keyPressEvent(event)

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        """Ask for the menu of the chosen objects."""
        self.menu_wanted.emit(event.globalPos())

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Give the remaining width to the names."""
        others = sum(self.columnWidth(index) for index in range(len(OBJECT_COLUMNS)) if index != NAME)
        self.setColumnWidth(NAME, max(self._name_width, event.size().width() - others))
        super().resizeEvent(event)

    def leaveEvent(self, event: QEvent) -> None:
        """Clear the highlight when the pointer leaves."""
        self._list.hover(0)
        super().leaveEvent(event)

    # Internal

    def _lay_out(self) -> None:
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(self.fontMetrics().height() + 8)
        header = self.horizontalHeader()
        header.setHighlightSections(False)
        header.setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        for index, column in enumerate(OBJECT_COLUMNS):
            texts = (column.sample, column.title.format(unit="px"))
            self.setColumnWidth(index, max(map(self.fontMetrics().horizontalAdvance, texts)) + _PAD)
        self._name_width = self.columnWidth(NAME) + 2 * _PAD
        header.setMinimumSectionSize(44)

    def _number(self, index: QModelIndex) -> int:
        return self._rows.number(self._sorted.mapToSource(index).row())

    def _edit_name(self, row: int) -> None:
        if row >= 0 and self.state() != QAbstractItemView.State.EditingState:
            self.edit(self._sorted.index(row, NAME))

    def _show(self) -> None:
        self._showing = True
        self._rows.refresh()
        self._showing = False
        self._show_selection()

    def _report_selection(self) -> None:
        if not self._showing:
            self._list.choose(self._number(index) for index in self.selectionModel().selectedRows())

    def _show_selection(self) -> None:
        wanted = self._list.chosen
        if {self._number(index) for index in self.selectionModel().selectedRows()} == wanted:
            return
        rows = [row for number in wanted if (row := self._rows.row(number)) is not None]
        selection = QItemSelection()
        for row in rows:
            first = self._sorted.mapFromSource(self._rows.index(row, 0))
            selection.select(first, first.siblingAtColumn(len(OBJECT_COLUMNS) - 1))
        self._showing = True
        self.selectionModel().select(selection, QItemSelectionModel.SelectionFlag.ClearAndSelect)
        if rows:
            self.scrollTo(self._sorted.mapFromSource(self._rows.index(rows[0], NAME)))
        self._showing = False
