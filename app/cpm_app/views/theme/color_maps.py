"""Color maps for color-blind people: brighter always means more."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtCore import Qt
from PySide6.QtGui import QIcon, QImage, QPixmap

from cpm_app.model.text.language import tr

Table = NDArray[np.uint8]

GRAY, INVERTED = "grey", "inverted"

MAPS: dict[str, str] = {
    GRAY: tr("Gray"),
    INVERTED: tr("Gray, inverted"),
    "viridis": tr("Viridis"),
    "cividis": tr("Cividis"),
    "magma": tr("Magma"),
    "inferno": tr("Inferno"),
    "plasma": tr("Plasma"),
}
"""Names and titles."""


@lru_cache(maxsize=32)
def table(name: str, entries: int = 256, begin: float = 0.0) -> Table:
    """Colors of a map from low to high, shape (entries, 3), read-only.

    Parameters
    ----------
    name : str
        One of `MAPS`.
    entries : int
        Number of colors.
    begin : float
        Part of the map that is left out at its dark end.
    """
    at = np.linspace(begin, 1.0, entries)
    if name in (GRAY, INVERTED):
        ramp = np.rint(255.0 * (at if name == GRAY else 1.0 - at)).astype(np.uint8)
        colors = np.repeat(ramp[:, None], 3, axis=1)
    else:
        colors = np.asarray(pg.colormap.get(name).map(at, mode="byte")[:, :3], dtype=np.uint8)
    colors.flags.writeable = False
    return colors


def strip(name: str, width: int, height: int, begin: float = 0.0) -> QPixmap:
    """A map as a strip of a size in px, from low on the left to high on the right."""
    row = table(name, 256, begin)
    image = QImage(row.tobytes(), len(row), 1, 3 * len(row), QImage.Format.Format_RGB888)
    ways = (Qt.AspectRatioMode.IgnoreAspectRatio, Qt.TransformationMode.SmoothTransformation)
    return QPixmap.fromImage(image.scaled(width, height, *ways))


def icon(name: str) -> QIcon:
    """Icon of a map."""
    return QIcon(strip(name, 36, 12))
