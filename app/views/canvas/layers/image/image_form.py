"""The form for the levels and colors of the image."""

from __future__ import annotations

from app.views.canvas.layers.image.image import ImageLayer
from app.views.canvas.layers.image.levels import ScaleSpace
from app.views.canvas.layers.layer_form import LayerForm
from cpm_core.image.image import Image


class ImageForm(LayerForm):
    """Histogram above the options.

    Parameters
    ----------
    layer : ImageLayer
        Whose image.
    """

    def __init__(self, layer: ImageLayer) -> None:
        self.levels: ScaleSpace | None = None
        self._image: Image | None = None
        self._own = layer
        super().__init__(layer)

    def show_chosen(self) -> None:
        """Show options, histogram and window."""
        super().show_chosen()
        image = self._own.scene.image
        if image is not self._image and image is not None:
            self._image = image
            if self.levels is not None:
                self.rows.removeRow(self.levels)
            self.levels = ScaleSpace(image.values, self._own.ends, self._own.window)
            self.levels.moved.connect(self._own.choose_window)
            self.rows.insertRow(0, self.levels)
        elif self.levels is not None:
            self.levels.show_window(*self._own.window)
