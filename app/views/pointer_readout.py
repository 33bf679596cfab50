"""What lies under the pointer, in the status bar."""

from __future__ import annotations

from PySide6.QtWidgets import QLabel

from app.model.language import tr
from app.session.session import Session
from app.views.canvas import Canvas
from cpm_core.image import Image
from cpm_core.paths import Position


class PointerReadout(QLabel):
    """Row, column and grey value.

    Parameters
    ----------
    session : Session
        Whose image it reads.
    canvas : Canvas
        Whose pointer it follows.
    """

    def __init__(self, session: Session, canvas: Canvas) -> None:
        super().__init__()
        self._image: Image | None = None
        session.image_changed.connect(self._use_image)
        canvas.pointed.connect(self._show)

    def _use_image(self, image: Image, _: object) -> None:
        self._image = image

    def _show(self, position: Position | None) -> None:
        text = ""
        if position is not None and self._image is not None:
            row, col = round(position[0]), round(position[1])
            rows, cols = self._image.shape
            if 0 <= row < rows and 0 <= col < cols:
                text = tr("row {row}, col {col}:  {value:g}").format(
                    row=row, col=col, value=self._image.values[row, col]
                )
        self.setText(text)
