"""The layer of the image itself."""

from __future__ import annotations

import pyqtgraph as pg

from app.model.language import tr
from app.model.shades import Shades
from app.session.session import Session
from app.views.coordinates import image_rectangle
from app.views.layers.layer import Layer
from app.views.pens import cached
from cpm_core.image import Image


class ImageLayer(Layer):
    """The grey values."""

    name = "image"
    title = tr("Image")
    tip = tr("The image itself.")
    shortcut = "Ctrl+0"

    def __init__(self, view: pg.ViewBox, session: Session) -> None:
        super().__init__(view, session)
        self._item = pg.ImageItem()
        self._item.setZValue(0)
        cached(self._item)
        self.add(self._item)
        session.image_changed.connect(self._show)

    def _show(self, _: Image, shades: Shades) -> None:
        self._item.setImage(shades, levels=(0, 255), rect=image_rectangle(shades.shape))
