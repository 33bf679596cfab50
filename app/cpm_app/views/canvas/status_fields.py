"""Fields of the status bar: place and gray value under the pointer, and the zoom."""

from __future__ import annotations

import math

from PySide6.QtWidgets import QLabel

from cpm_app.model.display.lengths import PixelSize, format_length, preferred_pixel_size
from cpm_app.model.text.language import localize_number, tr
from cpm_app.model.volume.slices import name_slices
from cpm_app.session.session import Session
from cpm_app.views.canvas.canvas import Canvas
from cpm_app.views.canvas.image_view import ImageView
from cpm_core import Image
from cpm_core.numerics import Place
from cpm_core.numerics.types import Integers


class PointerReadout(QLabel):
    """Row, column and gray value under the pointer, in a volume the slices across each axis, counted from 1.

    Of a color image it shows the value in the channel of the run; where the pixel size is known, also the position in
    its unit, and in the space of the file where that states one.
    """

    def __init__(self, session: Session, canvas: Canvas) -> None:
        super().__init__()
        self._session = session
        canvas.pointer_place_changed.connect(self._on_place_changed)

    def _on_place_changed(self, place: Place | None) -> None:
        text, image = "", self._session.image
        if place is not None and image is not None and len(place) == image.ndim:
            pixel = tuple(map(round, place))
            if all(0 <= at < side for at, side in zip(pixel, image.shape, strict=True)):
                text = self._format_pixel(image, pixel, self._session.document.parameters.channel)
        self.setText(text)

    @staticmethod
    def _format_pixel(image: Image, pixel: Integers, channel: str) -> str:
        value, size = image.gray_at(pixel, channel), preferred_pixel_size(image.spacing, image.unit)
        lengths = [format_length(place, each, size.unit or "") for place, each in zip(pixel, size.spacing, strict=True)]
        if image.geometry is not None:
            first, second, third = _format_position(image, pixel, size)
            lengths = [first, second, third] if image.ndim == 3 else [f"{first}, {second}", third]
        named = dict(zip(("back", "down", "right")[-image.ndim :], lengths, strict=True))
        if image.ndim == 3:
            slices = zip(name_slices(image), pixel, strict=True)
            named["slices"] = ", ".join(f"{name} {index + 1}" for name, index in slices)
        text = _READOUT_TEMPLATES[image.ndim, size.unit is not None].format(
            value=value, row=pixel[-2], col=pixel[-1], **named
        )
        return f"{text} HU" if image.is_ct else text


def _format_position(image: Image, pixel: Integers, size: PixelSize) -> tuple[str, str, str]:
    """Format x, y and z of a pixel in the space of its file, with the name of the space first and the unit last."""
    assert image.geometry is not None
    place = image.geometry.affine(image.spacing) @ (*(0, *pixel)[-3:], 1)
    decimals = max(0, math.ceil(1.0 - math.log10(min(size.spacing))))
    x, y, z = (localize_number(f"{at:.{decimals}f}") for at in (size.factor * place[:3]).tolist())
    return f"{image.geometry.convention} {x}", y, f"{z} {size.unit}"


_READOUT_TEMPLATES = {
    (2, False): tr("row {row}, col {col}:  {value:g}"),
    (2, True): tr("row {row}, col {col}  ({down}, {right}):  {value:g}"),
    (3, False): tr("{slices}:  {value:g}"),
    (3, True): tr("{slices}  ({back}, {down}, {right}):  {value:g}"),
}
"""Templates by the number of axes and whether the pixel size is known."""


class ZoomReadout(QLabel):
    """Pixels of the screen per pixel of the image."""

    def __init__(self, canvas: ImageView) -> None:
        super().__init__()
        self._canvas = canvas
        self.setAccessibleName(tr("Zoom"))
        self.setMinimumWidth(self.fontMetrics().horizontalAdvance(self._format("00000 %")))
        canvas.view.sigRangeChanged.connect(self._on_zoom_changed)

    def _on_zoom_changed(self, *_: object) -> None:
        percent = 100.0 * self._canvas.magnification
        shown = f"{percent:.0f} %" if percent >= 100.0 else f"{percent:.3g} %"
        self.setText(self._format(shown) if self._canvas.shape is not None else "")

    @staticmethod
    def _format(share: str) -> str:
        """Name the number, which stands next to the gray value."""
        return f"{tr('Zoom')} {share}"
