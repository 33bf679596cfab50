"""Only the visible part of an image is drawn, in about as many pixels as the screen has, and colors stay colors."""

from __future__ import annotations

import numpy as np
import PIL.Image
import pytest
from cpm_app.model.display.display_image import DisplayImage, IntensityWindow
from cpm_app.views.items.tiled_image import TiledImage, visible_part
from hypothesis import given, settings
from hypothesis import strategies as st
from PySide6.QtCore import QRectF
from PySide6.QtGui import QImage, QPainter
from PySide6.QtWidgets import QStyleOptionGraphicsItem

from cpm_core import Image

pytestmark = pytest.mark.shared_window

SIDES = st.integers(1, 700)
MOST_BESIDE = 2 * 256
"""Pixels along each axis that a part may have beside those that are seen."""


@settings(deadline=None, max_examples=30)
@given(SIDES, SIDES, st.integers(0, 2**31))
def test_a_pixel_of_a_level_is_the_mean_of_those_that_it_covers(rows, cols, seed):
    display = DisplayImage.from_shades(np.random.default_rng(seed).integers(0, 256, (rows, cols), np.uint8))
    assert max(display.levels[-1].shape) <= 256
    for number, level in enumerate(display.levels):
        size = 2**number
        whole = display.shades[: rows // size * size, : cols // size * size].astype(float)
        means = whole.reshape(rows // size, size, cols // size, size).mean(axis=(1, 3))
        assert level.shape == (-(-rows // size), -(-cols // size))
        assert np.abs(level[: rows // size, : cols // size] - means).max(initial=0.0) <= 0.5 * number


@settings(deadline=None, max_examples=50)
@given(SIDES, SIDES, st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.001, 1.0), st.floats(0.001, 60.0))
def test_a_part_covers_what_is_seen_with_no_more_pixels_than_the_screen_needs(rows, cols, down, right, share, zoom):
    display = DisplayImage.from_shades(np.zeros((rows, cols), np.uint8))
    seen = QRectF(right * cols - 0.5, down * rows - 0.5, share * cols, share * rows)
    seen = seen.intersected(QRectF(-0.5, -0.5, cols, rows))
    level, top, left, bottom, end = visible_part(display, seen, zoom)
    size = 2.0**level
    assert level == 0 or size * zoom <= 1.0 + 1e-5
    assert left * size - 0.5 <= seen.left() + 1e-6
    assert top * size - 0.5 <= seen.top() + 1e-6
    assert end * size - 0.5 >= seen.right() - 1e-6
    assert bottom * size - 0.5 >= seen.bottom() - 1e-6
    if level < len(display.levels) - 1:
        assert end - left <= 2.0 * max(zoom, 0.5) * seen.width() + MOST_BESIDE
        assert bottom - top <= 2.0 * max(zoom, 0.5) * seen.height() + MOST_BESIDE


@pytest.mark.parametrize("make_display", [DisplayImage.from_image, DisplayImage.from_visible])
def test_finer_levels_of_a_file_are_read_where_the_screen_has_room_for_them(make_display):
    values = np.random.default_rng(1).integers(0, 256, (1600, 1400), np.uint8)
    read = []

    class Level:
        shape = values.shape

        def __getitem__(self, part):
            read.append(part)
            return values[part]

    image = Image(values[::2, ::2], finer=(Level(),))
    display = make_display(image, IntensityWindow(0.0, 255.0))
    assert display.shape == image.shape
    seen = QRectF(300.0, 400.0, 100.0, 50.0)
    assert visible_part(display, seen, 1.0)[0] == 0
    assert not read
    level, top, left, bottom, end = visible_part(display, seen, 2.0)
    assert (level, top, left, bottom, end) == (-1, 768, 512, 1024, 1024)
    shades = display.levels[level - display.finest][top:bottom, left:end]
    assert (shades == values[top:bottom, left:end]).all()
    assert len(read) == 1


def test_of_an_image_that_is_exposed_as_a_whole_only_what_is_on_the_screen_is_read():
    read = []

    class Level:
        shape = (6000, 6000)

        def __getitem__(self, part):
            read.append([side.stop - side.start for side in part])
            return np.zeros(read[-1], np.uint8)

    item = TiledImage(0.0)
    image = Image(np.zeros((3000, 3000), np.uint8), finer=(Level(),))
    item.show_image(DisplayImage.from_image(image, IntensityWindow(0.0, 255.0)))
    screen, option = QImage(300, 200, QImage.Format.Format_RGB32), QStyleOptionGraphicsItem()
    painter = QPainter(screen)
    painter.scale(4.0, 4.0)
    painter.translate(-1000.0, -1500.0)
    option.exposedRect = item.boundingRect()
    item.paint(painter, option)
    painter.end()
    assert len(read) == 1
    assert max(read[0]) <= 300 + MOST_BESIDE


@settings(deadline=None, max_examples=30)
@given(st.integers(1, 40), st.integers(1, 40), st.booleans(), st.integers(0, 2**31))
def test_the_picture_of_a_part_holds_its_very_pixels(rows, cols, colored, seed):
    shape = (rows + 5, cols + 7, 3) if colored else (rows + 5, cols + 7)
    pixels = np.random.default_rng(seed).integers(0, 256, shape, np.uint8)
    item = TiledImage(0.0)
    item.show_image(DisplayImage.from_shades(pixels))
    picture = item._render_part((0, 3, 2, 3 + rows, 2 + cols))
    seen = np.frombuffer(picture.constBits(), np.uint8).reshape(rows, -1, 4)[:, :cols, 2::-1]
    expected = pixels[3 : 3 + rows, 2 : 2 + cols]
    np.testing.assert_array_equal(seen, expected if colored else np.repeat(expected[..., None], 3, axis=2))


@pytest.fixture
def colored(window, hand, tmp_path):
    """The window on a color image: its left half red, its right half blue, with a bright dot."""
    pixels = np.zeros((60, 80, 3), np.uint8)
    pixels[:, :40], pixels[:, 40:] = (200, 40, 40), (40, 60, 200)
    pixels[28:33, 10:15] = 255
    PIL.Image.fromarray(pixels).save(tmp_path / "colored.png")
    window.session.open_file(tmp_path / "colored.png")
    hand.wait(lambda: window.session.document.image.name == "colored.png" and window.session.idle)
    return window


def test_a_color_image_is_shown_in_its_colors(colored, hand):
    assert hand.color_at(10.0, 20.0) == (200, 40, 40)
    assert hand.color_at(10.0, 60.0) == (40, 60, 200)


def test_levels_brighten_the_colors_and_keep_them_apart(colored, hand):
    layer = hand.canvas.layers["image"]
    layer.set_window(0.0, 204.0)
    assert hand.color_at(10.0, 20.0) == (250, 50, 50)
    assert hand.color_at(10.0, 60.0) == (50, 75, 250)
    layer.set_option("range", "0")
    assert hand.color_at(10.0, 60.0) == (40, 60, 200)


def test_a_gray_image_after_a_colored_one_has_no_colors(colored, hand, image_file):
    hand.canvas.layers["image"].set_window(0.0, 204.0)
    colored.session.open_file(image_file)
    hand.wait(lambda: colored.session.document.image.name == image_file.name and colored.session.idle)
    red, green, blue = hand.color_at(32.0, 32.0)
    assert red == green == blue > 250
