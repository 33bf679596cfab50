"""Color maps that color-blind people can read: brighter always means more."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QIcon, QImage, QPixmap

from cpm_app.model.text.language import tr

ColorTable = NDArray[np.uint8]

GRAY_MAP = "grey"
"""Name of the gray map, from black to white."""

INVERTED_MAP = "inverted"
"""Name of the gray map from white to black."""

COLOR_MAPS: dict[str, str] = {
    GRAY_MAP: tr("Gray"),
    INVERTED_MAP: tr("Gray, inverted"),
    "viridis": tr("Viridis"),
    "cividis": tr("Cividis"),
    "magma": tr("Magma"),
    "inferno": tr("Inferno"),
    "plasma": tr("Plasma"),
}
"""Titles of the color maps by their names."""


@lru_cache(maxsize=32)
def color_table(name: str, entries: int = 256, begin: float = 0.0) -> ColorTable:
    """Return the colors of a map from low to high.

    Parameters
    ----------
    name : str
        One of `COLOR_MAPS`.
    entries : int
        Number of colors.
    begin : float
        Fraction of the map that is left out at its dark end.

    Returns
    -------
    array, shape (entries, 3), uint8
        RGB values, read-only.
    """
    at = np.linspace(begin, 1.0, entries)
    if name in (GRAY_MAP, INVERTED_MAP):
        ramp = np.rint(255.0 * (at if name == GRAY_MAP else 1.0 - at)).astype(np.uint8)
        colors = np.repeat(ramp[:, None], 3, axis=1)
    else:
        colors = np.asarray(pg.colormap.get(name).map(at, mode="byte")[:, :3], dtype=np.uint8)
    colors.flags.writeable = False
    return colors


@lru_cache(maxsize=32)
def ramp_table(color: str) -> ColorTable:
    """Return the shades of a color from black, shape (256, 3)."""
    return np.rint(np.outer(np.arange(256), QColor(color).getRgb()[:3]) / 255.0).astype(np.uint8)  # type: ignore[index]


def draw_color_strip(name: str, width: int, height: int, begin: float = 0.0) -> QPixmap:
    """Draw a map as a strip of a size in px, from low on the left to high on the right."""
    row = color_table(name, 256, begin)
    image = QImage(row.tobytes(), len(row), 1, 3 * len(row), QImage.Format.Format_RGB888)
    ways = (Qt.AspectRatioMode.IgnoreAspectRatio, Qt.TransformationMode.SmoothTransformation)
    return QPixmap.fromImage(image.scaled(width, height, *ways))


def create_map_icon(name: str) -> QIcon:
    """Return the icon of a map."""
    return QIcon(draw_color_strip(name, 36, 12))
