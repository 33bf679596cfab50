"""The parameters."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from PySide6.QtWidgets import QMenu

from app.model.parameters.choices import CHANNEL
from app.model.preferences.table import WORDING
from app.model.state.situation import Situation
from app.model.text.language import tr
from app.model.text.wording import Wording, wording_called
from app.session.storage.presets import PresetStore
from app.views.panels.parameters.parameters import ParametersPanel
from app.views.presets.preset_files import PresetFiles
from app.views.theme.theme import Theme
from app.views.widgets.action_spec import STATE, ActionSpec, Submenu
from app.views.window.feature import Feature, FeatureContext, Panel

_WORDINGS: tuple[tuple[Wording, str, str], ...] = (
    ("name", tr("&Names of parameters first"), tr("Label parameters by name and symbol.")),
    ("symbol", tr("S&ymbols of parameters first"), tr("Label parameters by symbol and name, as in the formulas.")),
)


class ParametersFeature(Feature):
    """Parameters and presets."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        store = PresetStore(parent=context.window)
        for trouble in store.troubles:
            context.preferences.complain(trouble)
        self.preset_files = PresetFiles(context, store)
        self.panel = ParametersPanel(context.session, self.preset_files.gallery)
        context.preferences.follow(WORDING, lambda: self.panel.use_wording(self._wording))
        # The actions must show the preferences.
        context.preferences.changed.connect(self._refresh)

    def action_specs(self) -> Sequence[ActionSpec | Submenu]:
        """Presets, channels, and labels of parameters."""
        presets = Submenu(name="presets", menu="Run", text=tr("&Preset"), fill=self.preset_files.fill, gap=True)
        channels = Submenu(name="channels", menu="Run", text=tr("C&hannel"), fill=self.fill_channels)
        return (presets, channels, *self._wordings())

    def panels(self) -> Sequence[Panel]:
        """The sliders."""
        return (Panel(name="parameters", title=tr("Parameters"), widget=self.panel, tab="settings", shortcut="F7"),)

    def fill_channels(self, menu: QMenu) -> None:
        """Fill a menu with the channels; a gray image has none."""
        session = self.context.session
        colored = session.image is not None and session.image.colors is not None
        for value, title, about in self.panel.choices[CHANNEL].control.choices:
            action = menu.addAction(title)
            action.setCheckable(True)
            action.setChecked(value == session.document.parameters.channel)
            action.setEnabled(colored)
            action.setStatusTip(about)
            action.triggered.connect(lambda _=False, value=value: self.panel.change(CHANNEL, value))

    def use_theme(self, theme: Theme) -> None:
        """Color the buttons."""
        self.panel.use_theme(theme)

    @property
    def _wording(self) -> Wording:
        return wording_called(self.context.preferences.value(WORDING))

    def _wordings(self) -> list[ActionSpec]:
        choose = self.context.preferences.choose
        return [
            ActionSpec(name=f"wording_{name}", menu="View", text=text, do=partial(choose, WORDING, name), tip=tip,
                       group=STATE, checked=name == self._wording, holds=partial(self._holds, name), gap=index == 0)
            for index, (name, text, tip) in enumerate(_WORDINGS)
        ]  # fmt: skip

    def _holds(self, name: Wording, situation: Situation) -> bool:
        return name == self._wording

    def _refresh(self, key: str) -> None:
        if key == WORDING.name:
            self.context.refresh()
