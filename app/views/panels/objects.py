"""The panel of the objects: the table, with what can be done to objects next to it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QGuiApplication, QKeyEvent, QPalette
from PySide6.QtWidgets import QMenu

from app.model.display.lengths import shown_in
from app.model.document.objects import class_title
from app.model.text.keys import with_keys
from app.model.text.language import tr
from app.session.features.object_list import Figures, ObjectList
from app.session.session import Session
from app.views.panels.tables import (
    Column,
    ItemTable,
    Role,
    Selection,
    TableModel,
    TablePanel,
    button_grid,
    menu_button,
    wide_button,
)
from app.views.theme.icons import swatch
from cpm_core.objects.segmented import SegmentedObject


@dataclass(frozen=True, eq=False, slots=True)
class ObjectRow:
    """An object with its class and color, the size of a pixel, and figures once they are known."""

    item: SegmentedObject
    category: str
    color: str
    spacing: tuple[float, ...]
    figures: Figures | None

    @property
    def state(self) -> str:
        """Whether it is frozen or hidden, in words."""
        words = ((self.item.frozen, tr("frozen")), (self.item.hidden, tr("hidden")))
        return ", ".join(word for holds, word in words if holds)


def _figure(get: Callable[[Figures], float | None]) -> Callable[[ObjectRow], float | None]:
    """A figure of an object; None while it is not known."""
    return lambda row: None if row.figures is None else get(row.figures)


def _area(row: ObjectRow) -> float:
    return row.item.area * row.spacing[0] * row.spacing[1]


OBJECT_COLUMNS: tuple[Column[ObjectRow], ...] = (
    Column("number", tr("#"), tr("Number; it stays the same."), lambda row: row.item.number, "0000", form=".0f"),
    Column("name", tr("Name"), tr("Name and color; double-click to rename."), lambda row: row.item.name,
           "left ventricle"),
    Column("class", tr("Class"), tr("Class; the digits 1 to 9 set it."), lambda row: row.category, "1  nucleus",
           key=lambda row: row.item.category),
    Column("area", tr("Net area [{unit}²]"), tr("Area without holes."), _area, "00,000,000", 2),
    Column("perimeter", tr("Perimeter [{unit}]"), tr("Length of the boundary, that of holes included."),
           lambda row: row.item.perimeter(row.spacing), "000,000", 1),
    Column("gray", tr("Mean gray"), tr("Mean gray value inside."), _figure(lambda found: found.gray), "000.0"),
    Column("gaps", tr("Bridged [{unit}]"), tr("Length of the boundary that follows no contour; dashed."),
           lambda row: row.item.bridged(row.spacing) if row.item.gaps else None, "0,000", 1),
    Column("confidence", tr("Confidence"), tr("How sure the boundary is, from 0 to 1."),
           lambda row: row.item.confidence, "0.00", form=".2f"),
    Column("state", tr("State"), tr("Frozen objects hold particles back and are not found again."),
           lambda row: row.state or None, "frozen"),
)  # fmt: skip
"""All columns in the order shown."""

_OF_BODIES: tuple[Column[ObjectRow], ...] = (
    Column("area", tr("Volume [{unit}³]"), tr("Volume without hollows."), _figure(lambda found: found.volume),
           "00,000,000", 3),
    Column("perimeter", tr("Area [{unit}²]"), tr("Area of the surface, that of hollows included."),
           _figure(lambda found: found.area), "000,000", 2),
    Column("gaps", tr("Surfaces"), tr("Number of closed surfaces that bound it: one more for each hollow."),
           _figure(lambda found: found.parts), "0,000", form=".0f"),
    Column("confidence", tr("Euler number"),
           tr("Euler characteristic of its surface: 2 for a sphere, 2 less for each handle."),
           _figure(lambda found: found.euler), "0.00", form=".0f"),
)  # fmt: skip

BODY_COLUMNS = tuple({**{one.name: one for one in OBJECT_COLUMNS}, **{one.name: one for one in _OF_BODIES}}.values())
"""The same columns for objects in a volume."""


class ObjectTable(ItemTable):
    """Shows the objects of a list, chooses, names, classifies and removes them."""

    def __init__(self, session: Session, object_list: ObjectList) -> None:
        self._session, self._list = session, object_list
        rows = TableModel[ObjectRow](OBJECT_COLUMNS, lambda row: row.item.number, _look, object_list.rename)
        selection = Selection(
            "object",
            self._refresh,
            lambda key: object_list.hover(key or 0),
            object_list.choose,
            lambda: object_list.chosen,
            object_list.delete,
        )
        super().__init__(rows, selection, tr("Objects"))
        object_list.changed.connect(self.show_items)
        object_list.selection_changed.connect(self.show_selection)
        session.image_changed.connect(self.show_items)
        self.show_items()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Set the class by digits."""
        digit = event.key() - Qt.Key.Key_0
        if 1 <= digit <= len(self._list.objects.classes):
            self._list.classify(digit)
        else:
            super().keyPressEvent(event)

    def _refresh(self) -> None:
        image, objects = self._session.image, self._list.objects
        spacing, unit = (image.spacing, image.unit) if image is not None else ((1.0, 1.0), None)
        rows = [
            ObjectRow(
                item,
                f"{item.category}  {class_title(objects, item.category)}",
                objects.color(item),
                spacing,
                self._list.figures(item),
            )
            for item in objects.items
        ]
        self.rows.update(rows, shown_in(spacing, unit), BODY_COLUMNS if len(spacing) == 3 else OBJECT_COLUMNS)


