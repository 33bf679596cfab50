"""Light or dark."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from PySide6.QtGui import QGuiApplication

from app.model.state.situation import Situation
from app.model.text.language import tr
from app.views.theme import theme
from app.views.widgets.action_spec import STATE, ActionSpec
from app.views.widgets.preference_row import PreferenceRow, choice
from app.views.window.feature import Feature, FeatureContext

_CHOICES: tuple[tuple[str, str, str, theme.Theme | None], ...] = (
    ("system", tr("Colors of the &desktop"), tr("Light or dark colors, as on the desktop."), None),
    ("light", tr("&Light colors"), tr("Light background."), theme.LIGHT),
    ("dark", tr("Dar&k colors"), tr("Dark background."), theme.DARK),
)
_KEY = "theme"


class AppearanceFeature(Feature):
    """The colors of the window."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self._chosen = context.preferences.get(_KEY, "system")
        self._following = True
        QGuiApplication.styleHints().colorSchemeChanged.connect(self._follow_desktop)

    def action_specs(self) -> Sequence[ActionSpec]:
        """The choices."""
        return [
            ActionSpec(name=f"theme_{name}", menu="View", text=text, do=partial(self._choose, name), tip=tip,
                       group=STATE, checked=name == self._chosen, holds=partial(self._holds, name), gap=index == 0)
            for index, (name, text, tip, _) in enumerate(_CHOICES)
        ]  # fmt: skip

    def preferences(self) -> Sequence[PreferenceRow]:
        """Light or dark."""
        section, specs = tr("Appearance"), self.action_specs()
        return (
            PreferenceRow(section=section, label=tr("Colors"), make=lambda: choice(specs, f"theme_{self._chosen}")),
        )

    def theme(self) -> theme.Theme:
        """The chosen theme, or that of the desktop."""
        chosen = {name: made for name, _, _, made in _CHOICES}.get(self._chosen)
        return chosen or theme.system_theme()

    def close(self) -> bool:
        """Stop following the desktop."""
        if self._following:
            self._following = False
            QGuiApplication.styleHints().colorSchemeChanged.disconnect(self._follow_desktop)
        return True

    def _choose(self, name: str) -> None:
        self._chosen = name
        self.context.preferences.put(_KEY, name)
        self.context.use_theme(self.theme())
        # The actions must show the new choice.
        self.context.refresh()

    def _holds(self, name: str, situation: Situation) -> bool:
        return name == self._chosen

    def _follow_desktop(self) -> None:
        if self._chosen == "system":
            self.context.use_theme(self.theme())
