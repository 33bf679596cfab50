"""Menu Objects: the table of the objects, their classes, and their use in the next run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
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
from app.views.window.feature import Feature, FeatureContext, Panel
from app.views.window.keyboard import Keys
from cpm_core.numerics import Position
from cpm_core.objects.segmented import SegmentedObject

_ENTER = (Qt.Key.Key_Return, Qt.Key.Key_Enter)


class ObjectsFeature(Feature):
    """Objects by menus and keys, and their table."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self._list = context.workspace.object_list
        self._selection = context.workspace.object_selection
        self.panel = ObjectPanel(context.session, self._list, self._fill_classes)
        context.preferences.follow(UNIT, self.panel.table.show_items)
        self.name_field = NameField(context.canvas_area.canvas, tr("Name of the object"))
        context.session.image_changed.connect(self.name_field.leave)
        Keys(context.canvas_area.canvas, self.take_key)
        self.panel.table.zoom_wanted.connect(context.canvas_area.zoom_to_selection)
        self._list.selection_changed.connect(context.refresh)
        self._selection.changed.connect(context.refresh)
        self._selection.taken.connect(self._name_taken)

    def action_specs(self) -> Sequence[ActionSpec | Submenu]:
        """Table, what is offered, and what is done to the chosen objects."""
        table = ActionSpec("object_table", "Objects", tr("&Table of objects"),
                           tr("Show the classes and the measures of the objects."),
                           lambda: self.context.areas().enter("objects"), "Ctrl+Shift+O")  # fmt: skip
        take = ActionSpec("take_object", "Objects", tr("&Accept what is offered"),
                          tr("Make an object of what is offered; Enter does the same on the image."),
                          self._selection.take, gap=True,
                          when=lambda situation: bool(self._selection.proposals))  # fmt: skip
        change = ActionSpec("change_object", "Objects", tr("&Change by clicks"),
                            tr("Select the object again, beginning with what it is."), self._change,
                            when=self._one)  # fmt: skip
        fit = ActionSpec("fit_objects", "Objects", tr("F&it to the contours"),
                         tr("Select the chosen objects again by their own clicks, on the contours of the last "
                         "run."), lambda: self.context.workspace.object_selection.fit(self._list.chosen),
                         when=self._any_chosen)  # fmt: skip
        alike = ActionSpec("objects_alike", "Objects", tr("All &like this"),
                           tr("Find all objects like the chosen one; touching ones are parted."),
                           lambda: self.context.workspace.object_selection.find_like(self._list.items[0].number),
                           "Ctrl+L", when=self._one)  # fmt: skip
        every = ActionSpec("all_objects", "Objects", tr("Choose all ob&jects"), tr("Choose all objects."),
                           lambda: self._list.choose(item.number for item in self._list.objects.items), "Ctrl+Alt+A",
                           when=lambda situation: bool(situation.document.objects.items))  # fmt: skip
        return (table, take, change, alike, fit, every, *self._states(), *self._uses())

    def _states(self) -> Sequence[ActionSpec | Submenu]:
        chosen = self._list
        return (
            ActionSpec("name_object", "Objects", tr("&Name…"), tr("Give the chosen object a name."), self.ask_name,
                       gap=True, when=self._any_chosen),
            Submenu(name="object_class", menu="Objects", text=tr("C&lass"), fill=self._fill_classes),
            Submenu(name="object_color", menu="Objects", text=tr("C&olor"), fill=self._fill_colors),
            self._state("freeze_object", tr("&Freeze"), tr("R&elease"), chosen.toggle_frozen,
                        tr("Keep the objects as they are, and let particles not cross their boundaries."),
                        lambda: all(item.frozen for item in chosen.items)),
            self._state("hide_object", tr("&Hide"), tr("&Show"), chosen.toggle_hidden,
                        tr("Hide the objects, or show them again."),
                        lambda: all(item.hidden for item in chosen.items)),
            ActionSpec("merge_objects", "Objects", tr("&Merge"), tr("Make one object of the chosen ones."),
                       chosen.merge, when=lambda situation: len(chosen.chosen) > 1),
            ActionSpec("delete_object", "Objects", tr("&Delete"), tr("Remove the chosen objects."), chosen.delete,
                       when=self._any_chosen),
        )  # fmt: skip

    def _state(
        self, name: str, text: str, other: str, do: Callable[[], None], tip: str, holds: Callable[[], bool]
    ) -> ActionSpec:
        """An action that is called otherwise where all chosen objects are in the state already."""

        def worded(_: Situation) -> str:
            return other if self._list.chosen and holds() else text

        return ActionSpec(name, "Objects", text, tip, do, when=self._any_chosen, worded=worded)

    def _uses(self) -> Sequence[ActionSpec]:
        chosen = self._list
        uses = (
            ("object_start", tr("&Start from the outline"), chosen.as_starts,
             tr("Start the next run on the outlines of the chosen objects too.")),
            ("object_region", tr("Use as region of &interest"), chosen.as_regions,
             tr("Hold the particles inside the chosen objects.")),
            ("object_barrier", tr("Use as &barrier"), chosen.as_barriers,
             tr("Hold the particles back at the boundaries of the chosen objects.")),
        )  # fmt: skip
        return [
            ActionSpec(name, "Objects", text, tip, do, gap=name == "object_start", when=self._any_chosen)
            for name, text, do, tip in uses
        ]  # fmt: skip

    def panels(self) -> Sequence[Panel]:
        """The table."""
        return (
            Panel(name="objects", title=tr("Objects"), widget=self.panel, area="bottom", tab="below", shown=False,
                  height=160, shortcut="F10"),
        )  # fmt: skip

    def use_keys(self) -> None:
        """Name the keys as they are now."""
        self.panel.show_keys()

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
        drawn = self.context.canvas_area.canvas.drawn.document.objects.items
        shown = next((each for each in drawn if each.number == item.number), None)
        if shown is None:
            seen = self.context.canvas_area.canvas.view.viewRect().center()
            return seen.y(), seen.x()
        return min(row for curve in shown.boundary for row, _ in curve), shown.center[1]

    def take_key(self, event: QKeyEvent) -> bool:
        """Handle the keys for chosen objects on the canvas; return whether the key was one of them."""
        tool, crosshair = self.context.canvas_area.canvas.hold.tool, self.context.canvas_area.crosshair
        if tool is None or event.modifiers() & ~Qt.KeyboardModifier.KeypadModifier:
            return False
        key, digit = event.key(), event.key() - Qt.Key.Key_0
        if tool.name != "objects":
            offered = bool(self._selection.proposals) and not (self._selection.selecting or tool.drafting)
            if key in _ENTER and offered and crosshair.at is None:
                self._selection.take()
                return True
            return False
        if 1 <= digit <= len(self._list.objects.classes):
            self._list.classify(digit)
            return True
        if not self._list.chosen:
            return False
        if key == Qt.Key.Key_Delete:
            self._list.delete()
            return True
        if key in _ENTER and not tool.drafting and crosshair.at is None:
            self.ask_name()
            return True
        return False

    def _name_taken(self, numbers: tuple[int, ...]) -> None:
        """Ask for the name of an object that has been taken."""
        self._list.choose(numbers)
        if len(numbers) == 1:
            self.ask_name()

    def _change(self) -> None:
        self.context.canvas_area.use_tool("objects")
        self._list.begin_change(self._list.items[0].number)

    def _fill_classes(self, menu: QMenu) -> None:
        objects = self._list.objects
        for category, known in enumerate(objects.classes, start=1):
            text = f"{class_title(objects, category)}\t{category}"
            action = menu.addAction(swatch(known.color), text)
            action.setCheckable(True)
            action.setChecked(category == objects.category)
            action.triggered.connect(partial(self._list.classify, category))
        menu.addSeparator()
        menu.addAction(tr("Name this class…")).triggered.connect(self._name_class)
        menu.addAction(tr("Color of this class…")).triggered.connect(self._paint_class)

    def _fill_colors(self, menu: QMenu) -> None:
        fill_colors(menu, self.context.window, self._list.paint)
        for action in menu.actions():
            action.setEnabled(bool(self._list.chosen))

    def _name_class(self) -> None:
        objects = self._list.objects
        known = objects.classes[objects.category - 1]
        label = tr("Name of class {number}:").format(number=objects.category)
        button = tr("Use this name")
        name = ask_for_text(self.context.window, tr("Name of the class"), label, button, known.name)
        if name is not None:
            self._list.name_class(objects.category, name)

    def _paint_class(self) -> None:
        objects = self._list.objects
        known = objects.classes[objects.category - 1]
        color = QColorDialog.getColor(known.color, self.context.window, tr("Color of the class"))
        if color.isValid():
            self._list.name_class(objects.category, known.name, color.name())

    def _any_chosen(self, situation: Situation) -> bool:
        return bool(self._list.chosen)

    def _one(self, situation: Situation) -> bool:
        return len(self._list.chosen) == 1
