"""Small pictures of recent work, one for each file, in the user's cache folder."""

from __future__ import annotations

import hashlib
import logging
from contextlib import suppress
from pathlib import Path

from PySide6.QtCore import QRect, QSize, QStandardPaths, Qt
from PySide6.QtGui import QImage

SIZE = QSize(320, 200)
"""Size of a picture [px]."""

MOST = 40
"""Largest number of pictures that are kept."""

_log = logging.getLogger(__name__)


def folder_of_pictures() -> Path:
    """The folder in the user's cache."""
    return Path(QStandardPaths.writableLocation(QStandardPaths.StandardLocation.GenericCacheLocation)) / "cpm/pictures"


class Pictures:
    """The pictures in a folder, which may be missing; what cannot be kept is left out."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def put(self, file: Path, image: QImage) -> None:
        """Keep the middle of an image as the picture of a file, and remove the oldest pictures beyond `MOST`."""
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            _log.warning("no pictures can be kept in %s: %s", self._folder, error)
            return
        if not image.isNull():
            middle(image, SIZE).save(str(self._place(file)))
        with suppress(OSError):  # another window may remove the same ones
            for old in sorted(self._folder.glob("*.png"), key=lambda path: path.stat().st_mtime)[:-MOST]:
                old.unlink(missing_ok=True)

    def get(self, file: Path) -> QImage:
        """The picture of a file; a null image where there is none."""
        return QImage(str(self._place(file)))

    def clear(self) -> None:
        """Remove all."""
        for picture in self._folder.glob("*.png"):
            with suppress(OSError):
                picture.unlink(missing_ok=True)

    def _place(self, file: Path) -> Path:
        name = hashlib.sha256(str(file.absolute()).encode("utf-8", "surrogatepass")).hexdigest()[:24]
        return self._folder / f"{name}.png"


def middle(image: QImage, size: QSize) -> QImage:
    """The largest part of an image around its middle that has the proportions of `size`, in that size."""
    across = min(image.width(), max(1, image.height() * size.width() // size.height()))
    down = min(image.height(), max(1, image.width() * size.height() // size.width()))
    part = QRect((image.width() - across) // 2, (image.height() - down) // 2, across, down)
    ratio, smooth = Qt.AspectRatioMode.IgnoreAspectRatio, Qt.TransformationMode.SmoothTransformation
    return image.copy(part).scaled(size, ratio, smooth)
