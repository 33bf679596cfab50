"""Every visible particle is drawn at its position, and nothing else is drawn."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cpm_app.views.items.discs import Discs
from cpm_app.views.theme import theme
from PySide6.QtGui import QColor, QImage, QPainter
from PySide6.QtWidgets import QStyleOptionGraphicsItem

pytestmark = pytest.mark.shared_window

HEIGHT, WIDTH = 120, 200
LARGEST = 6.0


def picture(position: np.ndarray, ratio: float, zoom: float, corner: np.ndarray) -> np.ndarray:
    """Discs alone, shape (rows, columns, blue green red alpha), on a screen with `ratio` pixels to a point.

    The image is enlarged by `zoom` to points of the screen, whose corner shows the position `corner`.
    """
    discs = Discs(theme.MOVING_COLOR, LARGEST, 0.0)
    discs.set_image_shape((1000, 1000))
    discs.show_discs(position)
    drawn = QImage(round(WIDTH * ratio), round(HEIGHT * ratio), QImage.Format.Format_ARGB32_Premultiplied)
    drawn.setDevicePixelRatio(ratio)
    drawn.fill(0)
    painter = QPainter(drawn)
    painter.scale(zoom, zoom)
    painter.translate(-corner[1], -corner[0])
    discs.paint(painter, QStyleOptionGraphicsItem())
    painter.end()
    return np.frombuffer(drawn.constBits(), np.uint8).reshape(drawn.height(), drawn.width(), 4).copy()


@pytest.mark.parametrize("ratio", [2])
@pytest.mark.parametrize("zoom", [0.4, 3.7])
@pytest.mark.parametrize("count", [200])
def test_visible_particles_cover_their_pixel_and_the_rest_stays_free(qapp, ratio, zoom, count):
    rng = np.random.default_rng(count)
    corner = np.array((101.3, 52.8))
    position = corner + rng.uniform(-0.5, 1.5, (count, 2)) * (HEIGHT, WIDTH) / zoom
    drawn = picture(position, ratio, zoom, corner)
    on_screen = (position - corner) * zoom * ratio
    row, col = np.floor(on_screen).astype(int).T
    in_sight = (row >= 0) & (row < HEIGHT * ratio) & (col >= 0) & (col < WIDTH * ratio)
    assert 0 < in_sight.sum() < count
    assert (drawn[row[in_sight], col[in_sight], 3] == 255).all()
    pixels = np.stack(np.indices(drawn.shape[:2]), axis=-1).reshape(-1, 2) + 0.5
    nearest = np.full(len(pixels), np.inf)
    for place in on_screen:
        np.minimum(nearest, np.hypot(*(pixels - place).T), out=nearest)
    nearest = nearest.reshape(drawn.shape[:2])
    assert not drawn[nearest > ratio * (0.5 * LARGEST + 1.0) + 1.0].any()


def test_a_particle_has_the_right_size_and_color(qapp):
    drawn = picture(np.array([[10.0, 20.0]]), 1, 5.0, np.zeros(2))
    blue, green, red, _ = drawn[50, 100]
    assert QColor(int(red), int(green), int(blue)) == QColor(theme.MOVING_COLOR)
    covered = drawn[..., 3].sum() / 255.0
    assert math.pi * (0.5 * LARGEST) ** 2 < covered < math.pi * (0.5 * LARGEST + 0.6) ** 2
