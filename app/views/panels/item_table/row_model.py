"""The model of a table of which nothing is edited."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Generic

from PySide6.QtCore import QAbstractTableModel, QModelIndex, Qt

from app.model.display.lengths import PixelSize
from app.views.panels.item_table.columns import Column, Row
from app.views.panels.item_table.model import VALUE, Index, Role


class RowModel(QAbstractTableModel, Generic[Row]):
    """Rows in columns, with headings, tooltips and sort keys."""

    def __init__(self, columns: Sequence[Column[Row]]) -> None:
        super().__init__()
        self._columns = columns
        self._rows: Sequence[Row] = ()
        self._size = PixelSize((1.0, 1.0), None)

    def show_rows(self, rows: Sequence[Row], size: PixelSize | None = None) -> None:
        """Show these rows, with lengths in the unit of a size of a pixel."""
        self.beginResetModel()
        self._rows, self._size = rows, size or self._size
        self.endResetModel()

    def row(self, number: int) -> Row:
        """The row of a number."""
        return self._rows[number]

    def rowCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008  # as Qt declares it
        """Number of rows."""
        return 0 if parent.isValid() else len(self._rows)

    def columnCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008  # as Qt declares it
        """Number of columns."""
        return 0 if parent.isValid() else len(self._columns)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = Role.DisplayRole) -> Any:
        """Headings with the unit of lengths, and their tooltips."""
        if orientation == Qt.Orientation.Vertical:
            return None
        if role == Role.DisplayRole:
            return self._columns[section].title.format(unit=self._size.unit or "px")
        return self._columns[section].tip if role == Role.ToolTipRole else None

    def data(self, index: Index, role: int = Role.DisplayRole) -> Any:
        """Text, sort key and alignment of a cell."""
        column, row = self._columns[index.column()], self._rows[index.row()]
        if role in (Role.DisplayRole, Role.ToolTipRole):
            return column.shown(row, self._size.factor)
        if role == VALUE:
            return column.value(row)
        if role == Role.TextAlignmentRole and column.numeric:
            return Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        return None
