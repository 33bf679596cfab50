"""Sliders that decide stand first, and each filter of contours tells what it leaves while it is moved."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PySide6.QtCore import QPoint, Qt

from app.model.display.filter_counts import Distribution, FilterCounts
from app.model.parameters.controls import MAIN, controls
from cpm_core.contours.contour import Contour
from cpm_core.contours.measurements import measure
from tests.app.panels.test_contour_table import found  # noqa: F401  # a fixture

pytestmark = pytest.mark.shared_window

LEFT = Qt.MouseButton.LeftButton


def test_motion_comes_first_then_what_matters_for_starts_then_what_decides_which_contours_there_are() -> None:
    names = [control.name for control in controls()]
    filters = ("edge_floor", "max_gap", "min_strength", "min_length")
    advanced = [control.name for control in controls() if control.advanced and control.name not in MAIN]
    assert names[:6] == ["beta", "ratio", "annealing", "reach", "weakest_edge", "smoothing"]
    assert max(map(names.index, MAIN)) < min(map(names.index, filters))
    assert max(map(names.index, filters)) < min(map(names.index, advanced))


@settings(max_examples=60, deadline=None)
@given(st.lists(st.integers(1, 40), min_size=1, max_size=30), st.lists(st.integers(0, 45), min_size=1, max_size=5))
def test_a_raised_threshold_is_counted_exactly_while_contours_disappear(values, thresholds) -> None:
    distribution = Distribution()
    distribution.update("step 7", 0.0, values)
    for threshold in sorted(thresholds):
        assert distribution.above(threshold) == sum(value >= threshold for value in values)
        distribution.update("step 7", float(threshold), [value for value in values if value >= threshold])
        assert len(distribution.values) == len(values), "lowered again, they are back"
        assert distribution.above(0.0) == len(values)


def test_gaps_are_counted_between_loose_ends_alone() -> None:
    line = np.column_stack([np.zeros(20), np.arange(20.0)])
    contours = [
        Contour(line, False),
        Contour(line + np.array([0.0, 25.0]), False),
        Contour(line + np.array([0.0, 60.0]), False, junctions=(True, False)),
        Contour(line[::4] + np.array([40.0, 0.0]), True),
    ]
    counts = FilterCounts()
    counts.update("a", {}, contours, measure(contours))
    assert [counts.words("max_gap", gap, None) for gap in (0.0, 5.0, 6.5, 18.0)] == [
        "", "up to 0 gaps", "up to 1 gaps", "up to 1 gaps"
    ]  # fmt: skip
    assert counts.words("min_length", 100.0, 4) == "4 → 0 contours"
    assert counts.words("min_length", 30.0, None) == "1 contour"
    assert counts.words("beta", 1.0, None) == ""


@pytest.mark.usefixtures("found")
def test_a_filter_that_is_dragged_tells_before_and_after_and_then_what_is_left(window, hand) -> None:
    row = window.panels["run"].parameters.rows["min_strength"]
    assert row.effect.text() == "4 contours"
    slider = row.slider
    strengths = sorted(item.measures.strength for item in window.workspace.review.items)
    between = 0.5 * (strengths[0] + strengths[1])
    hand.qtbot.mousePress(slider, LEFT, pos=QPoint(6, slider.height() // 2))
    slider.setSliderPosition(round(between / slider._step))
    value = window.session.document.parameters.min_strength
    left = sum(strength >= value for strength in strengths)
    assert row.effect.text() == f"4 → {left} contours"
    hand.qtbot.mouseRelease(slider, LEFT, pos=QPoint(6, slider.height() // 2))
    hand.wait(lambda: window.session.idle and len(window.workspace.review.items) == left)
    assert row.effect.text() == f"{left} contours"
