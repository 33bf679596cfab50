"""The history: all changes by name, and the way to any of them."""

from __future__ import annotations

from collections.abc import Sequence

from app.model.text.language import tr
from app.views.panels.history import HistoryPanel
from app.views.theme.theme import Theme
from app.views.window.feature import Feature, FeatureContext, Panel


class HistoryFeature(Feature):
    """What has been done and undone."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        session = context.session
        self.panel = HistoryPanel(session.go_to)
        session.document_changed.connect(lambda _: self.panel.show_changes(*session.changes))
        self.panel.show_changes(*session.changes)

    def panels(self) -> Sequence[Panel]:
        """The changes."""
        title = tr("History")
        return (Panel(name="history", title=title, widget=self.panel, tab="settings", shown=False, shortcut="Ctrl+H"),)

    def use_theme(self, theme: Theme) -> None:
        """Grey is another grey now."""
        self.panel.mark()
