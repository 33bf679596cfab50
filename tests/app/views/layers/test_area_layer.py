"""The area of a start is shown as long as the reach limits a run, and no slider of the motion makes it again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import Qt

from cpm_core.field import scale_space
from cpm_core.parameters import PRESETS, UNLIMITED_REACH
from cpm_core.segmentation import local_fields
from cpm_core.segmentation.engine import Engine
from cpm_core.shapes import Circle

pytestmark = pytest.mark.shared_window

KEY = Qt.Key


def area(hand):
    """Shades of the area that is shown, None without one."""
    return hand.canvas.layers["start_area"].shades


def counted(monkeypatch, module, name):
    """List that grows with each call of a function from now on."""
    calls, original = [], getattr(module, name)
    monkeypatch.setattr(module, name, lambda *given, **named: calls.append(name) or original(*given, **named))
    return calls


def set_value(window, name, value):
    """Type a value into the field next to a slider."""
    row = window.panels["run"].parameters.rows[name]
    row.number.setValue(value)
    row.released.emit()


@pytest.fixture
def drawn(window, hand):
    """A window with a circle in the disc, whose area is shown."""
    local = replace(PRESETS["shape"], scales=1)
    window.session.edit("one scale", lambda document: replace(document, parameters=local))
    assert area(hand) is None
    hand.canvas.setFocus()
    hand.key(KEY.Key_C)
    hand.drag((32.0, 32.0), (32.0, 36.0), (32.0, 40.0))
    hand.wait(lambda: area(hand) is not None)
    hand.wait(lambda: window.session.idle)
    return window


def test_the_area_appears_with_a_start_and_is_that_of_the_engine(drawn, hand) -> None:
    session = drawn.session
    parameters = session.document.parameters
    engine = Engine(session.image, parameters)
    mask = engine.start_area(engine.start(session.document.collect_seeds()).start, parameters)
    assert np.array_equal(area(hand) > 0, mask)
    assert mask[32, 32] and not mask[4, 4]
    (entry,) = hand.canvas.layers["start_area"].legend_entries()
    assert (entry.count, entry.text) == (1, "area of the start")


def test_an_area_of_most_of_the_image_is_told_below_it(window, hand) -> None:
    window.session.edit("one scale", lambda document: replace(document, parameters=replace(PRESETS["shape"], scales=1)))
    hand.canvas.setFocus()
    hand.key(KEY.Key_C)
    hint = window.canvas_area.hint
    hand.drag((32.0, 32.0), (32.0, 36.0), (32.0, 40.0))
    hand.wait(lambda: area(hand) is not None and window.session.idle)
    assert "of the image" not in hint.text()
    hand.key(KEY.Key_Z, Qt.KeyboardModifier.ControlModifier)
    hand.drag((8.0, 8.0), (8.0, 10.0), (8.0, 12.0))
    hand.wait(lambda: "of the image" in hint.text())
    assert np.count_nonzero(area(hand)) == area(hand).size
    assert "its area is 100 % of the image" in hint.text()


def test_the_area_is_a_faint_tint_over_the_image(drawn, hand) -> None:
    dark, bright = (8.0, 8.0), (32.0, 26.0)
    shown = [hand.color_at(*place) for place in (dark, bright)]
    drawn.actions_by_name["layer_start_area"].trigger()
    hand.wait(lambda: area(hand) is None)
    plain = [hand.color_at(*place) for place in (dark, bright)]
    assert shown[0] == plain[0], "outside nothing changes"
    assert shown[1] != plain[1]
    assert max(abs(one - other) for one, other in zip(shown[1], plain[1], strict=True)) < 40
    drawn.actions_by_name["layer_start_area"].trigger()
    hand.wait(lambda: area(hand) is not None)


def test_the_area_follows_the_start_and_undo(drawn, hand) -> None:
    session, first = drawn.session, area(hand).copy()
    session.edit("move", lambda document: replace(document, shapes=(Circle((8.0, 8.0), 5.0),)))
    hand.wait(lambda: not np.array_equal(area(hand), first) if area(hand) is not None else session.idle)
    session.undo()
    hand.wait(lambda: area(hand) is not None and np.array_equal(area(hand), first))
    session.undo()
    hand.wait(lambda: area(hand) is None)
    assert session.document.shapes == ()


def test_at_the_right_end_of_reach_there_is_no_area_and_undo_brings_it_back(drawn, hand) -> None:
    first, row = area(hand).copy(), drawn.panels["run"].parameters.rows["reach"]
    row.slider.setFocus()
    hand.qtbot.keyClick(row.slider, KEY.Key_End)
    hand.wait(lambda: area(hand) is None)
    assert drawn.session.document.parameters.reach == UNLIMITED_REACH
    assert row.number.text() == "no limit"
    drawn.session.undo()
    hand.wait(lambda: area(hand) is not None)
    assert np.array_equal(area(hand), first)


def test_no_slider_of_the_motion_makes_the_area_or_a_field_again(drawn, hand, monkeypatch) -> None:
    session, shown = drawn.session, area(hand)
    session.set_pace(200.0)
    hand.key(KEY.Key_Space)
    hand.wait(lambda: session.status.step >= 3)
    hand.wait(lambda: area(hand) is not None)
    made = [
        counted(monkeypatch, local_fields, "find_start_area"),
        counted(monkeypatch, local_fields, "limit_field"),
        counted(monkeypatch, scale_space, "build_scale_field"),
    ]
    for name, value in (("beta", 0.6), ("ratio", 0.7), ("annealing", 0.95), ("reach", 20.0), ("beta", 1.2)):
        step = session.status.step
        set_value(drawn, name, value)
        steered = session.document.parameters.steering
        hand.wait(lambda step=step: session.status.step > step or session.status.phase == "finished")
        hand.wait(lambda steered=steered: session.status.steering == steered)
    assert made == [[]] * len(made)
    hand.wait_for_phase("finished")
    hand.wait(lambda: session.idle)
    assert np.array_equal(area(hand), shown)
