"""The parameters."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from app.model.language import tr
from app.model.wording import FIRST_WORDING, Wording, wording_called
from app.session.preset_store import PresetStore
from app.views.entry import TOGGLE, Entry, Submenu
from app.views.panels.parameters import ParametersPanel
from app.views.part import Desk, Panel, Part
from app.views.preset_keeper import PresetKeeper
from app.views.theme import Theme

WORDING, MOTION = "parameters/wording", "motion"
"""Preferences: how parameters are called, and whether drawings move."""

_WORDINGS: tuple[tuple[Wording, str, str], ...] = (
    ("intuitive", tr("Parameters in plain &words"), tr("Call parameters by what they do.")),
    ("formula", tr("Parameters as in the for&mulas"), tr("Call parameters by their symbols and names.")),
)


class ParametersPart(Part):
    """What the particles obey."""

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self.keeper = PresetKeeper(desk, PresetStore(parent=desk.window))
        self.panel = ParametersPanel(desk.session, self.keeper.gallery)
        desk.preferences.changed.connect(self._follow)
        self._follow(WORDING)
        self._follow(MOTION)

    def entries(self) -> Sequence[Entry | Submenu]:
        """Presets, and how parameters are called."""
        preferences = self.desk.preferences
        wording = wording_called(preferences.get(WORDING, FIRST_WORDING))
        presets = Submenu(name="presets", menu="Run", text=tr("&Preset"), fill=self.keeper.fill, gap=True)
        wordings = [
            Entry(
                name=f"wording_{name}",
                menu="View",
                text=text,
                do=partial(preferences.put, WORDING, name),
                tip=tip,
                group="wording",
                checked=name == wording,
                gap=index == 0,
            )
            for index, (name, text, tip) in enumerate(_WORDINGS)
        ]
        motion = Entry(
            name="motion",
            menu="View",
            text=tr("Drawings that mo&ve"),
            do=partial(preferences.put, MOTION),
            tip=tr("Let the small drawings of the parameters move, or stand still."),
            group=TOGGLE,
            checked=preferences.get(MOTION, True),
        )
        return (presets, *wordings, motion)

    def panels(self) -> Sequence[Panel]:
        """The sliders."""
        return (Panel(name="parameters", title=tr("Parameters"), widget=self.panel, tab="settings", shortcut="F7"),)

    def use_theme(self, theme: Theme) -> None:
        """Tint the buttons."""
        self.panel.use_theme(theme)

    def _follow(self, key: str) -> None:
        preferences = self.desk.preferences
        if key == WORDING:
            self.panel.use_wording(wording_called(preferences.get(WORDING, FIRST_WORDING)))
        elif key == MOTION:
            self.panel.explanation.drawing.set_motion(preferences.get(MOTION, True))
