"""A stack of planes: opened as one volume, or one page of it as an image."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from app.model.state.situation import Situation
from app.model.state.volume_limits import has_volume
from app.model.text.language import tr
from app.session.exchange.messages import Opened
from app.views.features.file.offering import OfferingFeature
from app.views.widgets.action_spec import ActionSpec
from app.views.window.feature import FeatureContext


class StackFeature(OfferingFeature):
    """Offers to open a stack of which one page is shown as a volume, and the way back in the menu."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self._stack: Path | None = None

    def action_specs(self) -> Sequence[ActionSpec]:
        """The other way to open the stack."""
        return (
            ActionSpec(name="open_stack", menu="File", text=tr("Open all pages as one volu&me"),
                       do=self._open_otherwise,
                       tip=tr("Open a stack of pages as one volume, or one page of it as an image."),
                       when=lambda _: self._stack is not None, worded=_text),
        )  # fmt: skip

    def offer(self, opened: Opened) -> None:
        """Offer to open all pages as one volume."""
        self._stack = opened.path if opened.stacked else None
        if opened.stacked and opened.image.ndim == 2 and opened.saved is None:
            sentence = tr("{name} is a stack of pages, one of which is open. Open all as one volume?")
            self.bar.offer(
                sentence.format(name=opened.path.name),
                (tr("Open as volume"), self._open_otherwise),
            )

    def _open_otherwise(self) -> None:
        if self._stack is not None:
            image = self.context.session.image
            self.context.open_volume(self._stack, image is not None and image.ndim == 2)


def _text(situation: Situation) -> str:
    if has_volume(situation):
        return tr("Open one page as an i&mage")
    return tr("Open all pages as one volu&me")
