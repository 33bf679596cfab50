"""The parameters."""

from __future__ import annotations

from collections.abc import Sequence

from app.model.language import tr
from app.views.panels.parameters import ParametersPanel
from app.views.part import Desk, Panel, Part
from app.views.theme import Theme


class ParametersPart(Part):
    """What the particles obey."""

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self.panel = ParametersPanel(desk.session)

    def panels(self) -> Sequence[Panel]:
        """The sliders."""
        return (Panel(name="parameters", title=tr("Parameters"), widget=self.panel, tab="settings", shortcut="F7"),)

    def use_theme(self, theme: Theme) -> None:
        """Tint the buttons."""
        self.panel.use_theme(theme)
