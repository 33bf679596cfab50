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
from app.views.panels.history import HistoryPanel
from app.views.theme.theme import Theme
from app.views.widgets.action_spec import STATE, ActionSpec
from app.views.window.feature import Feature, FeatureContext, Panel
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
            ActionSpec(name=tool.name, menu="Draw", text=tool.text,
                       do=partial(self.context.canvas_area.use_tool, tool.name),
                       shortcuts=(tool.shortcut,) if tool.shortcut else (), tip=tool.tip, icon=tool.name, group="tool",
                       checked=tool.name == FIRST_TOOL, gap=index > 0 and tool.group != TOOLS[index - 1].group,
                       when=has_image)
            for index, tool in enumerate(TOOLS)
        ]  # fmt: skip

    def _starts(self) -> Sequence[ActionSpec]:
        return [
            ActionSpec(name=f"start_{kind}", menu="Draw", text=text, do=partial(self._toggle, Everywhere(kind)),
                       shortcuts=(keys,), tip=tip, icon=kind, group=STATE, gap=index == 0, when=has_image,
                       holds=_starts_with(Everywhere(kind)))
            for index, (kind, text, keys, tip) in enumerate(_STARTS)
        ]  # fmt: skip

    def _by_keys(self) -> Sequence[ActionSpec]:
        middle = ActionSpec(name="add_circle", menu="Draw", text=tr("Add circle in the &middle"),
                            do=self.context.canvas_area.add_circle, shortcuts=("Ctrl+K",),
                            tip=tr("Add a circle in the middle of the visible part."), gap=True,
                            when=has_image)  # fmt: skip
        keyed = ActionSpec(
            name="cross_hair",
            menu="Draw",
            text=tr("Draw by &keys"),
            do=self.context.canvas_area.crosshair.toggle,
            tip=tr("Draw with the current tool by a cross-hair that arrow keys move; or press Enter on the image."),
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
            ActionSpec(name=f"mode_{name}", menu="Run", text=info.title, do=partial(self._use, name),
                       shortcuts=(_KEYS[name],), tip=info.about, icon=f"mode_{name}", group=STATE, holds=_is(name),
                       gap=index == 0, short=info.short)
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
            ActionSpec(name="undo", menu="Edit", text=tr("Undo"), short=tr("Undo"), do=session.undo,
                       shortcuts=("Ctrl+Z",), tip=tr("Undo the last change."), icon="undo", when=can_undo,
                       worded=lambda situation: resolve(situation).undo_text),
            ActionSpec(name="redo", menu="Edit", text=tr("Redo"), short=tr("Redo"), do=session.redo,
                       shortcuts=("Ctrl+Shift+Z", "Ctrl+Y"), tip=tr("Redo the last undone change."), icon="redo",
                       when=can_redo, worded=lambda situation: resolve(situation).redo_text),
            ActionSpec(name="select_next", menu="Edit", text=tr("Select &next shape"), do=session.select_next,
                       shortcuts=("N",), tip=tr("Select the next shape."), gap=True, when=has_shapes),
            ActionSpec(name="escape", menu="Edit", text=tr("Cance&l"), do=self.context.canvas_area.escape,
                       shortcuts=("Escape",),
                       tip=tr("Cancel the current drawing, or clear the selection and hide messages.")),
            ActionSpec(name="delete", menu="Edit", text=tr("&Delete"), do=session.delete_selected,
                       shortcuts=("Delete", "Backspace"), tip=tr("Remove the selected shape."), gap=True,
                       when=has_selection),
            ActionSpec(name="enlarge", menu="Edit", text=tr("Larger"), do=lambda: self._resize(1.0), when=has_selection,
                       tip=tr("Make the selected shape larger, or a charge stronger; so does the key >.")),
            ActionSpec(name="shrink", menu="Edit", text=tr("Smaller"), do=lambda: self._resize(-1.0),
                       when=has_selection,
                       tip=tr("Make the selected shape smaller, or a charge weaker; so does the key <.")),
            ActionSpec(name="clear", menu="Edit", text=tr("Delete &all shapes"),
                       do=lambda: session.edit(tr("delete all shapes"), edits.clear_shapes),
                       shortcuts=("Ctrl+Shift+Backspace",), tip=tr("Remove all shapes."), when=has_shapes),
        )  # fmt: skip

    def _resize(self, by: float) -> None:
        selected = self.context.session.selected
        if selected is not None:
            self.context.canvas_area.grow(selected, by)


class HistoryFeature(Feature):
    """The panel of the history."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        session = context.session
        self.panel = HistoryPanel(session.go_to)
        session.document_changed.connect(lambda _: self.panel.show_changes(*session.changes))
        self.panel.show_changes(*session.changes)

    def panels(self) -> Sequence[Panel]:
        """The history."""
        title = tr("History")
        return (Panel(name="history", title=title, widget=self.panel, tab="settings", shown=False, shortcut="Ctrl+H"),)

    def use_theme(self, theme: Theme) -> None:
        """Color the lines for the new palette."""
        self.panel.use_theme(theme)
