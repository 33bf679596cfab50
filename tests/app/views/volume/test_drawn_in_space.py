"""What is drawn in a volume is seen in space, and spheres and points are placed and dragged there."""

from __future__ import annotations

import numpy as np
import pytest
from cpm_app.model.document import edits
from cpm_app.views.export.frames import read_rgb_pixels
from cpm_app.views.features.volumes import SpaceFeature
from cpm_app.views.theme import theme
from cpm_app.views.theme.theme import get_canvas_style
from PySide6.QtCore import QPoint, Qt

from cpm_core.shapes import Box, Points, Sphere

pytestmark = pytest.mark.shared_window

MOVING = get_canvas_style().resolve_color(theme.MOVING_COLOR)
KEY, LEFT, CONTROL = Qt.Key, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.ControlModifier


@pytest.fixture
def space(volume, hand):
    """The view in space of the window, drawn."""
    panel = volume.get_feature(SpaceFeature).panel
    panel.bar.checks["slices"].setChecked(False)  # another test may have shown them
    view = panel.view
    hand.wait(lambda: view.isVisible() and view.camera is not None and view.is_idle)
    return view


def draw(window, shape) -> None:
    window.session.edit("draw", lambda document: edits.add_shape(document, shape))


def on_screen(view, place) -> QPoint:
    """Where the view shows a place of the volume."""
    seen = view.camera.project(np.array([place]), view.picture_size)[0] / view.devicePixelRatioF()
    return QPoint(round(float(seen[0])), round(float(seen[1])))


def inks(view) -> set[str]:
    """The colors in the picture."""
    return {
        "#" + bytes(color).hex() for color in np.unique(read_rgb_pixels(view.grab().toImage()).reshape(-1, 3), axis=0)
    }


def test_what_is_drawn_is_seen_in_space_in_its_color(volume, hand, space) -> None:
    volume.get_feature(SpaceFeature).panel.bar.checks["slices"].setChecked(False)  # which may have the same color
    draw(volume, Box((4.0, 5.0, 6.0), (14.0, 18.0, 20.0)))
    hand.wait(lambda: space.is_idle and MOVING in inks(space))
    volume.session.select_shape(0)
    hand.wait(lambda: space.is_idle and theme.SELECTED_COLOR in inks(space))
    assert MOVING not in inks(space)
    volume.canvas_area.canvas.layers.drawing.set_shown(False)
    hand.wait(lambda: space.is_idle and theme.SELECTED_COLOR not in inks(space))


@pytest.mark.parametrize(("key", "kind"), [(KEY.Key_C, Sphere), (KEY.Key_P, Points), (KEY.Key_S, None)])
def test_a_click_on_what_is_seen_draws_there_with_sphere_and_point(volume, hand, space, key, kind) -> None:
    check = volume.get_feature(SpaceFeature).panel.bar.checks["slices"]
    check.setChecked(True)
    hand.wait(lambda: space.is_idle)
    hand.key(key)
    hand.qtbot.mouseClick(space, LEFT, pos=space.rect().center())
    hand.wait(lambda: space.is_idle)
    place = volume.session.scene.slices.voxel
    shapes = volume.session.document.shapes
    if kind is None:
        assert shapes == ()
        return
    (shape,) = shapes
    assert isinstance(shape, kind)
    at = shape.center if isinstance(shape, Sphere) else shape.positions[0]
    assert np.abs(np.subtract(at, place)).max() <= 0.5 + 1e-9
