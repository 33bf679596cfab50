"""The small pictures of presets: what the canvas shows, cut to their size."""

from __future__ import annotations

from PySide6.QtCore import QBuffer, QIODevice, QRect, QSize, Qt
from PySide6.QtGui import QColor, QImage, QImageWriter, QPixmap

from app.views.theme import theme

PICTURE = QSize(160, 94)


def picture_of(canvas: QImage) -> bytes:
    """A picture of the canvas at the size of the gallery, twice as fine (PNG)."""
    size = QSize(2 * PICTURE.width(), 2 * PICTURE.height())
    across = min(canvas.width(), canvas.height() * size.width() // size.height())
    down = min(canvas.height(), canvas.width() * size.height() // size.width())
    middle = QRect((canvas.width() - across) // 2, (canvas.height() - down) // 2, across, down)
    scaled = canvas.copy(middle).scaled(
        size, Qt.AspectRatioMode.IgnoreAspectRatio, Qt.TransformationMode.SmoothTransformation
    )
    buffer = QBuffer()
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    QImageWriter(buffer, b"png").write(scaled)
    return bytes(buffer.data().data())


def no_picture() -> QPixmap:
    """What stands for a picture that is not there."""
    pixmap = QPixmap(PICTURE)
    pixmap.fill(QColor(theme.CANVAS))
    return pixmap
