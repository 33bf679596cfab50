"""A tile seen large."""

from __future__ import annotations

from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QLabel, QVBoxLayout, QWidget

from app.model.text.language import tr
from app.session.features.parameter_sweep import Done
from app.views.mosaic.picture import Picture
from app.views.mosaic.tile import words
from app.views.theme import theme


class EnlargedTile(QDialog):
    """Shows one run as large as the user makes the dialog; accepted when it is to be taken.

    Parameters
    ----------
    parent : QWidget
        The mosaic.
    done : Done
        The run.
    caption : str
        Its values in words.
    picture : Picture
        The image.
    """

    def __init__(self, parent: QWidget, done: Done, caption: str, picture: Picture) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(caption)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        self.take = buttons.addButton(tr("Take these values"), QDialogButtonBox.ButtonRole.AcceptRole)
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        about = QLabel(f"<b>{caption}</b> · {words(done).replace(chr(10), ', ')}")
        layout = QVBoxLayout(self)
        layout.addWidget(_Canvas(done, picture), 1)
        layout.addWidget(about)
        layout.addWidget(buttons)


class _Canvas(QWidget):
    def __init__(self, done: Done, picture: Picture) -> None:
        super().__init__()
        self._done = done
        self._picture = picture
        self.setMinimumSize(320, 240)

    def sizeHint(self) -> QSize:
        """Large."""
        return QSize(640, 560)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw it on the ground of the canvas."""
        painter = QPainter(self)
        painter.fillRect(self.rect(), QColor(theme.CANVAS))
        result = self._done.result
        self._picture.draw(painter, QRectF(self.rect()), result.contours if result else ())
        painter.end()
