"""The model of a table: one row per item, which stays in place as long as the item is there."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Container, Sequence
from typing import Any, Generic

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QObject, QPersistentModelIndex, QSortFilterProxyModel, Qt

from app.model.display.lengths import PixelSize
from app.model.text.keys import with_keys
from app.model.text.language import tr
from app.views.panels.item_table.columns import Column, Row, place

Index = QModelIndex | QPersistentModelIndex
Role = Qt.ItemDataRole

VALUE = Role.UserRole
"""Role of the sort key of a cell."""

_PX = "px"


class ItemModel(QAbstractTableModel, Generic[Row]):
    """Items as a table, of which names can be typed.

    Rows are identified by the keys of their items: an update changes their contents and preserves the selection, the
    order and a name that is being edited.
    """

    def __init__(self, columns: Sequence[Column[Row]], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.columns = columns
        self.name_column = place(columns, "name")
        self._items: list[Row] = []
        self._rows: dict[int, int] = {}
        self._unit = _PX
        self._factor = 1.0

    @abstractmethod
    def refresh(self) -> None:
        """Show the present items."""

    @abstractmethod
    def key_of(self, item: Row) -> int:
        """Key of an item."""

    @abstractmethod
    def name_of(self, item: Row) -> str:
        """Name of an item."""

    @abstractmethod
    def rename(self, key: int, name: str) -> None:
        """Give an item another name."""

    @abstractmethod
    def look(self, item: Row, role: int, of_name: bool) -> Any:
        """Icon, color or font of a cell, in the column of names or another."""

    def item(self, row: int) -> Row:
        """The item in a row."""
        return self._items[row]

    def key(self, row: int) -> int:
        """Key of the item in a row."""
        return self.key_of(self._items[row])

    def row(self, key: int) -> int | None:
        """Row of an item."""
        return self._rows.get(key)

    def update(self, items: Sequence[Row]) -> None:
        """Show these items: new ones at the end, the others where they are."""
        present = {self.key_of(item): item for item in items}
        self._drop(present)
        self._items = [present[self.key_of(item)] for item in self._items]
        if self._items:
            self.dataChanged.emit(self.index(0, 0), self.index(len(self._items) - 1, len(self.columns) - 1))
        new = [item for key, item in present.items() if key not in self._rows]
        if new:
            first = len(self._items)
            self.beginInsertRows(QModelIndex(), first, first + len(new) - 1)
            self._items += new
            self._number()
            self.endInsertRows()

    def use_unit(self, size: PixelSize) -> None:
        """Show lengths in the unit of the size of a pixel, which the headings name."""
        name = size.unit or (_PX if set(size.spacing) == {1.0} else tr("units"))
        if size.factor != self._factor:
            self._factor = size.factor
            self.dataChanged.emit(self.index(0, 0), self.index(len(self._items) - 1, len(self.columns) - 1))
        if name != self._unit:
            self._unit = name
            self.headerDataChanged.emit(Qt.Orientation.Horizontal, 0, len(self.columns) - 1)

    # Qt interface

    def rowCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008  # as Qt declares it
        """Number of items."""
        return 0 if parent.isValid() else len(self._items)

    def columnCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008  # as Qt declares it
        """Number of columns."""
        return 0 if parent.isValid() else len(self.columns)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = Role.DisplayRole) -> Any:
        """Headings with the unit of lengths, and their tooltips."""
        if orientation == Qt.Orientation.Vertical:
            return None
        column = self.columns[section]
        match role:
            case Role.DisplayRole:
                return column.title.format(unit=self._unit)
            case Role.ToolTipRole:
                return with_keys(column.tip)
            case Role.TextAlignmentRole if column.numeric:
                return Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        return None

    def data(self, index: Index, role: int = Role.DisplayRole) -> Any:
        """The text, sort key, icon and style of a cell."""
        item, column = self._items[index.row()], self.columns[index.column()]
        match role:
            case Role.DisplayRole:
                return column.shown(item, self._factor)
            case Role.EditRole:
                return self.name_of(item)
            case Role.UserRole:
                return column.value(item)
            case Role.TextAlignmentRole if column.numeric:
                return Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        return self.look(item, role, index.column() == self.name_column)

    def setData(self, index: Index, value: Any, role: int = Role.EditRole) -> bool:
        """Name an item."""
        if role != Role.EditRole or index.column() != self.name_column:
            return False
        self.rename(self.key(index.row()), str(value))
        return True

    def flags(self, index: Index) -> Qt.ItemFlag:
        """Names can be edited."""
        flags = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable
        return flags | Qt.ItemFlag.ItemIsEditable if index.column() == self.name_column else flags

    # Internal

    def _drop(self, present: Container[int]) -> None:
        """Remove the rows of items that have disappeared, adjacent rows in one operation."""
        gone = [row for row in range(len(self._items)) if self.key(row) not in present]
        while gone:
            last = first = gone.pop()
            while gone and gone[-1] == first - 1:
                first = gone.pop()
            self.beginRemoveRows(QModelIndex(), first, last)
            del self._items[first : last + 1]
            self._number()
            self.endRemoveRows()

    def _number(self) -> None:
        self._rows = {self.key_of(item): row for row, item in enumerate(self._items)}


class Sorted(QSortFilterProxyModel):
    """The same rows in the order of a column; equal ones by their number."""

    def __init__(self, model: QAbstractTableModel, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.setSourceModel(model)
        self.setSortRole(VALUE)
        self.setDynamicSortFilter(True)

    def lessThan(self, left: Index, right: Index) -> bool:
        """Whether one row comes before another."""
        model = self.sourceModel()
        one, other = model.data(left, VALUE), model.data(right, VALUE)
        if one != other:
            return bool(one < other)
        return bool(model.data(model.index(left.row(), 0), VALUE) < model.data(model.index(right.row(), 0), VALUE))
