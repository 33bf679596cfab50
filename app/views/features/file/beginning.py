"""How work on an image begins: with fresh parameters, or with those of the image before it."""

from __future__ import annotations

from collections.abc import Sequence

from app.model.preferences.table import KEEP_PARAMETERS
from app.model.state.situation import Situation
from app.model.text.language import tr
from app.views.widgets.action_spec import ActionSpec
from app.views.window.feature import Feature, FeatureContext


class BeginningFeature(Feature):
    """The parameters that an image begins with."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        context.preferences.follow(KEEP_PARAMETERS, self._use)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Parameters of the last image."""
        session = self.context.session
        return (
            ActionSpec(name="former_parameters", menu="Run", text=tr("Use parameters of the &last image"),
                       do=session.use_former_parameters, when=self._differ,
                       tip=tr("Set all parameters as they were for the image that was open before this one.")),
        )  # fmt: skip

    def _differ(self, situation: Situation) -> bool:
        former, document = self.context.session.former_parameters, situation.document
        return former is not None and document.fitting(former) != document.parameters

    def _use(self) -> None:
        self.context.session.keeps_parameters = self.context.preferences.value(KEEP_PARAMETERS)
