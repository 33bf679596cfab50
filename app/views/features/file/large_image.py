"""What a large image wants, offered in a line above it."""

from __future__ import annotations

from dataclasses import replace

from app.model.document import edits
from app.model.document.document import Document
from app.model.text.language import tr
from app.model.text.numbers import written
from app.session.exchange.messages import Opened
from app.views.features.file.offering import OfferingFeature
from cpm_core.segmentation.large_images import LargeImageSettings


class LargeImageFeature(OfferingFeature):
    """Offers the scales and the smoothing that suit a large image; nothing is changed before the user agrees."""

    def offer(self, opened: Opened) -> None:
        """Offer what a large image wants."""
        settings, document = opened.large, self.context.session.document
        if settings is None or opened.saved is not None or _with(document, settings) == document:
            return
        sentence = tr(
            "This image is large: {scales} scales and smoothing {smoothing} find its objects more surely. Use them?"
        ).format(scales=settings.scales, smoothing=written(f"{settings.smoothing:g}"))
        name = tr("settings for a large image")
        self.bar.offer(
            sentence,
            (tr("Use them"), lambda: self.context.session.edit(name, lambda document: _with(document, settings))),
        )


def _with(document: Document, settings: LargeImageSettings) -> Document:
    """The document with settings for a large image, and with no less of either than it has."""
    now = document.parameters
    smoothing = now.smoothing if now.smoothing == "auto" else max(now.smoothing, settings.smoothing)
    wanted = replace(now, scales=max(now.scales, settings.scales), smoothing=smoothing)
    return edits.set_parameters(document, wanted)
