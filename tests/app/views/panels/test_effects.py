"""Sliders that decide stand first, and each filter of contours tells what it leaves while it is moved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from cpm_app.model.display.effects import MOTION_PARAMETERS, describe_contours_left, measure_motion
from cpm_app.model.document import edits
from cpm_app.model.parameters.controls import MAIN_CONTROLS, build_controls, set_control_value
from cpm_app.views.window.window import MainWindow
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from PySide6.QtCore import QPoint, Qt

from cpm_core import PRESETS, Engine, circle
from cpm_core.parameters import Parameters
from cpm_core.shapes import Circle
from tests.app.conftest import Hand

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
LEFT = Qt.MouseButton.LeftButton

DISCS = ((48, 40, 28, 90.0), (48, 40, 12, 90.0), (28, 100, 14, 180.0), (76, 100, 10, 60.0))


@pytest.fixture
def found(window: MainWindow, hand: Hand, tmp_path: Path) -> MainWindow:
    """A window in which four contours have been found, one in another and one weak."""
    row, col = np.indices((96, 128))
    values = np.full(row.shape, 20.0)
    for at_row, at_col, radius, rise in DISCS:
        values += np.where(np.hypot(row - at_row, col - at_col) < radius, rise, 0.0)
    path = tmp_path / "discs.npy"
    np.save(path, values)
    session = window.session
    session.open_file(path)
    hand.wait(lambda: session.document.image is not None and session.document.image.name == "discs.npy")
    session.edit("reach", lambda document: replace(document, parameters=Parameters()))
    for at_row, at_col, radius, _ in DISCS:
        circle = Circle((float(at_row), float(at_col)), 0.75 * radius)
        session.edit("draw", lambda document, circle=circle: edits.add_shape(document, circle))
    hand.canvas.setFocus()
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: session.idle)
    return window


def test_motion_comes_first_then_what_matters_for_starts_then_what_decides_which_contours_there_are() -> None:
    names = [control.name for control in build_controls()]
    filters = ("edge_floor", "max_gap", "min_strength", "min_length")
    advanced = [control.name for control in build_controls() if control.advanced and control.name not in MAIN_CONTROLS]
    assert names[:6] == ["beta", "ratio", "annealing", "reach", "weakest_edge", "smoothing"]
    assert max(map(names.index, MAIN_CONTROLS)) < min(map(names.index, filters))
    assert max(map(names.index, filters)) < min(map(names.index, advanced))


CROSSED = np.full((72, 72), 40.0)
CROSSED[20:50, 12:60] += 90.0
CROSSED[30:36, :] += 70.0
"""A box that a band crosses, so that there are junctions."""

START = replace(PRESETS["shape"], scales=1)
ENGINE = Engine(CROSSED, START)


@cache
def moved(name: str, value: float) -> tuple[list[Mapping[str, float]], float]:
    """Figures of the steps after a slider has been moved during a run, and the length at rest [px]."""
    state, changed, steps = ENGINE.start(circle((26.0, 20.0), 4.0)), set_control_value(START, name, value), []
    while state.step < 5:
        state = ENGINE.step(state, START)
    while not state.stop_reason:
        state = ENGINE.step(state, changed)
        steps.append(measure_motion(state, changed, 0.0))
    return steps[:20], sum(contour.length for contour in ENGINE.result(state, changed).contours)


@pytest.mark.parametrize("name", MOTION_PARAMETERS)
@settings(max_examples=12, deadline=None)
@given(st.data())
def test_the_number_next_to_a_slider_goes_where_its_explanation_says(name, data) -> None:
    control = next(one for one in build_controls() if one.name == name)
    value = st.sampled_from(np.linspace(control.slider_low, control.slider_high, 6).tolist())
    less, more = sorted((data.draw(value), data.draw(value)))
    assume(less < more)
    (slow, short), (fast, long) = moved(name, less), moved(name, more)
    least, most = (long, short) if name == "beta" else (short, long)
    assert most >= 0.97 * least
    if name == "beta":
        assert np.mean([one[name] for one in slow]) > np.mean([one[name] for one in fast])
    if name == "annealing":
        assert all(one[name] <= other[name] for one, other in zip(slow, fast, strict=False))


def test_contours_that_a_filter_leaves_are_counted() -> None:
    assert describe_contours_left(0, 4) == "4 → 0 contours"
    assert describe_contours_left(2, None) == "2 contours"
    assert describe_contours_left(1, None) == "1 contour"
    assert describe_contours_left(0, None) == ""


@pytest.mark.usefixtures("found")
def test_a_filter_that_is_dragged_tells_before_and_after_and_then_what_is_left(window, hand) -> None:
    row = window.panels["run"].parameters.rows["min_strength"]
    assert row.effect.text() == "4 contours"
    slider = row.slider
    strengths = sorted(contour.strength for contour in window.session.scene.contours)
    between = 0.5 * (strengths[0] + strengths[1])
    hand.qtbot.mousePress(slider, LEFT, pos=QPoint(6, slider.height() // 2))
    slider.setSliderPosition(round(between / slider._step))
    value = window.session.document.parameters.min_strength
    left = sum(strength >= value for strength in strengths)
    hand.wait(lambda: row.effect.text() == f"4 → {left} contours")
    hand.qtbot.mouseRelease(slider, LEFT, pos=QPoint(6, slider.height() // 2))
    hand.wait(lambda: window.session.idle and len(window.session.scene.contours) == left)
    assert row.effect.text() == f"{left} contours"
