"""Undo and redo, selection and deletion of shapes, and the history of all changes."""

from __future__ import annotations

from collections.abc import Sequence

from app.model.document import edits
from app.model.state.resolve import resolve
from app.model.state.situation import can_redo, can_undo, has_selection, has_shapes
from app.model.text.language import tr
from app.views.panels.history import HistoryPanel
from app.views.theme.theme import Theme
from app.views.widgets.action_spec import ActionSpec
from app.views.window.feature import Feature, FeatureContext, Panel


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
