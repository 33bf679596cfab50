"""Menus Draw and Edit: tools, starts that need no drawing, modes, undo and selection."""

from __future__ import annotations

from functools import partial

from cpm_app.model.document import edits
from cpm_app.model.document.document import Mode
from cpm_app.model.document.modes import MODES
from cpm_app.model.state.resolve import resolve_texts
from cpm_app.model.state.situation import Situation, has_image, has_shapes
from cpm_app.model.text.language import tr, translate_core_text
from cpm_app.views.canvas.canvas_area import FIRST_TOOL
from cpm_app.views.tools import TOOLS_BY_GROUP
from cpm_app.views.widgets.actions import ActionSpec
from cpm_app.views.window.window import Feature
from cpm_core.shapes import Everywhere, SeedingKind


class DrawFeature(Feature):
    """Tools for starts, regions, barriers and charges; starts that need no drawing; drawing by keys."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        area = self.window.canvas_area
        tools = [
            ActionSpec(tool.name, "Tools", tool.menu_text, tool.tip, partial(area.use_tool, tool.name), tool.shortcut,
                       icon=tool.name, group="tool", checked=tool.name == FIRST_TOOL,
                       gap=tool is group[0], when=has_image, short=tool.short)
            for group in TOOLS_BY_GROUP.values() for tool in group
        ]  # fmt: skip
        self.actions = (
            *tools,
            self._create_start_action("grid", tr("Every&where"), "Ctrl+G",
                        tr("Start on a grid over the whole image; choose again to remove it.")),
            self._create_start_action("gradient", tr("Stron&g edges"), "Ctrl+Shift+G",
                        tr("Start where the gradient is large; choose again to remove it."), tr("Edges")),
            self._create_start_action("centers", tr("Ce&nters"), "Ctrl+Shift+C",
                        tr("Start at the centers of regions enclosed by edges; choose again to remove it.")),
            ActionSpec("cross_hair", "Tools", "Draw by &keys",
                       "Draw with the current tool by moving a cross-hair with the arrow keys; or press "
                       "Enter on the image.",
                       area.crosshair.toggle_visibility, gap=True, when=has_image),
        )  # fmt: skip

    def _create_start_action(self, kind: SeedingKind, text: str, keys: str, tip: str, short: str = "") -> ActionSpec:
        """Create the action that adds or removes a start that needs no drawing."""
        start, session = Everywhere(kind), self.session

        def toggle_start() -> None:
            name = translate_core_text(start.title)
            if start in session.document.shapes:
                name = tr("remove {start}", start=name)
            session.edit(name, lambda document: edits.toggle_everywhere(document, kind))

        return ActionSpec(f"start_{kind}", "Tools", text, tip, toggle_start, keys, icon=kind, gap=kind == "grid",
                          short=short, when=has_image,
                          checked_when=lambda now: start in now.document.shapes)  # fmt: skip


_MODE_KEYS = {"shape": "Ctrl+F1", "automatic": "Ctrl+F2", "skeleton": "Ctrl+F3", "published": "Ctrl+F4"}
"""Default key of each mode."""


class ModesFeature(Feature):
    """Selection of the mode."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        self.actions = [self._create_mode_action(mode) for mode in MODES]

    def _create_mode_action(self, mode: Mode) -> ActionSpec:
        info, session = MODES[mode], self.session

        def select_mode() -> None:
            session.set_mode(mode)
            self.window.canvas_area.crosshair.hide_crosshair()

        return ActionSpec(f"mode_{mode}", "Run", info.title, info.about, select_mode, _MODE_KEYS[mode],
                          icon=f"mode_{mode}",
                          checked_when=lambda now: now.document.mode == mode, gap=mode == "shape",
                          short=info.short)  # fmt: skip


class UndoSelectionFeature(Feature):
    """Undo, selection and deletion by menus and keys."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        window = self.window
        session, area = window.session, window.canvas_area
        undo, redo = (
            partial(window.workspace.object_selection.do_in_order, change, needs_answer=False)
            for change in (session.undo, session.redo)
        )

        def can_resize(situation: Situation) -> bool:
            return situation.selected is not None or area.canvas.dispatcher.tool.is_resizable

        self.actions = (
            ActionSpec("undo", "Edit", "Undo", "Undo the last change.", undo, "Ctrl+Z", short=tr("Undo"),
                       icon="undo", when=lambda now: bool(now.undo_name),
                       text_for=lambda now: resolve_texts(now).undo_text),
            ActionSpec("redo", "Edit", "Redo", "Redo the last undone change.", redo, "Ctrl+Shift+Z Ctrl+Y",
                       short=tr("Redo"), icon="redo", when=lambda now: bool(now.redo_name),
                       text_for=lambda situation: resolve_texts(situation).redo_text),
            ActionSpec("select_next", "Edit", "Select &next shape", "Select the next shape.", session.select_next_shape,
                       "N", gap=True, when=has_shapes),
            ActionSpec("escape", ">" + tr("Edit"), "Cance&l",
                       "Cancel the current drawing, or clear the selection and hide messages.",
                       window.canvas_area.cancel_or_deselect, "Escape"),
            ActionSpec("delete", "Edit", "&Delete", "Remove the selected shape.", session.delete_selected_shape,
                       "Delete Backspace", gap=True, when=lambda now: now.selected is not None),
            ActionSpec("enlarge", ">" + tr("Edit"), "Larger",
                       "Make the selected shape, the brush or the candidate larger; the key ] does the same.",
                       partial(area.resize_selection, 1.0), when=can_resize),
            ActionSpec("shrink", ">" + tr("Edit"), "Smaller",
                       "Make the selected shape, the brush or the candidate smaller; the key [ does the same.",
                       partial(area.resize_selection, -1.0), when=can_resize),
            ActionSpec("clear", "Edit", "Delete &all shapes", "Remove all shapes.",
                       partial(session.edit, tr("delete all shapes"), edits.clear_shapes), "Ctrl+Shift+Backspace",
                       when=has_shapes),
        )  # fmt: skip
