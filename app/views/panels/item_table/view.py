"""A table of items whose selection is shared with the canvas."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Set
from typing import Any

from PySide6.QtCore import (
    QEvent,
    QItemSelection,
    QItemSelectionModel,
    QModelIndex,
    QPersistentModelIndex,
    QPoint,
    Qt,
    Signal,
)
from PySide6.QtGui import QKeyEvent, QShowEvent
from PySide6.QtWidgets import QAbstractItemView, QLineEdit, QStyledItemDelegate, QWidget

from app.views.panels.item_table.model import ItemModel, Sorted
from app.views.panels.item_table.row_table import RowTable

_ENTER = (Qt.Key.Key_Return, Qt.Key.Key_Enter)
_DELETE = (Qt.Key.Key_Delete, Qt.Key.Key_Backspace)
_ALONG = (Qt.Key.Key_Up, Qt.Key.Key_Down)


class NameDelegate(QStyledItemDelegate):
    """Editor of names that is not disturbed by updates."""

    def setEditorData(self, editor: QWidget, index: QModelIndex | QPersistentModelIndex) -> None:
        """Start with the present name; text that the user has typed is not overwritten."""
        if not (isinstance(editor, QLineEdit) and editor.isModified()):
            super().setEditorData(editor, index)


class ItemTable(RowTable):
    """Shows the items of a model, selects and names them.

    Parameters
    ----------
    rows : ItemModel
        The items.
    ordered : Sorted
        The same in the order shown.
    name : str
        Accessible name.
    """

    thing: str
    """What its rows are called in menus."""

    def __init__(self, rows: ItemModel[Any], ordered: Sorted, name: str) -> None:
        super().__init__(rows, ordered, rows.columns, rows.name_column, name)
        self._showing = False
        self._stale = False
        self._rows = rows
        self.setItemDelegate(NameDelegate(self))
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.EditKeyPressed)
        self.setMouseTracking(True)
        self.entered.connect(lambda index: self.hover(self._key(index)))
        self.doubleClicked.connect(
            lambda at: self._edit_name(at.row()) if at.column() == rows.name_column else self.zoom_wanted.emit()
        )
        self.selectionModel().selectionChanged.connect(self._report_selection)

    zoom_wanted = Signal()
    """The selected items are to be shown as large as possible."""

    @abstractmethod
    def hover(self, key: int | None) -> None:
        """Point at an item, or at none."""

    @abstractmethod
    def choose(self, keys: Iterable[int]) -> None:
        """Select items everywhere."""

    @abstractmethod
    def chosen(self) -> Set[int]:
        """Keys of the items that are selected."""

    @abstractmethod
    def remove(self) -> None:
        """Do to the selected items what the key Delete stands for."""

    def name_selected(self) -> None:
        """Edit the name in the selected row."""
        rows = self.selectionModel().selectedRows()
        if rows:
            self._edit_name(rows[0].row())

    def show_items(self) -> None:
        """Show the present items; a hidden table waits until it is seen, and takes no time from a run."""
        self._stale = not self.isVisible()
        if self._stale:
            return
        self._showing = True
        self._rows.refresh()
        self._showing = False
        self.show_selection()

    def show_selection(self) -> None:
        """Show which items are selected."""
        if self._stale:
            return
        wanted = self.chosen()
        if {self._key(index) for index in self.selectionModel().selectedRows()} == wanted:
            return
        rows = [row for key in wanted if (row := self._rows.row(key)) is not None]
        selection = QItemSelection()
        last = len(self._rows.columns) - 1
        for row in rows:
            first = self._sorted.mapFromSource(self._rows.index(row, 0))
            if first.isValid():  # else the row is not shown
                selection.select(first, first.siblingAtColumn(last))
        self._showing = True
        self.selectionModel().select(selection, QItemSelectionModel.SelectionFlag.ClearAndSelect)
        if rows and self.state() != QAbstractItemView.State.EditingState:
            at = self._sorted.mapFromSource(self._rows.index(rows[0], self._rows.name_column))
            self.selectionModel().setCurrentIndex(at, QItemSelectionModel.SelectionFlag.NoUpdate)
            self.scrollTo(at)
        self._showing = False

    def menu_at(self, point: QPoint | None) -> tuple[str, QPoint]:
        """The selected rows; a row at a point is selected first. See `MenuOwner`."""
        inside = self.viewport().mapFrom(self, point) if point is not None else None
        index = self.indexAt(inside) if inside is not None else self.currentIndex()
        if index.isValid() and not self.selectionModel().isRowSelected(index.row(), QModelIndex()):
            self.selectRow(index.row())
        place = self.viewport().mapTo(self, self.visualRect(index).center()) if point is None else point
        return self.thing if self.chosen() else "", place

    # Qt interface

    def event(self, event: QEvent) -> bool:
        """Handle the keys of the table before they act as shortcuts of the window."""
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent) and event.key() in _DELETE:
            event.accept()
            return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Edit the name on Enter, remove on Delete; an arrow key first selects the current row."""
        if event.key() in _ENTER:
            self._edit_name(self.currentIndex().row())
        elif event.key() in _DELETE:
            self.remove()
        elif event.key() in _ALONG and not self.chosen() and self.currentIndex().isValid():
            self.selectRow(self.currentIndex().row())
        else:
            super().keyPressEvent(event)

    def showEvent(self, event: QShowEvent) -> None:
        """Lay out the columns, and update the table if items have changed while it was hidden."""
        super().showEvent(event)
        if self._stale:
            self.show_items()

    def leaveEvent(self, event: QEvent) -> None:
        """Clear the highlight when the pointer leaves."""
        self.hover(None)
        super().leaveEvent(event)

    def _key(self, index: QModelIndex) -> int:
        return self._rows.key(self._sorted.mapToSource(index).row())

    def _edit_name(self, row: int) -> None:
        if row >= 0 and self.state() != QAbstractItemView.State.EditingState:
            self.edit(self._sorted.index(row, self._rows.name_column))

    def _report_selection(self) -> None:
        if not self._showing:
            self.choose(self._key(index) for index in self.selectionModel().selectedRows())
