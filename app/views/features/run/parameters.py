"""The parameters."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from PySide6.QtWidgets import QCheckBox

from app.model.state.situation import Situation
from app.model.text.language import tr
from app.model.text.wording import FIRST_WORDING, Wording, wording_called
from app.session.storage.preferences import Value
from app.session.storage.presets import PresetStore
from app.views.panels.parameters.parameters import ParametersPanel
from app.views.presets.preset_files import PresetFiles
from app.views.theme.theme import Theme
from app.views.widgets.action_spec import STATE, ActionSpec, Submenu
from app.views.widgets.preference_row import PreferenceRow, choice
from app.views.window.feature import Feature, FeatureContext, Panel

WORDING, MOTION = "parameters/wording", "motion"
"""Preferences: labels of parameters, and whether illustrations are animated."""

_WORDINGS: tuple[tuple[Wording, str, str], ...] = (
    ("name", tr("&Names of parameters first"), tr("Label parameters by name and symbol.")),
    ("symbol", tr("S&ymbols of parameters first"), tr("Label parameters by symbol and name, as in the formulas.")),
)


class ParametersFeature(Feature):
    """Parameters and presets."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.preset_files = PresetFiles(context, PresetStore(parent=context.window))
        self.panel = ParametersPanel(context.session, self.preset_files.gallery)
        context.preferences.changed.connect(self._follow)
        self._follow(WORDING)
        self._follow(MOTION)

    def action_specs(self) -> Sequence[ActionSpec | Submenu]:
        """Presets, labels of parameters, animation of illustrations."""
        presets = Submenu(name="presets", menu="Run", text=tr("&Preset"), fill=self.preset_files.fill, gap=True)
        motion = ActionSpec(name="motion", menu="View", text=tr("Ani&mated illustrations"),
                            do=lambda: self._prefer(MOTION, not self._animated),
                            tip=tr("Animate the illustrations of the parameters."), group=STATE,
                            checked=self._animated, holds=lambda _: self._animated)  # fmt: skip
        return (presets, *self._wordings(), motion)

    def preferences(self) -> Sequence[PreferenceRow]:
        """Labels of parameters, and whether illustrations are animated."""
        section, specs = tr("Parameters"), self._wordings()
        return (
            PreferenceRow(section=section, label=tr("Labels"), make=lambda: choice(specs, f"wording_{self._wording}")),
            PreferenceRow(section=section, label=tr("Illustrations"), make=self._make_motion),
        )

    def panels(self) -> Sequence[Panel]:
        """The sliders."""
        return (Panel(name="parameters", title=tr("Parameters"), widget=self.panel, tab="settings", shortcut="F7"),)

    def use_theme(self, theme: Theme) -> None:
        """Color the buttons."""
        self.panel.use_theme(theme)

    @property
    def _wording(self) -> Wording:
        return wording_called(self.context.preferences.get(WORDING, FIRST_WORDING))

    @property
    def _animated(self) -> bool:
        return self.context.preferences.get(MOTION, True)

    def _wordings(self) -> list[ActionSpec]:
        return [
            ActionSpec(name=f"wording_{name}", menu="View", text=text, do=partial(self._prefer, WORDING, name), tip=tip,
                       group=STATE, checked=name == self._wording, holds=partial(self._holds, name), gap=index == 0)
            for index, (name, text, tip) in enumerate(_WORDINGS)
        ]  # fmt: skip

    def _make_motion(self) -> QCheckBox:
        box = QCheckBox(tr("Animate the illustrations"))
        box.setChecked(self._animated)
        box.toggled.connect(partial(self._prefer, MOTION))
        return box

    def _holds(self, name: Wording, situation: Situation) -> bool:
        return name == self._wording

    def _prefer(self, key: str, value: Value) -> None:
        self.context.preferences.put(key, value)
        # The actions must show the new preference.
        self.context.refresh()

    def _follow(self, key: str) -> None:
        if key == WORDING:
            self.panel.use_wording(self._wording)
        elif key == MOTION:
            self.panel.explanation.illustration.set_animated(self._animated)
