"""Position and gray value under the pointer, in the status bar."""

from __future__ import annotations

from PySide6.QtWidgets import QLabel

from app.model.display.lengths import length_text, shown_in
from app.model.text.language import tr
from app.session.session import Session
from app.views.canvas.canvas import Canvas
from cpm_core.image.image import Image
from cpm_core.numerics.types import Position


class PointerReadout(QLabel):
    """Row, column and gray value, of a color image in the channel of the run.

    Where the size of a pixel is known, also the position in its unit.
    """

    def __init__(self, session: Session, canvas: Canvas) -> None:
        super().__init__()
        self._session = session
        canvas.pointed.connect(self._show)

    def _show(self, position: Position | None) -> None:
        text, image = "", self._session.image
        if position is not None and image is not None:
            row, col = round(position[0]), round(position[1])
            rows, cols = image.shape
            if 0 <= row < rows and 0 <= col < cols:
                text = self._text(image, row, col, self._session.document.parameters.channel)
        self.setText(text)

    @staticmethod
    def _text(image: Image, row: int, col: int, channel: str) -> str:
        value, size = image.gray_at((row, col), channel), shown_in(image.spacing, image.unit)
        if size.unit is None:
            return tr("row {row}, col {col}:  {value:g}").format(row=row, col=col, value=value)
        down, right = (
            length_text(place, each, size.unit) for place, each in zip((row, col), size.spacing, strict=True)
        )
        words = tr("row {row}, col {col}  ({down}, {right}):  {value:g}")
        return words.format(row=row, col=col, down=down, right=right, value=value)
