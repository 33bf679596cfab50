"""The channels of a file: shown together as a composite, and opened one by one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from cpm_app.model.text.language import tr
from cpm_app.views.canvas.channel_bar import ChannelBar
from cpm_app.views.features.files import OpenSaveFeature
from cpm_app.views.widgets.actions import ActionSpec
from cpm_app.views.window.window import Feature


class ChannelsFeature(Feature):
    """Line below the canvas with the channels of a file."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        self._layer = layer = self.canvas.layers.image
        self.bar = ChannelBar(layer, self._open_channel)
        self.window.canvas_area.controls.addWidget(self.bar)
        # later: the layer changes before a session has restored which channels it shows
        layer.changed.connect(lambda: self.window.turns.schedule_work(self._read_channels))
        self.actions = (
            ActionSpec("composite", "View", "C&omposite of the channels",
                       "Show all channels of the file together, each in its color, or only the one of the run.",
                       lambda: layer.set_composite(not layer.is_composite), short=tr("Composite"),
                       visible_when=lambda _: bool(layer.looks), checked_when=lambda _: layer.is_composite),
        )  # fmt: skip

    def _read_channels(self) -> None:
        """Read the channels that are shown, and not those that are switched off."""
        layer = self._layer
        shown = (index for index, look in enumerate(layer.looks) if look.shown and layer.is_composite)
        self.window.workspace.channel_images.show(frozenset(shown))

    def _open_channel(self, index: int) -> None:
        """Open another channel of the file, as its slider does if there is one."""
        pages, image = self.window.workspace.pages, self.session.document.image
        if pages.count and pages.source.kind == "channel":
            pages.open_page(index + 1)
        elif image is not None and index != self._layer.open_channel:
            opened = self.window.get_feature(OpenSaveFeature)
            opened.open_part(Path(image.path), image.is_volume, replace(image.reading, channel=index + 1))
