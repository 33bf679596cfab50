"""How work on an image begins: with fresh parameters, or with those of the image before it."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtWidgets import QCheckBox

from app.model.state.situation import Situation
from app.model.text.language import tr
from app.views.widgets.action_spec import ActionSpec
from app.views.widgets.preference_row import PreferenceRow
from app.views.window.feature import Feature, FeatureContext

KEEPS = "parameters/keep"
"""Preference: whether the next image begins with the parameters of the one before it."""


class BeginningFeature(Feature):
    """The parameters that an image begins with."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        context.preferences.changed.connect(self._follow)
        self._follow(KEEPS)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Parameters of the last image."""
        session = self.context.session
        return (
            ActionSpec(name="former_parameters", menu="Run", text=tr("Use parameters of the &last image"),
                       do=session.use_former_parameters, when=self._differ,
                       tip=tr("Set all parameters as they were for the image that was open before this one.")),
        )  # fmt: skip

    def preferences(self) -> Sequence[PreferenceRow]:
        """Whether parameters are kept."""
        return (PreferenceRow(section=tr("Parameters"), label=tr("Next image"), make=self._make_box),)

    def _differ(self, situation: Situation) -> bool:
        former, document = self.context.session.former_parameters, situation.document
        return former is not None and document.fitting(former) != document.parameters

    def _make_box(self) -> QCheckBox:
        box = QCheckBox(tr("Keep parameters for the next image"))
        box.setChecked(self.context.preferences.get(KEEPS, False))
        box.toggled.connect(lambda wanted: self.context.preferences.put(KEEPS, wanted))
        return box

    def _follow(self, key: str) -> None:
        if key == KEEPS:
            self.context.session.keeps_parameters = self.context.preferences.get(KEEPS, False)
