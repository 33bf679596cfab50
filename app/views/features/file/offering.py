"""Offers that are made for an image when it has been opened, in a line above it."""

from __future__ import annotations

from abc import abstractmethod

from app.session.exchange.messages import Opened
from app.views.theme.theme import Theme
from app.views.widgets.offer_bar import OfferBar
from app.views.window.feature import Feature, FeatureContext


class OfferingFeature(Feature):
    """Offers something for each image that is opened, until a run begins or another image is opened.

    Of several offers one is shown at a time.
    """

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.bar = OfferBar()
        self.bar.changed.connect(self._take_turns)
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
        self.bar.end()
        self.offer(opened)

    def _withdraw(self) -> None:
        if self.bar.waiting and self.context.session.status.started:
            self.bar.end()

    def _take_turns(self) -> None:
        """Show the first of all offers that wait for an answer."""
        offers = self.context.canvas_area.offers
        items = [item for place in range(offers.count()) if (item := offers.itemAt(place)) is not None]
        bars = [bar for item in items if isinstance(bar := item.widget(), OfferBar)]
        first = next((bar for bar in bars if bar.waiting), None)
        for bar in bars:
            bar.setVisible(bar is first)
