"""The model of the table of objects: one row an object."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from PySide6.QtCore import QObject, Qt
from PySide6.QtGui import QColor, QGuiApplication, QPalette

from app.model.display.lengths import shown_in
from app.session.features.object_list import ObjectList
from app.session.session import Session
from app.views.panels.item_table.model import ItemModel, Role
from app.views.panels.object_table.columns import BODY_COLUMNS, OBJECT_COLUMNS, Row
from app.views.theme.icons import swatch


class ObjectModel(ItemModel[Row]):
    """Objects as a table; names that are typed go back to the list of objects."""

    def __init__(self, session: Session, object_list: ObjectList, parent: QObject | None = None) -> None:
        super().__init__(OBJECT_COLUMNS, parent)
        self._session = session
        self._list = object_list

    def refresh(self) -> None:
        """Show the present objects."""
        image, objects = self._session.image, self._list.objects
        size = shown_in(*((image.spacing, image.unit) if image is not None else ((1.0, 1.0), None)))
        columns = BODY_COLUMNS if image is not None and image.ndim == 3 else OBJECT_COLUMNS
        if columns is not self.columns:
            self.columns = columns
            self.headerDataChanged.emit(Qt.Orientation.Horizontal, 0, len(columns) - 1)
        self.update([Row(item, objects, size.spacing, self._list.figures(item), size.factor) for item in objects.items])
        self.use_unit(replace(size, factor=1.0))  # the rows hold lengths in this unit

    def key_of(self, item: Row) -> int:
        """Number of an object."""
        return item.item.number

    def name_of(self, item: Row) -> str:
        """Name of an object."""
        return item.item.name

    def rename(self, key: int, name: str) -> None:
        """Name an object."""
        self._list.rename(key, name)

    def look(self, item: Row, role: int, of_name: bool) -> Any:
        """The color of an object beside its name; hidden ones are pale."""
        match role:
            case Role.DecorationRole if of_name:
                return swatch(item.objects.color(item.item))
            case Role.ForegroundRole if item.item.hidden:
                return QColor(QGuiApplication.palette().color(QPalette.ColorRole.PlaceholderText))
        return None
