"""The columns of a table that are shown: as many as its width has room for, and those that the person asks for."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QMenu, QTableView

from app.model.text.keys import with_keys
from app.model.text.language import tr
from app.views.panels.item_table.columns import Column

_PAD = 18
_ORDERS = ((tr("Smallest first"), Qt.SortOrder.AscendingOrder), (tr("Largest first"), Qt.SortOrder.DescendingOrder))


class ShownColumns:
    """Chooses and lays out the columns of a table.

    Where the table is too narrow for all, the last columns are hidden, so that nobody has to scroll sideways. A column
    that the person has shown or hidden by the menu of the header stays as asked.

    Parameters
    ----------
    table : QTableView
        The table, with its model.
    columns : sequence of Column
        All columns, those that matter most first.
    names : int
        Place of the column of names, which is always shown and takes the remaining width.
    """

    def __init__(self, table: QTableView, columns: Sequence[Column[Any]], names: int) -> None:
        self._table = table
        self._columns = columns
        self._names = names
        self._asked: dict[int, bool] = {}
        self._lay_out()

    def measure(self) -> None:
        """Make room for the whole titles; to be called when the table is seen and has its style."""
        header = self._table.horizontalHeader()
        for index, width in enumerate(self._widths):
            self._table.setColumnHidden(index, False)  # the title of a hidden column has no width
            self._widths[index] = max(width, header.sectionSizeHint(index))
            self._table.setColumnWidth(index, max(self._table.columnWidth(index), self._widths[index]))
        self.fit(self._table.viewport().width())

    def fit(self, width: int) -> None:
        """Show the columns for which there is room; the names take what remains."""
        room = width - self._widths[self._names]
        room -= sum(self._width(index) for index, shown in self._asked.items() if shown)
        for index in range(len(self._columns)):
            if index == self._names:
                continue
            shown = self._asked.get(index)
            if shown is None:
                room -= self._width(index)
                shown = room >= 0
            if shown == self._table.isColumnHidden(index):
                self._table.setColumnHidden(index, not shown)
        others = sum(self._table.columnWidth(index) for index in range(len(self._columns)) if index != self._names)
        self._table.setColumnWidth(self._names, max(self._widths[self._names], width - others))

    def _width(self, index: int) -> int:
        """Width of a column; that of a hidden one if it were shown."""
        return self._table.columnWidth(index) or self._widths[index]

    def _lay_out(self) -> None:
        header, breadth = self._table.horizontalHeader(), self._table.fontMetrics().horizontalAdvance
        header.setHighlightSections(False)
        header.setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        header.setMinimumSectionSize(44)
        self._widths = [breadth(column.sample) + _PAD for column in self._columns]
        self._widths[self._names] += 2 * _PAD
        for index, width in enumerate(self._widths):
            self._table.setColumnWidth(index, width)
        header.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        header.customContextMenuRequested.connect(self._show_menu)

    def _show_menu(self, point: QPoint) -> None:
        """Open the menu of the header: sort by a column, and choose which columns are shown."""
        header, table = self._table.horizontalHeader(), self._table
        menu = QMenu(table)
        at = header.logicalIndexAt(point)
        if at >= 0:
            for text, order in _ORDERS:
                menu.addAction(text).triggered.connect(partial(table.sortByColumn, at, order))
            menu.addSeparator()
        for index, column in enumerate(self._columns):
            shown = menu.addAction(str(table.model().headerData(index, Qt.Orientation.Horizontal)))
            shown.setToolTip(with_keys(column.tip))
            shown.setCheckable(True)
            shown.setChecked(not table.isColumnHidden(index))
            shown.setEnabled(index != self._names)
            shown.toggled.connect(partial(self._ask, index))
        menu.setToolTipsVisible(True)
        menu.aboutToHide.connect(menu.deleteLater)
        menu.popup(header.mapToGlobal(point))

    def _ask(self, index: int, shown: bool) -> None:
        self._asked[index] = shown
        self.fit(self._table.viewport().width())
