"""The layer of the second image: labels in colors, or gray levels in a color map, over the image."""

from __future__ import annotations

from functools import cache

import numpy as np

from cpm_app.model.display.second_image import LABEL_SHADES
from cpm_app.model.text.language import tr
from cpm_app.session.scene import Scene
from cpm_app.views.items.item import enable_caching
from cpm_app.views.items.tiled_image import TiledImage
from cpm_app.views.layers.layer import Layer, Option
from cpm_app.views.theme import color_maps
from cpm_core.formats.masks.labels import label_palette
from cpm_core.numerics.types import Pixels

_SECOND_Z = 0.5
"""Place in the stack, above the image and below everything else."""

_INITIAL_OPACITY = 0.5

_CLEAR_SHADES = 64
"""Number of dark shades of gray levels that are partly transparent, so that the image is seen in the background."""


class SecondImageLayer(Layer):
    """The second image; the background of labels is clear, and so are dark gray levels."""

    name = "second"
    title = tr("Second image")
    tip = tr("A label map, or another image, over the first: menu File, “Show a second image…”.")
    shortcut = "Alt+Shift+8"
    options = (Option("map", tr("Colors"), "inferno", tr("Colors from dark to bright."), color_maps.COLOR_MAPS),)

    def create_items(self) -> None:
        """Create the items of the layer."""
        self.item = TiledImage(_SECOND_Z)
        self.item.count = 0
        enable_caching(self.item)
        self.add_items(self.item)
        self.set_opacity(_INITIAL_OPACITY)

    def show_scene(self, before: Scene) -> None:
        """Show another second image, or none."""
        second = self.scene.second
        if second is before.second:
            return
        if second is not None:
            self.item.show_image(second.display(second.shades))
            self.apply_option("map")
        self.item.update_count(int(second is not None))

    def has_effect(self, name: str) -> bool:
        """Tell whether an option has an effect: labels have their own colors."""
        return self.scene.second is not None and not self.scene.second.is_labels

    def apply_option(self, name: str) -> None:
        """Change the colors."""
        if self.scene.second is not None:
            self.item.set_color_table(self.color_table)

    @property
    def color_table(self) -> Pixels:
        """Color and opacity of each shade, shape (256, 4)."""
        second = self.scene.second
        return _label_table() if second is not None and second.is_labels else _gray_table(self.get_choice("map"))


@cache
def _label_table() -> Pixels:
    """Return the colors of labels, shape (256, 4), clear for 0."""
    opacity = np.full(LABEL_SHADES + 1, 255)
    opacity[0] = 0
    return np.column_stack([label_palette(LABEL_SHADES), opacity]).astype(np.uint8)


@cache
def _gray_table(name: str) -> Pixels:
    """Return the colors of gray levels, shape (256, 4), dark ones clear."""
    opacity = np.minimum(np.arange(256) * 255 // _CLEAR_SHADES, 255)
    return np.column_stack([color_maps.color_table(name), opacity]).astype(np.uint8)
