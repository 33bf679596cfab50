"""Offers that are made for an image when it has been opened, in a line above it."""

from __future__ import annotations

from abc import abstractmethod

from app.session.exchange.messages import Opened
from app.views.theme.theme import Theme
from app.views.widgets.offer_bar import OfferBar
from app.views.window.feature import Feature, FeatureContext


class OfferingFeature(Feature):
    """Offers something for each image that is opened; the offer ends when a run begins or another image is opened."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.bar = OfferBar()
        context.canvas_area.offers.addWidget(self.bar)
        context.session.listen(Opened, self._begin)
        context.session.status_changed.connect(self._withdraw)

    @abstractmethod
    def offer(self, opened: Opened) -> None:
        """Make an offer for what has been opened, or none."""

    def use_theme(self, theme: Theme) -> None:
        """Tint the cross."""
        self.bar.use_theme(theme)

    def _begin(self, opened: Opened) -> None:
        self.bar.hide()
        self.offer(opened)

    def _withdraw(self) -> None:
        if self.bar.isVisible() and self.context.session.status.started:
            self.bar.hide()
