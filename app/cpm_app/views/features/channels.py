"""The channels of a file, shown together as a composite."""

from __future__ import annotations

from cpm_app.model.text.language import tr
from cpm_app.views.canvas.channel_bar import ChannelBar
from cpm_app.views.widgets.actions import ActionSpec
from cpm_app.views.window.window import Feature


class ChannelsFeature(Feature):
    """Line below the canvas with the channels of a file."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        window, layer = self.window, self.canvas.layers.image
        self.bar = ChannelBar(layer)
        window.canvas_area.controls.addWidget(self.bar)

        def read_channels() -> None:
            window.workspace.channel_images.show(layer.wanted_channels)

        # later: the layer changes before a session has restored which channels it shows
        layer.changed.connect(lambda: window.turns.schedule_work(read_channels))
        self.actions = (
            ActionSpec("composite", "View", "Co&mposite of the channels",
                       "Show all channels of the file together, each in its color, or only the one of the run.",
                       layer.toggle_composite, short=tr("Composite"),
                       visible_when=lambda _: bool(layer.looks), checked_when=lambda _: layer.is_composite),
        )  # fmt: skip
