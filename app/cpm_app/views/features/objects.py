"""Menu Objects: actions on objects and proposals, and their panel."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import Qt
from PySide6.QtGui import QCursor, QKeyEvent
from PySide6.QtWidgets import QAbstractItemView, QLineEdit, QMenu

from cpm_app.model.document.modes import switch_to_skeleton
from cpm_app.model.document.objects import (
    add_objects_as_barriers,
    add_objects_as_regions,
    add_objects_as_starts,
    class_title,
    list_classes,
)
from cpm_app.model.preferences.table import UNIT_PREFERENCE
from cpm_app.model.state.situation import Situation, has_contours, has_image, has_volume
from cpm_app.model.text.language import tr
from cpm_app.session.features.object_rows import ItemKey
from cpm_app.session.session_messages import EDITING_CATEGORY
from cpm_app.views.panels.objects import ObjectPanel
from cpm_app.views.theme.icons import create_swatch, fill_colors
from cpm_app.views.widgets.actions import ActionSpec, Submenu, add_menu_action
from cpm_app.views.widgets.containers import DELETE_KEYS
from cpm_app.views.window.docks import Panel
from cpm_app.views.window.keyboard import KeyFilter, TypedAhead
from cpm_app.views.window.window import Feature
from cpm_core.medial_axis import SkeletonTarget
from cpm_core.numerics.polyline import as_line
from cpm_core.numerics.types import Callback


class ObjectsFeature(Feature):
    """Actions on objects and proposals by menu and keys, and their panel."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        window, area = self.window, self.window.canvas_area
        self._object_list = objects = window.workspace.object_list
        self._commands = commands = window.workspace.object_commands
        brush = window.workspace.object_brush
        self._selection = selection = window.workspace.object_selection
        self.panel = ObjectPanel(window.workspace)
        self.panels = (Panel("objects", "Objects", self.panel, "Ctrl+Shift+O"),)
        window.preferences.call_on_change(UNIT_PREFERENCE, self.panel.table.show_items)
        KeyFilter(area.canvas, self.handle_key)
        area.canvas.double_clicked.connect(self._on_double_clicked)
        self.panel.table.zoom_wanted.connect(area.zoom_to_selection)
        area.tool_changed.connect(lambda: self.panel.brush.setVisible(area.canvas.dispatcher.tool.name == "mend"))
        area.canvas.pointer_place_changed.connect(lambda at: objects.set_hovered_item(None) if at is None else None)
        for changed in (objects.selection_changed, brush.changed):
            changed.connect(lambda *_: window.refresh_actions())
        selection.changed.connect(window.refresh_actions)

        def in_order(action: Callback) -> Callback:
            return partial(selection.do_in_order, action)

        def has_rows(_: Situation) -> bool:
            return bool(objects.selected_rows) or selection.has_waiting_actions

        def has_objects(_: Situation) -> bool:
            return bool(objects.selected_numbers) or selection.has_waiting_actions

        def has_several(_: Situation) -> bool:
            return sum(not row.item.line for row in objects.selected_rows) > 1 or selection.has_waiting_actions

        def all_are(state: str) -> bool:
            return bool(objects.selected_objects) and all(getattr(item, state) for item in objects.selected_objects)

        def ask_color() -> None:
            menu = QMenu(window)
            fill_colors(menu, window, commands.color_selected)
            menu.aboutToHide.connect(menu.deleteLater)
            menu.popup(QCursor.pos())

        self.actions = (
            ActionSpec("accept", "Objects", "&Accept",
                       "Accept proposals, or the selected contours, as objects; Enter does the same.",
                       selection.accept, shown_key="Enter",
                       when=lambda _: bool(selection.proposals) or selection.can_accept),
            ActionSpec("reject", "Objects", "&Reject",
                       "Dismiss proposals and remove objects; none is proposed again.",
                       in_order(commands.reject_selected), "X",
                       when=lambda _: bool(objects.selected_rows or selection.proposals or selection.selecting)),
            ActionSpec("name_object", "Objects", "&Name…", "Name the selected object.",
                       self._ask_for_name_in_order, "F2", gap=True, when=has_rows),
            Submenu("object_class", "Objects", "C&lass", self._fill_classes),
            ActionSpec("object_color", "Objects", "C&olor…", "Give objects a color of their own.",
                       ask_color, when=has_objects),
            ActionSpec("merge_objects", "Objects", "&Merge", "Merge the selected objects into one.",
                       in_order(commands.merge_selected), "M", gap=True, when=has_several),
            ActionSpec("fill_between", "Objects", "Fill &between slices",
                       "Fill the slices between those in which the selected object has been painted.",
                       commands.fill_between_slices, "Shift+I", short=tr("Fill gaps"), visible_when=has_volume,
                       when=lambda _: len(objects.selected_objects) == 1 and not objects.selected_objects[0].frozen),
            ActionSpec("paint_in_space", "Objects", "&Paint in space",
                       "Paint balls through all slices with the brush, or disks in one slice.",
                       brush.toggle_space, "Shift+J", short=tr("In space"),
                       visible_when=has_volume, checked_when=lambda _: brush.paints_in_space),
            ActionSpec("objects_alike", "Objects", "All li&ke this", "Find all objects like the selected one.",
                       partial(selection.do_in_order, self._find_similar, needs_offer=lambda: True), "Ctrl+L",
                       when=has_image),
            ActionSpec("fit_objects", "Objects", "F&it to the contours",
                       "Select the objects again by their own clicks, on the contours of the last run.",
                       lambda: selection.refit_objects(objects.selected_numbers),
                       when=lambda _: any(item.clicks for item in objects.selected_objects)),
            ActionSpec("freeze_object", "Objects", "&Freeze",
                       "Keep the objects as they are, and keep particles from crossing their boundaries.",
                       in_order(partial(commands.toggle_state, "frozen")), gap=True, when=has_objects,
                       text_for=lambda _: tr("Unfreeze") if all_are("frozen") else tr("&Freeze")),
            ActionSpec("hide_object", "Objects", "&Hide", "Hide the objects, or show them again.",
                       in_order(partial(commands.toggle_state, "hidden")), when=has_objects,
                       text_for=lambda _: tr("Show") if all_are("hidden") else tr("&Hide")),
            Submenu("use_as", "Objects", "&Use as", self._fill_uses),
            ActionSpec("skeleton", "Objects", "Ske&leton",
                       "Find the center lines of the selected objects or closed contours, or of all closed "
                       "contours.",
                       self._find_skeleton, icon="mode_skeleton",
                       when=lambda now: bool(objects.selected_numbers) or has_contours(now)),
            ActionSpec("delete_object", "Objects", "&Delete", "Remove the selection; the key Delete does the same.",
                       in_order(commands.delete_selected), gap=True, when=has_rows),
            ActionSpec("all_objects", "Objects", "Select &all", "Select all objects and proposals in the table.",
                       in_order(lambda: objects.select_items(self._list_shown_keys())), "Ctrl+A", gap=True,
                       when=has_image),
            ActionSpec("other_objects", ">" + tr("Objects"), "In&vert the selection",
                       "Select everything that is not selected.",
                       in_order(lambda: objects.select_items(self._list_shown_keys() - objects.selected_keys)),
                       "Ctrl+I", when=has_image),
            ActionSpec("next_object", ">" + tr("Objects"), "Select ne&xt",
                       "Select one row of the table after the other.",
                       in_order(self.select_next), "Shift+N", when=has_image),
            ActionSpec("objects_overlap", "Objects", "Objects may o&verlap",
                       "Let clicks, proposals and the brush run over accepted objects that are not frozen; in a "
                       "volume, the brush takes voxels from them.",
                       commands.toggle_overlap, gap=True, checked_when=lambda _: objects.objects.may_overlap),
            ActionSpec("image_skeleton", "Run", "Skeleton of the &whole image",
                       "Find center lines in the image again, not only in objects or closed contours.",
                       lambda: self._run_skeleton(tr("skeleton of the image"), SkeletonTarget()),
                       when=lambda now: bool(now.document.outlines or now.document.outlined_bodies)),
        )  # fmt: skip

    def _find_similar(self) -> None:
        """Find all objects like the selected one, if a single one is selected and encloses an area."""
        items = self._object_list.selected_objects
        if len(items) == 1 and not items[0].line:
            self._selection.find_similar(items[0].number)
        else:
            words = tr("Select one accepted object with an area: all like it are proposed.")
            self.session.messages.show(words, category=EDITING_CATEGORY)

    def select_next(self) -> None:
        """Select the row after the selected ones."""
        keys = [row.key for row in self.panel.table.listed_rows]
        at = max((keys.index(key) for key in self._object_list.selected_keys if key in keys), default=-1)
        if keys:
            self._object_list.select_items((keys[(at + 1) % len(keys)],))

    def ask_for_name(self) -> None:
        """Ask for the name of the selected row; the keyboard then goes back to the canvas, if it came from there."""
        canvas, table = self.window.canvas_area.canvas, self.panel.table
        came_from_canvas = canvas.hasFocus()
        self.window.docks.reveal_panel("objects")
        table.edit_selected_name()
        if came_from_canvas and table.state() == QAbstractItemView.State.EditingState:
            once = Qt.ConnectionType.SingleShotConnection.value | Qt.ConnectionType.QueuedConnection.value
            table.itemDelegate().closeEditor.connect(canvas.setFocus, Qt.ConnectionType(once))

    def _ask_for_name_in_order(self) -> None:
        """Ask for a name once all that waits has been done; what is typed until then goes into the name."""
        typed = TypedAhead(self.window.canvas_area.canvas, lambda: self._selection.has_waiting_actions)

        def ask_and_type() -> None:
            self.ask_for_name()
            typed.type_into(self.panel.table.findChild(QLineEdit))

        self._selection.do_in_order(ask_and_type)

    def handle_key(self, event: QKeyEvent) -> bool:
        """Handle the keys that act on the selection on the canvas; return whether the key was one of them."""
        tool = self.window.canvas_area.canvas.dispatcher.tool
        if tool is None or event.modifiers() & ~Qt.KeyboardModifier.KeypadModifier:
            return False
        key, selecting = event.key(), tool.panel == "objects"
        if selecting and 1 <= key - Qt.Key.Key_0 <= len(self._object_list.objects.classes):
            self._selection.do_in_order(partial(self._commands.classify_selected, key - Qt.Key.Key_0))
        elif selecting and key in DELETE_KEYS and self._selection.has_waiting_actions:
            self._selection.do_in_order(partial(self._delete_after_waiting, is_back=key == Qt.Key.Key_Backspace))
        elif selecting and key == Qt.Key.Key_Delete and self._selection.selecting:
            self._commands.reject_selected()
        elif selecting and key in DELETE_KEYS and self._object_list.selected_rows and not tool.has_draft:
            self._commands.delete_selected()
        else:
            return False
        return True

    def _delete_after_waiting(self, is_back: bool) -> None:
        """Delete what is selected once all that waited has been done; with `is_back` the last click, if any is left."""
        (self._selection.undo_click if is_back and self._selection.selecting else self._commands.delete_selected)()

    def _list_shown_keys(self) -> frozenset[ItemKey]:
        """Return the keys of the rows in the table."""
        return frozenset(row.key for row in self.panel.table.listed_rows)

    def _on_double_clicked(self) -> None:
        """Rename the item that was double-clicked with the selection tool."""
        if (
            self.window.canvas_area.canvas.dispatcher.tool.name == "select"
            and len(self._object_list.selected_rows) == 1
        ):
            self.ask_for_name()

    def _fill_classes(self, menu: QMenu) -> None:
        objects = self._object_list.objects
        for category in list_classes(objects):
            text = f"{class_title(objects, category)}\t{category}"
            action = add_menu_action(
                menu, text, partial(self._commands.classify_selected, category), checked=category == objects.category
            )
            action.setIcon(create_swatch(objects.classes[category - 1].color))

    def _fill_uses(self, menu: QMenu) -> None:
        for text, words, edit in (
            (tr("&Start of the next run"), tr("start from {what}"), add_objects_as_starts),
            (tr("Region of &interest"), tr("region of interest of {what}"), add_objects_as_regions),
            (tr("&Barrier"), tr("barrier around {what}"), add_objects_as_barriers),
        ):
            add_menu_action(menu, text, partial(self._commands.edit_selected, words, edit)).setEnabled(
                bool(self._object_list.selected_numbers)
            )

    def _find_skeleton(self) -> None:
        """Find the skeleton of the selected objects, else of the selected closed contours, else of all."""
        chosen, contours = self._object_list.selected_numbers, self.window.workspace.contour_selection.selected_contours
        if chosen:
            self._run_skeleton(tr("skeleton of objects"), SkeletonTarget(objects=tuple(sorted(chosen))))
            return
        contours = contours or tuple(self.session.scene.contours)
        lines = tuple(as_line(contour.points) for contour in contours if contour.closed)
        if lines:
            self._run_skeleton(tr("skeleton of contours"), SkeletonTarget(contours=lines))
        else:
            self.session.messages.show(tr("There is no closed contour to find a skeleton in."))

    def _run_skeleton(self, name: str, outlined: SkeletonTarget) -> None:
        """Find center lines in outlined regions, or in the whole image."""
        session = self.session
        session.edit(name, lambda document: switch_to_skeleton(document, outlined))
        if session.status.phase != "running":
            session.run()