def _look(row: ObjectRow, role: int, of_name: bool) -> Any:
    """The color of an object next to its name; hidden ones are pale."""
    if role == Role.DecorationRole and of_name:
        return swatch(row.color)
    if role == Role.ForegroundRole and row.item.hidden:
        return QColor(QGuiApplication.palette().color(QPalette.ColorRole.PlaceholderText))
    return None


class ObjectPanel(TablePanel[ObjectTable]):
    """Shows the objects; `fill_classes` fills a menu with the classes on offer."""

    def __init__(self, session: Session, object_list: ObjectList, fill_classes: Callable[[QMenu], None]) -> None:
        table = ObjectTable(session, object_list)
        super().__init__(table)
        self._list = object_list
        self.buttons = {
            "class": menu_button(tr("Class"), fill_classes),
            "name": wide_button(tr("Name…"), table.name_selected),
            "freeze": wide_button(tr("Freeze"), object_list.toggle_frozen),
            "hide": wide_button(tr("Hide"), object_list.toggle_hidden),
            "merge": wide_button(tr("Merge"), object_list.merge),
            "delete": wide_button(tr("Delete"), object_list.delete),
        }
        self.add(button_grid(self.buttons.values()))
        object_list.changed.connect(self.show_keys)
        object_list.selection_changed.connect(self.show_keys)
        session.image_changed.connect(self.show_keys)
        self.show_keys()

    def show_keys(self) -> None:
        """Show what can be done now, by which keys."""
        items, chosen = self._list.objects.items, self._list.items
        nothing = with_keys(tr("No objects yet. Take the tool Select objects ({key:objects}) and click in one."))
        some = tr("1 object.") if len(items) == 1 else tr("{count} objects.").format(count=len(items))
        self.summary.setText(some if items else nothing)
        for name, button in self.buttons.items():
            button.setEnabled(len(chosen) > 1 if name == "merge" else bool(chosen) or (name == "class" and bool(items)))
        self.buttons["freeze"].setText(tr("Release") if chosen and all(i.frozen for i in chosen) else tr("Freeze"))
        self.buttons["hide"].setText(tr("Show") if chosen and all(item.hidden for item in chosen) else tr("Hide"))
