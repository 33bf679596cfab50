"""The scale bar has the length of its label, in every unit and at every zoom."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cpm_app.model.display.display_image import DisplayImage
from cpm_app.model.display.lengths import find_scale_bar
from cpm_app.views.layers.annotations import MAX_SCALE_BAR_LENGTH
from hypothesis import given
from hypothesis import strategies as st

from cpm_core.image.geometry import Geometry
from cpm_core.image.image import Image

pytestmark = pytest.mark.shared_window

METRES = {"nm": 1e-9, "µm": 1e-6, "mm": 1e-3, "cm": 1e-2, "m": 1.0}


def length_said(label: str, unit: str) -> float:
    """Length that a label states, in a unit."""
    figure, name = label.split()
    number = float(figure.replace(",", ""))
    return number if name == unit else number * METRES[name] / METRES[unit]


@given(st.floats(0.01, 100.0), st.floats(1e-4, 1e3), st.sampled_from([*METRES, "furlong", None]))
def test_a_bar_is_as_long_as_its_label_within_a_pixel(zoom, size, unit):
    shown = find_scale_bar(MAX_SCALE_BAR_LENGTH / zoom, size, unit)
    on_screen = shown.pixels * zoom
    said = length_said(shown.label, unit or "px")
    assert on_screen * (size if unit else 1.0) / zoom == pytest.approx(said, rel=1e-9)
    assert 0.4 * MAX_SCALE_BAR_LENGTH - 1e-6 <= on_screen <= MAX_SCALE_BAR_LENGTH + 1e-6
    assert f"{said:e}"[0] in "125" or unit in ("cm", None, "furlong")


def show(window, unit: str | None, geometry: Geometry | None = None) -> None:
    """Put an image with pixels of 0.5 along the columns before the window."""
    session = window.session
    values = np.random.default_rng(0).uniform(size=(64, 64))
    image = Image(values, spacing=(0.25, 0.5), unit=unit, geometry=geometry)
    session.store.set_scene(
        replace(session.scene, image=image, display=DisplayImage.from_shades(np.zeros((64, 64), np.uint8)))
    )


def test_the_bar_follows_the_zoom_and_is_shown_only_with_a_unit(window, hand):
    layer = hand.canvas.layers["scale_bar"]
    show(window, None)
    assert not layer.item.isVisible()
    show(window, "µm")
    labels = set()
    for factor in (1.0, 2.6, 2.6, 0.02):
        hand.canvas.zoom_by(factor)
        pixel = hand.canvas.view.viewPixelSize()[0]
        assert abs(layer.bar.pixels * 0.5 - length_said(layer.bar.label, "µm")) <= 0.5 * pixel
        place = layer.item.mapRectToScene(layer.item.boundingRect())
        assert hand.canvas.view.boundingRect().contains(place)
        labels.add(layer.bar.label)
    assert len(labels) == 4
    window.actions_by_name["layer_scale_bar"].trigger()
    assert not layer.item.isVisible()


def test_the_position_of_the_pointer_is_also_shown_in_the_unit_and_the_space_of_the_file(window, hand):
    show(window, "µm")
    hand.move(10, 40)
    assert window.pointer_readout.text().startswith("row 10, col 40  (2.5 µm, 20 µm):  ")
    show(window, "mm", Geometry((10.0, -20.0, 30.0), convention="RAS"))
    hand.move(10, 40)
    assert window.pointer_readout.text().startswith("row 10, col 40  (RAS 30.00, -17.50, 30.00 mm):  ")
    show(window, None)
    hand.move(11, 40)
    assert window.pointer_readout.text().startswith("row 11, col 40:  ")
