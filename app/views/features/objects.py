"""Menu Objects: the table of the objects, their classes, and their use in the next run."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QColorDialog, QMenu

from app.model.document.objects import class_title
from app.model.preferences.table import UNIT
from app.model.state.situation import Situation
from app.model.text.language import tr
from app.views.canvas.naming import NameField
from app.views.panels.objects import ObjectPanel
from app.views.theme.icons import fill_colors, swatch
from app.views.widgets.actions import ActionSpec, Submenu
from app.views.window.dialogs import ask_for_text
from app.views.window.docks import Panel
from app.views.window.keyboard import Keys
from app.views.window.window import Feature, MainWindow
from cpm_core.numerics import Position
from cpm_core.objects.segmented import SegmentedObject

_ENTER = (Qt.Key.Key_Return, Qt.Key.Key_Enter)


class ObjectsFeature(Feature):
    """Objects by menus and keys, and their table."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        area = window.canvas_area
        self._list = objects = window.workspace.object_list
        self._selection = selection = window.workspace.object_selection
        self.panel = ObjectPanel(window.session, objects, self._fill_classes)
        self.panels = (Panel("objects", "Objects", self.panel, "F10"),)
        window.preferences.follow(UNIT, self.panel.table.show_items)
        window.shortcuts.changed.connect(self.panel.show_keys)
        self.name_field = NameField(area.canvas, tr("Name of the object"))
        window.session.image_changed.connect(self.name_field.leave)
        Keys(area.canvas, self.take_key)
        self.panel.table.zoom_wanted.connect(area.zoom_to_selection)
        objects.selection_changed.connect(window.refresh)
        selection.changed.connect(window.refresh)
        selection.accepted.connect(objects.choose)

        def some(_: Situation) -> bool:
            return bool(objects.chosen)

        def one(_: Situation) -> bool:
            return len(objects.chosen) == 1

        def all_are(state: str) -> bool:
            return bool(objects.chosen) and all(getattr(item, state) for item in objects.items)

        self.actions = (
            ActionSpec("object_table", "Objects", "&Table of objects",
                       "Show the classes and the measures of the objects.", lambda: window.docks.enter("objects"),
                       "Ctrl+Shift+O"),
            ActionSpec("take_object", "Objects", "&Accept what is offered",
                       "Make an object of what is offered; Enter does the same on the image.", selection.accept,
                       gap=True, when=lambda _: bool(selection.proposals)),
            ActionSpec("change_object", "Objects", "&Change by clicks",
                       "Select the object again, beginning with what it is.", self._change, when=one),
            ActionSpec("fit_objects", "Objects", "F&it to the contours",
                       "Select the chosen objects again by their own clicks, on the contours of the last run.",
                       lambda: selection.fit(objects.chosen), when=some),
            ActionSpec("objects_alike", "Objects", "All &like this",
                       "Find all objects like the chosen one; touching ones are parted.",
                       lambda: selection.find_like(objects.items[0].number), "Ctrl+L", when=one),
            ActionSpec("all_objects", "Objects", "Choose all ob&jects", "Choose all objects.",
                       lambda: objects.choose(item.number for item in objects.objects.items), "Ctrl+Alt+A",
                       when=lambda situation: bool(situation.document.objects.items)),
            ActionSpec("name_object", "Objects", "&Name…", "Give the chosen object a name.", self.ask_name, gap=True,
                       when=some),
            Submenu("object_class", "Objects", "C&lass", self._fill_classes),
            Submenu("object_color", "Objects", "C&olor",
                    lambda menu: fill_colors(menu, window, objects.paint, bool(objects.chosen))),
            ActionSpec("freeze_object", "Objects", "&Freeze",
                       "Keep the objects as they are, and let particles not cross their boundaries.",
                       objects.toggle_frozen, when=some,
                       worded=lambda _: tr("R&elease") if all_are("frozen") else tr("&Freeze")),
            ActionSpec("hide_object", "Objects", "&Hide", "Hide the objects, or show them again.",
                       objects.toggle_hidden, when=some,
                       worded=lambda _: tr("&Show") if all_are("hidden") else tr("&Hide")),
            ActionSpec("merge_objects", "Objects", "&Merge", "Make one object of the chosen ones.", objects.merge,
                       when=lambda _: len(objects.chosen) > 1),
            ActionSpec("delete_object", "Objects", "&Delete", "Remove the chosen objects.", objects.delete, when=some),
            ActionSpec("object_start", "Objects", "&Start from the outline",
                       "Start the next run on the outlines of the chosen objects too.", objects.as_starts, gap=True,
                       when=some),
            ActionSpec("object_region", "Objects", "Use as region of &interest",
                       "Hold the particles inside the chosen objects.", objects.as_regions, when=some),
            ActionSpec("object_barrier", "Objects", "Use as &barrier",
                       "Hold the particles back at the boundaries of the chosen objects.", objects.as_barriers,
                       when=some),
        )  # fmt: skip

    def ask_name(self) -> None:
        """Ask for the name of the chosen object, in the table if it has the focus, else on the canvas."""
        chosen = self._list.items
        if self.panel.table.hasFocus():
            self.panel.table.name_selected()
        elif chosen:
            item = chosen[0]
            accept = partial(self._list.rename, item.number)
            self.name_field.ask(self._above(item), item.name, accept, above=True)

    def _above(self, item: SegmentedObject) -> Position:
        """The place above an object on the canvas; of one that the slice does not cut, the middle of what is seen."""
        drawn = self.window.canvas_area.canvas.drawn.document.objects.items
        shown = next((each for each in drawn if each.number == item.number), None)
        if shown is None:
            seen = self.window.canvas_area.canvas.view.viewRect().center()
            return seen.y(), seen.x()
        return min(row for curve in shown.boundary for row, _ in curve), shown.center[1]

    def take_key(self, event: QKeyEvent) -> bool:
        """Handle the keys for chosen objects on the canvas; return whether the key was one of them."""
        tool, crosshair = self.window.canvas_area.canvas.hold.tool, self.window.canvas_area.crosshair
        if tool is None or event.modifiers() & ~Qt.KeyboardModifier.KeypadModifier:
            return False
        key, chosen = event.key(), self._list
        digit, entered = key - Qt.Key.Key_0, key in _ENTER and crosshair.at is None and not tool.drafting
        if tool.name != "objects":
            return False
        if 1 <= digit <= len(chosen.objects.classes):
            chosen.classify(digit)
        elif chosen.chosen and key == Qt.Key.Key_Delete:
            chosen.delete()
        elif chosen.chosen and entered:
            self.ask_name()
        else:
            return False
        return True

    def _change(self) -> None:
        self.window.canvas_area.use_tool("objects")
        self._selection.correct(self._list.items[0].number)

    def _fill_classes(self, menu: QMenu) -> None:
        objects = self._list.objects
        for category, known in enumerate(objects.classes, start=1):
            text = f"{class_title(objects, category)}\t{category}"
            action = menu.addAction(swatch(known.color), text)
            action.setCheckable(True)
            action.setChecked(category == objects.category)
            action.triggered.connect(partial(self._list.classify, category))
        menu.addSeparator()
        number = objects.category
        chosen = objects.classes[number - 1]

        def rename() -> None:
            label, button = tr("Name of class {number}:").format(number=number), tr("Use this name")
            name = ask_for_text(self.window, tr("Name of the class"), label, button, chosen.name)
            if name is not None:
                self._list.name_class(number, name)

        def paint() -> None:
            color = QColorDialog.getColor(chosen.color, self.window, tr("Color of the class"))
            if color.isValid():
                self._list.name_class(number, chosen.name, color.name())

        menu.addAction(tr("Name this class…")).triggered.connect(rename)
        menu.addAction(tr("Color of this class…")).triggered.connect(paint)
