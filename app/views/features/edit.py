"""Menus Draw and Edit: tools, starts that need no drawing, modes, undo and selection."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from app.model.document import edits
from app.model.document.document import Mode
from app.model.document.modes import MODES, use_mode
from app.model.state.resolve import resolve
from app.model.state.situation import Condition, can_redo, can_undo, has_image, has_selection, has_shapes
from app.model.text.language import from_core, tr
from app.views.canvas.canvas_area import FIRST_TOOL
from app.views.canvas.tools import TOOLS
from app.views.widgets.actions import ActionSpec
from app.views.window.feature import Feature
from cpm_core.shapes import Everywhere, Kind

_STARTS: tuple[tuple[Kind, str, str, str], ...] = (
    ("grid", tr("Start everywhere (&grid)"), "Ctrl+G",
     tr("Start on a grid over the whole image; choose again to remove it.")),
    ("gradient", tr("Start on strong &edges"), "Ctrl+Shift+G",
     tr("Start where the gradient is large; choose again to remove it.")),
    ("centers", tr("Start at ce&nters"), "Ctrl+Shift+C",
     tr("Start at the centers of regions enclosed by edges; choose again to remove it.")),
)  # fmt: skip


class DrawFeature(Feature):
    """Tools for the initialization, regions, barriers and charges."""

    def action_specs(self) -> Sequence[ActionSpec]:
        """Tools, automatic initializations, and drawing by keys."""
        return (*self._tools(), *self._starts(), *self._by_keys())

    def _tools(self) -> Sequence[ActionSpec]:
        return [
            ActionSpec(tool.name, "Draw", tool.text, tool.tip, partial(self.context.canvas_area.use_tool, tool.name),
                       tool.shortcut, icon=tool.name, group="tool", checked=tool.name == FIRST_TOOL,
                       gap=index > 0 and tool.group != TOOLS[index - 1].group, when=has_image)
            for index, tool in enumerate(TOOLS)
        ]  # fmt: skip

    def _starts(self) -> Sequence[ActionSpec]:
        return [
            ActionSpec(f"start_{kind}", "Draw", text, tip, partial(self._toggle, Everywhere(kind)), keys, icon=kind,
                       gap=index == 0, when=has_image, holds=_starts_with(Everywhere(kind)))
            for index, (kind, text, keys, tip) in enumerate(_STARTS)
        ]  # fmt: skip

    def _by_keys(self) -> Sequence[ActionSpec]:
        middle = ActionSpec("add_circle", "Draw", tr("Add circle in the &middle"),
                            tr("Add a circle in the middle of the visible part."), self.context.canvas_area.add_circle,
                            "Ctrl+K", gap=True, when=has_image)  # fmt: skip
        keyed = ActionSpec(
            "cross_hair",
            "Draw",
            tr("Draw by &keys"),
            tr("Draw with the current tool by a cross-hair that arrow keys move; or press Enter on the image."),
            self.context.canvas_area.crosshair.toggle,
            when=has_image,
        )
        return middle, keyed

    def _toggle(self, start: Everywhere) -> None:
        session = self.context.session
        name = from_core(start.title)
        if start in session.document.shapes:
            name = tr("remove {start}").format(start=name)
        session.edit(name, lambda document: edits.toggle_everywhere(document, start.kind))
        # The action must show the state of the document even if it has not changed.
        self.context.refresh()


def _starts_with(start: Everywhere) -> Condition:
    return lambda situation: start in situation.document.shapes


_KEYS = {"shape": "Ctrl+F1", "automatic": "Ctrl+F2", "skeleton": "Ctrl+F3"}


class ModesFeature(Feature):
    """The choice of the mode."""

    def action_specs(self) -> Sequence[ActionSpec]:
        """One mode each."""
        return [
            ActionSpec(f"mode_{name}", "Run", info.title, info.about, partial(self._use, name), _KEYS[name],
                       icon=f"mode_{name}", holds=_is(name), gap=index == 0, short=info.short)
            for index, (name, info) in enumerate(MODES.items())
        ]  # fmt: skip

    def _use(self, mode: Mode) -> None:
        session = self.context.session
        if session.document.mode != mode:
            name = tr("mode “{mode}”").format(mode=MODES[mode].title.replace("&", ""))
            session.edit(name, lambda document: use_mode(document, mode))
        # The action must show the state of the document even if it has not changed.
        self.context.refresh()


def _is(mode: Mode) -> Condition:
    return lambda situation: situation.document.mode == mode


class UndoSelectionFeature(Feature):
    """Undo, selection and deletion by menus and keys."""

    def action_specs(self) -> Sequence[ActionSpec]:
        """Undo, redo, selection, deletion."""
        session = self.context.session
        return (
            ActionSpec("undo", "Edit", tr("Undo"), tr("Undo the last change."), session.undo, "Ctrl+Z",
                       short=tr("Undo"), icon="undo", when=can_undo,
                       worded=lambda situation: resolve(situation).undo_text),
            ActionSpec("redo", "Edit", tr("Redo"), tr("Redo the last undone change."), session.redo,
                       "Ctrl+Shift+Z Ctrl+Y", short=tr("Redo"), icon="redo", when=can_redo,
                       worded=lambda situation: resolve(situation).redo_text),
            ActionSpec("select_next", "Edit", tr("Select &next shape"), tr("Select the next shape."),
                       session.select_next, "N", gap=True, when=has_shapes),
            ActionSpec("escape", "Edit", tr("Cance&l"),
                       tr("Cancel the current drawing, or clear the selection and hide messages."),
                       self.context.canvas_area.escape, "Escape"),
            ActionSpec("delete", "Edit", tr("&Delete"), tr("Remove the selected shape."), session.delete_selected,
                       "Delete Backspace", gap=True, when=has_selection),
            ActionSpec("enlarge", "Edit", tr("Larger"),
                       tr("Make the selected shape larger, or a charge stronger; so does the key >."),
                       lambda: self._resize(1.0), when=has_selection),
            ActionSpec("shrink", "Edit", tr("Smaller"),
                       tr("Make the selected shape smaller, or a charge weaker; so does the key <."),
                       lambda: self._resize(-1.0), when=has_selection),
            ActionSpec("clear", "Edit", tr("Delete &all shapes"), tr("Remove all shapes."),
                       lambda: session.edit(tr("delete all shapes"), edits.clear_shapes), "Ctrl+Shift+Backspace",
                       when=has_shapes),
        )  # fmt: skip

    def _resize(self, by: float) -> None:
        selected = self.context.session.selected
        if selected is not None:
            self.context.canvas_area.grow(selected, by)
