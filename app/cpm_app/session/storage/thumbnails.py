"""Thumbnails of recent work, one for each file, in the user's cache folder."""

from __future__ import annotations

import hashlib
import logging
from contextlib import suppress
from pathlib import Path

from PySide6.QtCore import QRect, QSize, QStandardPaths, Qt
from PySide6.QtGui import QImage

THUMBNAIL_SIZE = QSize(320, 200)
"""Size of a thumbnail [px]."""

MAX_THUMBNAILS = 40
"""Largest number of thumbnails that are kept."""

_log = logging.getLogger(__name__)


def thumbnails_folder() -> Path:
    """Return the folder of thumbnails in the user's cache."""
    return Path(QStandardPaths.writableLocation(QStandardPaths.StandardLocation.GenericCacheLocation)) / "cpm/pictures"


class ThumbnailStore:
    """Thumbnails in a folder, which may be missing; failures to write them are only logged."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def save_thumbnail(self, file: Path, image: QImage) -> None:
        """Keep the middle of an image as the thumbnail of a file; remove the oldest ones beyond `MAX_THUMBNAILS`."""
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            _log.warning("no pictures can be kept in %s: %s", self._folder, error)
            return
        if not image.isNull():
            crop_middle(image, THUMBNAIL_SIZE).save(str(self._thumbnail_path(file)))
        with suppress(OSError):  # another window may remove the same ones
            for old in sorted(self._folder.glob("*.png"), key=lambda path: path.stat().st_mtime)[:-MAX_THUMBNAILS]:
                old.unlink(missing_ok=True)

    def load_thumbnail(self, file: Path) -> QImage:
        """Return the thumbnail of a file; a null image if there is none."""
        return QImage(str(self._thumbnail_path(file)))

    def clear(self) -> None:
        """Remove all thumbnails."""
        for picture in self._folder.glob("*.png"):
            with suppress(OSError):
                picture.unlink(missing_ok=True)

    def _thumbnail_path(self, file: Path) -> Path:
        name = hashlib.sha256(str(file.absolute()).encode("utf-8", "surrogatepass")).hexdigest()[:24]
        return self._folder / f"{name}.png"


def crop_middle(image: QImage, size: QSize) -> QImage:
    """Crop an image around its middle to the proportions of `size`, and scale it to that size."""
    across = min(image.width(), max(1, image.height() * size.width() // size.height()))
    down = min(image.height(), max(1, image.width() * size.height() // size.width()))
    part = QRect((image.width() - across) // 2, (image.height() - down) // 2, across, down)
    ratio, smooth = Qt.AspectRatioMode.IgnoreAspectRatio, Qt.TransformationMode.SmoothTransformation
    return image.copy(part).scaled(size, ratio, smooth)
