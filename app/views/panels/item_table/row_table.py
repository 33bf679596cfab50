"""A table whose columns are shown as far as there is room for them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from PySide6.QtCore import QAbstractTableModel, Qt
from PySide6.QtGui import QResizeEvent, QShowEvent
from PySide6.QtWidgets import QAbstractItemView, QTableView

from app.views.panels.item_table.columns import Column, place
from app.views.panels.item_table.model import Sorted
from app.views.panels.item_table.shown_columns import ShownColumns

LEAST = 48
"""Minimum height of a table, and of what stands beside it [px]."""


class RowTable(QTableView):
    """Shows rows that are sorted by a click on a heading.

    Parameters
    ----------
    rows : QAbstractTableModel
        The rows.
    ordered : Sorted
        The same in the order shown.
    columns : sequence of Column
        The columns.
    names : int
        Number of the column of names, as for `ShownColumns`.
    name : str
        Accessible name.
    """

    def __init__(
        self, rows: QAbstractTableModel, ordered: Sorted, columns: Sequence[Column[Any]], names: int, name: str
    ) -> None:
        super().__init__()
        self._sorted = ordered
        self._names = columns
        rows.setParent(self)
        ordered.setParent(self)
        self.setModel(ordered)
        self.setAccessibleName(name)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSortingEnabled(True)
        self.sortByColumn(0, Qt.SortOrder.AscendingOrder)
        self.setShowGrid(False)
        self.setAlternatingRowColors(True)
        self.setWordWrap(False)
        self.setTabKeyNavigation(False)
        self.setMinimumHeight(LEAST)
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(self.fontMetrics().height() + 8)
        self._columns = ShownColumns(self, columns, names)

    def column(self, name: str) -> list[str]:
        """The texts of a column, from top to bottom."""
        number = place(self._names, name)
        return [str(self._sorted.index(row, number).data()) for row in range(self._sorted.rowCount())]

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Show the columns for which there is room."""
        self._columns.fit(event.size().width())
        super().resizeEvent(event)

    def showEvent(self, event: QShowEvent) -> None:
        """Lay out the columns."""
        super().showEvent(event)
        self._columns.measure()
