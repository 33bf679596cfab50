"""The table of objects; what is chosen in it is chosen on the canvas."""

from __future__ import annotations

from collections.abc import Iterable, Set

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeyEvent

from app.model.text.language import tr
from app.session.features.object_list import ObjectList
from app.session.session import Session
from app.views.panels.item_table.model import Sorted
from app.views.panels.item_table.view import ItemTable
from app.views.panels.object_table.model import ObjectModel


class ObjectTable(ItemTable):
    """Shows the objects of a list, chooses, names, classifies and removes them."""

    thing = "object"

    def __init__(self, session: Session, object_list: ObjectList) -> None:
        self._list = object_list
        rows = ObjectModel(session, object_list)
        super().__init__(rows, Sorted(rows), tr("Objects"))
        object_list.changed.connect(self.show_items)
        object_list.selection_changed.connect(self.show_selection)
        session.image_changed.connect(self.show_items)
        self.show_items()

    def hover(self, key: int | None) -> None:
        """Highlight an object on the canvas."""
        self._list.hover(key or 0)

    def choose(self, keys: Iterable[int]) -> None:
        """Choose objects."""
        self._list.choose(keys)

    def chosen(self) -> Set[int]:
        """Numbers of the chosen objects."""
        return self._list.chosen

    def remove(self) -> None:
        """Remove the chosen objects."""
        self._list.delete()

    # Qt interface

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Set the class by digits."""
        digit = event.key() - Qt.Key.Key_0
        if 1 <= digit <= len(self._list.objects.classes):
            self._list.classify(digit)
        else:
            super().keyPressEvent(event)
