"""What the status bar shows of the canvas: place and gray value under the pointer, and the zoom."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QFocusEvent
from PySide6.QtWidgets import QComboBox, QLabel, QLineEdit

from app.model.display.lengths import length_text, shown_in
from app.model.text.language import tr
from app.session.session import Session
from app.views.canvas.canvas import Canvas
from app.views.canvas.image_view import ImageView
from cpm_core import Image
from cpm_core.numerics import Place


class PointerReadout(QLabel):
    """Row, column and gray value, in a volume also the plane; of a color image in the channel of the run.

    Where the size of a pixel is known, also the position in its unit.
    """

    def __init__(self, session: Session, canvas: Canvas) -> None:
        super().__init__()
        self._session = session
        canvas.placed_at.connect(self._show)

    def _show(self, place: Place | None) -> None:
        text, image = "", self._session.image
        if place is not None and image is not None and len(place) == image.ndim:
            pixel = tuple(map(round, place))
            if all(0 <= at < side for at, side in zip(pixel, image.shape, strict=True)):
                text = self._text(image, pixel, self._session.document.parameters.channel)
        self.setText(text)

    @staticmethod
    def _text(image: Image, pixel: tuple[int, ...], channel: str) -> str:
        value, size = image.gray_at(pixel, channel), shown_in(image.spacing, image.unit)
        lengths = [length_text(place, each, size.unit or "") for place, each in zip(pixel, size.spacing, strict=True)]
        places = dict(zip(("plane", "row", "col")[-image.ndim :], pixel, strict=True))
        named = dict(zip(("back", "down", "right")[-image.ndim :], lengths, strict=True))
        return _WORDS[image.ndim, size.unit is not None].format(value=value, **places, **named)


_WORDS = {
    (2, False): tr("row {row}, col {col}:  {value:g}"),
    (2, True): tr("row {row}, col {col}  ({down}, {right}):  {value:g}"),
    (3, False): tr("plane {plane}, row {row}, col {col}:  {value:g}"),
    (3, True): tr("plane {plane}, row {row}, col {col}  ({back}, {down}, {right}):  {value:g}"),
}
"""What is shown, by the number of axes and whether the size of a pixel is known."""


_STEPS = (25, 50, 100, 200, 400, 800, 1600)
"""Zooms to choose from [%]."""


class ZoomField(QComboBox):
    """Pixels of the screen per pixel of the image; Enter and Esc give the keyboard back to the canvas."""

    def __init__(self, canvas: ImageView) -> None:
        super().__init__()
        self._canvas = canvas
        self.setObjectName("zoom")
        self._line = QLineEdit()
        self.setEditable(True)
        self.setLineEdit(self._line)
        self.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
        self.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        self.setAccessibleName(tr("Zoom"))
        self.setToolTip(tr("Zoom: choose one, or type a number and press Enter. At 100 % pixels are shown one to one."))
        self.addItem(tr("Fit to window"))
        self.addItems([f"{step} %" for step in _STEPS])
        self.setFixedWidth(self.fontMetrics().horizontalAdvance("Fit to window") + 36)
        self.setCompleter(None)  # type: ignore[arg-type]  # Qt takes none for no completer
        self.activated.connect(self._choose)
        self._line.returnPressed.connect(self._take)
        canvas.view.sigRangeChanged.connect(self.refresh)
        self.refresh()

    def refresh(self, *_: object) -> None:
        """Show the present zoom, unless another one is being typed."""
        shown = self._canvas.shape is not None
        self.setEnabled(shown)
        if not self._line.isModified():
            self.setEditText(f"{_rounded(100.0 * self._canvas.magnification)} %" if shown else "")

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Show the present zoom instead of what has been typed."""
        super().focusOutEvent(event)
        self._line.setModified(False)
        self.refresh()

    def _choose(self, index: int) -> None:
        if index == 0:
            self._canvas.fit()
        else:
            self._canvas.zoom_to(_STEPS[index - 1] / 100.0)
        self._canvas.setFocus()

    def _take(self) -> None:
        """Use what has been typed; what is no number fits the image to the window."""
        typed = self._line.text().replace("%", "").replace(",", ".").strip()
        try:
            self._canvas.zoom_to(float(typed) / 100.0)
        except ValueError:
            self._canvas.fit()
        self._canvas.setFocus()


def _rounded(percent: float) -> str:
    """Three digits."""
    return f"{percent:.0f}" if percent >= 100.0 else f"{percent:.3g}"
