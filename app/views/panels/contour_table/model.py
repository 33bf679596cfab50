"""The model of the contour table: one row per contour, which stays in place as long as the contour is found again."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QObject, QPersistentModelIndex, QSortFilterProxyModel, Qt
from PySide6.QtGui import QColor, QFont, QGuiApplication, QPalette

from app.session.features.contour_review import ContourReview
from app.session.scene import Item
from app.views.panels.contour_table.columns import COLUMNS, NAME
from app.views.theme import theme
from app.views.theme.icons import swatch

Index = QModelIndex | QPersistentModelIndex
Role = Qt.ItemDataRole

VALUE = Role.UserRole
"""Role of the sort key of a cell."""

_PX = "px"


class ContourModel(QAbstractTableModel):
    """Contours of a review as a table; names that are typed go back to the review.

    Rows are identified by the keys of their contours: a reconstruction updates their contents and preserves the
    selection, the order and a name that is being edited.
    """

    def __init__(self, review: ContourReview, parent: QObject) -> None:
        super().__init__(parent)
        self._review = review
        self._items: list[Item] = []
        self._rows: dict[int, int] = {}
        self._unit = _PX

    def key(self, row: int) -> int:
        """Key of the contour in a row."""
        return self._items[row].key

    def row(self, key: int) -> int | None:
        """Row of a contour."""
        return self._rows.get(key)

    def refresh(self) -> None:
        """Show the present contours."""
        present = {item.key: item for item in self._review.items}
        self._drop(present.keys())
        self._items = [present[item.key] for item in self._items]
        if self._items:
            self.dataChanged.emit(self.index(0, 0), self.index(len(self._items) - 1, len(COLUMNS) - 1))
        new = [item for item in self._review.items if item.key not in self._rows]
        if new:
            first = len(self._items)
            self.beginInsertRows(QModelIndex(), first, first + len(new) - 1)
            self._items += new
            self._number()
            self.endInsertRows()
        self._use_unit()

    # Qt interface

    def rowCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008  # as Qt declares it
        """Number of contours."""
        return 0 if parent.isValid() else len(self._items)

    def columnCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008  # as Qt declares it
        """Number of columns."""
        return 0 if parent.isValid() else len(COLUMNS)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = Role.DisplayRole) -> Any:
        """Headings with the unit of lengths, and their tooltips."""
        if orientation == Qt.Orientation.Vertical:
            return None
        column = COLUMNS[section]
        if role == Role.DisplayRole:
            return column.title.format(unit=self._unit)
        if role == Role.ToolTipRole:
            return column.tip
        if role == Role.TextAlignmentRole and column.numeric:
            return Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        return None

    def data(self, index: Index, role: int = Role.DisplayRole) -> Any:
        """The text, sort key, icon and style of a cell."""
        item, column = self._items[index.row()], COLUMNS[index.column()]
        match role:
            case Role.DisplayRole:
                return column.text(item)
            case Role.EditRole:
                return item.contour.name
            case Role.UserRole:
                return column.value(item)
            case Role.TextAlignmentRole if column.numeric:
                return Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
            case Role.DecorationRole if index.column() == NAME:
                return swatch(item.contour.color or (theme.CLOSED if item.contour.closed else theme.OPEN))
            case Role.ForegroundRole if item.reviewed.rejected:
                return QColor(QGuiApplication.palette().color(QPalette.ColorRole.PlaceholderText))
            case Role.FontRole if item.reviewed.rejected:
                font = QFont()
                font.setStrikeOut(index.column() == NAME)
                return font
        return None

    def setData(self, index: Index, value: Any, role: int = Role.EditRole) -> bool:
        """Name a contour."""
        if role != Role.EditRole or index.column() != NAME:
            return False
        self._review.rename(self.key(index.row()), str(value))
        return True

    def flags(self, index: Index) -> Qt.ItemFlag:
        """Names can be edited."""
        flags = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable
        return flags | Qt.ItemFlag.ItemIsEditable if index.column() == NAME else flags

    # Internal

    def _drop(self, present: Any) -> None:
        """Remove the rows of contours that have disappeared, adjacent rows in one operation."""
        gone = [row for row, item in enumerate(self._items) if item.key not in present]
        while gone:
            last = first = gone.pop()
            while gone and gone[-1] == first - 1:
                first = gone.pop()
            self.beginRemoveRows(QModelIndex(), first, last)
            del self._items[first : last + 1]
            self._number()
            self.endRemoveRows()

    def _number(self) -> None:
        self._rows = {item.key: row for row, item in enumerate(self._items)}

    def _use_unit(self) -> None:
        result = self._review.result
        if result is None:
            return
        unit = result.unit or (_PX if set(result.spacing) == {1.0} else "units")
        if unit != self._unit:
            self._unit = unit
            self.headerDataChanged.emit(Qt.Orientation.Horizontal, 0, len(COLUMNS) - 1)


class Sorted(QSortFilterProxyModel):
    """The same rows in the order of a column; equal ones by their number."""

    def __init__(self, model: QAbstractTableModel, parent: QObject) -> None:
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
