"""Slices of large volumes: a preview is shown at once, and all pixels follow from another thread."""

from __future__ import annotations

import numpy as np
import pytest
from cpm_app.model.display import display_image
from cpm_app.model.display.display_image import DisplayImage, IntensityWindow
from cpm_app.session.features import slices
from cpm_app.views.features.volumes import SlicesFeature
from PySide6.QtCore import Qt

from cpm_core.image.image import Image
from tests.app.views.volume.conftest import ball, open_file

pytestmark = pytest.mark.shared_window

WHOLE = IntensityWindow(20.0, 200.0)


@pytest.fixture
def large(monkeypatch, window, hand, volume_file):
    """A window on a volume whose slices count as large."""
    monkeypatch.setattr(slices, "MAX_SYNC_PIXELS", 100)
    monkeypatch.setattr(display_image, "_PREVIEW_SIDE", 8)
    open_file(window, hand, volume_file)
    return window


def shown(view) -> DisplayImage:
    return view.drawn_scene.display


def test_a_large_slice_is_shown_as_a_preview_and_then_with_all_its_pixels(large, hand) -> None:
    canvas, sides = large.canvas_area.canvas, large.get_feature(SlicesFeature).sides
    for index in (13, 14):
        hand.key(Qt.Key.Key_PageDown)
        assert shown(canvas).finest == 2
        assert shown(canvas).shape == (28, 32)
        assert large.session.scene.slices.current.index == index
        hand.wait(lambda: shown(canvas).finest == 0)
    np.testing.assert_array_equal(canvas.layers.image.shades, display_image.apply_window(ball()[14], WHOLE))
    hand.wait(lambda: all(shown(view).finest == 0 for view in sides))
    assert {shown(view).shape for view in sides} == {(24, 32), (24, 28)}


def test_a_slice_shares_the_gray_levels_of_its_volume() -> None:
    volume = Image(ball(), (3.0, 2.0, 1.0), "mm", "ball")
    assert volume.gray_range == (20.0, 200.0)
    for axis, index, sides in ((0, 3, (2.0, 1.0)), (1, 14, (3.0, 1.0)), (2, 31, (3.0, 2.0))):
        cut = volume.slice_across(axis, index)
        assert np.shares_memory(cut.values, volume.values)
        np.testing.assert_array_equal(cut.values, np.take(volume.values, index, axis))
        assert (cut.spacing, cut.unit, cut.source) == (sides, "mm", "ball")
        assert cut.gray_range == (cut.values.min(), cut.values.max())
