"""The model of the table of objects: one row an object."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QObject, QPersistentModelIndex, Qt
from PySide6.QtGui import QColor, QGuiApplication, QPalette

from app.session.features.objects.object_list import ObjectList
from app.session.session import Session
from app.views.panels.object_table.columns import NAME, OBJECT_COLUMNS, Row
from app.views.theme.icons import swatch

Index = QModelIndex | QPersistentModelIndex
Role = Qt.ItemDataRole


class ObjectModel(QAbstractTableModel):
    """Objects as a table; names that are typed go back to the list of objects."""

    def __init__(self, session: Session, object_list: ObjectList, parent: QObject) -> None:
        super().__init__(parent)
        self._session = session
        self._list = object_list
        self._shown: list[Row] = []
        self._unit = "px"

    def number(self, row: int) -> int:
        """Number of the object in a row."""
        return self._shown[row].item.number

    def row(self, number: int) -> int | None:
        """Row of an object."""
        return next((row for row, shown in enumerate(self._shown) if shown.item.number == number), None)

    def refresh(self) -> None:
        """Show the present objects."""
        image, objects = self._session.image, self._list.objects
        spacing = image.spacing if image is not None else (1.0, 1.0)
        rows = [Row(item, objects, spacing, self._list.gray(item)) for item in objects.items]
        if [row.item.number for row in rows] == [row.item.number for row in self._shown]:
            self._shown = rows
            if rows:
                self.dataChanged.emit(self.index(0, 0), self.index(len(rows) - 1, len(OBJECT_COLUMNS) - 1))
        else:
            self.beginResetModel()
            self._shown = rows
            self.endResetModel()
        unit = (image.unit if image is not None else None) or ("px" if set(spacing) == {1.0} else "units")
        if unit != self._unit:
            self._unit = unit
            self.headerDataChanged.emit(Qt.Orientation.Horizontal, 0, len(OBJECT_COLUMNS) - 1)

    # Qt interface

    def rowCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008  # as Qt declares it
        """Number of objects."""
        return 0 if parent.isValid() else len(self._shown)

    def columnCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008  # as Qt declares it
        """Number of columns."""
        return 0 if parent.isValid() else len(OBJECT_COLUMNS)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = Role.DisplayRole) -> Any:
        """Headings with the unit of lengths, and their tooltips."""
        if orientation == Qt.Orientation.Vertical:
            return None
        column = OBJECT_COLUMNS[section]
        match role:
            case Role.DisplayRole:
                return column.title.format(unit=self._unit)
            case Role.ToolTipRole:
                return column.tip
            case Role.TextAlignmentRole if column.numeric:
                return Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        return None

    def data(self, index: Index, role: int = Role.DisplayRole) -> Any:
        """The text, sort key, icon and style of a cell."""
        row, column = self._shown[index.row()], OBJECT_COLUMNS[index.column()]
        match role:
            case Role.DisplayRole:
                return column.text(row)
            case Role.EditRole:
                return row.item.name
            case Role.UserRole:
                return column.value(row)
            case Role.TextAlignmentRole if column.numeric:
                return Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
            case Role.DecorationRole if index.column() == NAME:
                return swatch(row.objects.color(row.item))
            case Role.ForegroundRole if row.item.hidden:
                return QColor(QGuiApplication.palette().color(QPalette.ColorRole.PlaceholderText))
        return None

    def setData(self, index: Index, value: Any, role: int = Role.EditRole) -> bool:
        """Name an object."""
        if role != Role.EditRole or index.column() != NAME:
            return False
        self._list.rename(self.number(index.row()), str(value))
        return True

    def flags(self, index: Index) -> Qt.ItemFlag:
        """Names can be edited."""
        flags = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable
        return flags | Qt.ItemFlag.ItemIsEditable if index.column() == NAME else flags
