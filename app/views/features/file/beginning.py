"""How work on an image begins: with fresh parameters, those of the image before it, or those for its kind."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from app.model.document.modes import ADVICE, use_kind
from app.model.document.samples import sample_at
from app.model.preferences.table import KEEP_PARAMETERS, OFFER_SETTINGS
from app.model.state.situation import Situation
from app.model.text.language import tr
from app.session.exchange.messages import Opened
from app.views.features.file.offering import OfferingFeature
from app.views.widgets.action_spec import ActionSpec
from app.views.window.feature import FeatureContext
from cpm_core.image.kind import Kind


class BeginningFeature(OfferingFeature):
    """The parameters that an image begins with, and what is offered for it in a line above it."""

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

    def offer(self, opened: Opened) -> None:
        """Offer earlier work on an image, or the settings for its kind."""
        session, kind = self.context.session, opened.kind
        if opened.saved is not None or sample_at(opened.path) is not None:
            return
        if opened.beside is not None:
            beside = opened.beside
            earlier = tr("{name} holds earlier work on this image. Continue it?").format(name=beside.name)
            self.bar.offer(earlier, (tr("Open session"), lambda: self.context.open_file(beside, False)))
        elif kind is not None and kind in ADVICE and session.document.mode != "skeleton":
            self._advise(kind)

    def _advise(self, kind: Kind) -> None:
        """Offer the settings for a kind of image, unless the user wants no such offers."""
        if self.context.preferences.value(OFFER_SETTINGS):
            name = tr("settings for the kind of image")
            take = partial(self.context.session.edit, name, partial(use_kind, kind=kind))
            self.bar.offer(ADVICE[kind].sentence, (tr("Use these settings"), take))

    def _differ(self, situation: Situation) -> bool:
        former, document = self.context.session.former_parameters, situation.document
        return former is not None and document.fitting(former) != document.parameters

    def _use(self) -> None:
        self.context.session.keeps_parameters = self.context.preferences.value(KEEP_PARAMETERS)
