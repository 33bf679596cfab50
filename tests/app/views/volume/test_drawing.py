"""Boxes, lines, limits and charges are drawn, held and dragged in every slice, by mouse and keys."""

from __future__ import annotations

import numpy as np
import pytest
from cpm_app.views.features.files import OpenSaveFeature
from cpm_app.views.features.volumes import SlicesFeature
from cpm_app.views.window.bars import ToolPalette
from PySide6.QtCore import Qt

from cpm_core.shapes import Box, BoxRegion, Charge, Polygon, PrismRegion, Stroke, Wall
from tests.app.views.volume.conftest import SHAPE, drag, move, press, release

pytestmark = pytest.mark.shared_window

KEY, CONTROL = Qt.Key, Qt.KeyboardModifier.ControlModifier
PIXEL = 0.6


def views(window):
    """The three views of a slice: the large one, and those beside it."""
    return (window.canvas_area.canvas, *window.get_feature(SlicesFeature).sides)


def only(window, kind):
    (shape,) = window.session.document.shapes
    assert isinstance(shape, kind)
    return shape


def flat(view, place) -> np.ndarray:
    return np.array(view.shown_slice.drop_axis(tuple(place)))


def test_a_drag_draws_a_box_whose_faces_are_dragged_in_any_slice(volume, hand, cases) -> None:
    for view in cases(views(volume)):
        hand.key(KEY.Key_L)
        drag(view, (6, 8), (7, 9), (12, 18))
        box, axis = only(volume, Box), view.shown_slice.axis
        assert flat(view, box.first) == pytest.approx((6, 8), abs=PIXEL)
        assert flat(view, box.last) == pytest.approx((12, 18), abs=PIXEL)
        depth = box.last[axis] - box.first[axis]
        assert depth == pytest.approx(min(np.ptp([flat(view, box.first), flat(view, box.last)], axis=0)), abs=1e-6)
        assert 0.5 * (box.first[axis] + box.last[axis]) == view.shown_slice.index
        assert volume.session.selected_shape == 0
        drag(view, (12, 13), (13, 13), (15, 13))
        grown = only(volume, Box)
        assert grown.first == box.first
        assert flat(view, grown.last) == pytest.approx((15, 18), abs=2 * PIXEL)
        hand.key(KEY.Key_Z, CONTROL)
        hand.key(KEY.Key_Z, CONTROL)
        assert volume.session.document.shapes == ()


def test_every_slice_takes_the_tool_in_use_and_shows_its_draft(volume, hand, cases) -> None:
    for view in cases(views(volume)):
        hand.key(KEY.Key_T)
        press(view, (5, 6))
        release(view, (5, 6))
        press(view, (9, 15))
        release(view, (9, 15))
        move(view, (12, 20), Qt.MouseButton.NoButton)
        x, y = view.layers.drawing._draft.path.getData()
        np.testing.assert_allclose(np.stack([y, x], axis=1), [(5, 6), (9, 15), (12, 20)], atol=PIXEL + 0.5)
        hand.key(KEY.Key_Return)
        stroke, here = only(volume, Stroke), view.shown_slice
        assert [place[here.axis] for place in stroke.points] == [here.index] * 2
        (line,) = view.drawn_scene.document.shapes
        assert np.array(line.points) == pytest.approx(np.array([(5, 6), (9, 15)]), abs=PIXEL)


def test_each_drawing_tool_makes_its_shape_in_a_slice(volume, hand) -> None:
    for key, kind in ((KEY.Key_O, Polygon), (KEY.Key_B, Wall), (KEY.Key_I, PrismRegion)):
        hand.key(key)
        for place in ((6, 6), (6, 20), (18, 20)):
            hand.click(*place)
        hand.key(KEY.Key_Return)
        shape = only(volume, kind)
        assert len(shape.points) == 3
        if kind is not Polygon:
            assert (shape.axis, shape.first, shape.last) == (0, 0, SHAPE[0] - 1)
        hand.key(KEY.Key_Delete)
        assert volume.session.document.shapes == ()


def test_a_drag_with_the_tool_for_regions_is_a_box_that_dims_what_is_outside(volume, hand) -> None:
    hand.key(KEY.Key_I)
    hand.drag((8, 8), (9, 9), (20, 22))
    region = only(volume, BoxRegion)
    assert "a sphere, a box" in volume.canvas_area.hint.text()
    assert region.first[1:] == pytest.approx((8, 8), abs=PIXEL)
    canvas = volume.canvas_area.canvas
    veil = canvas.layers.drawing._dim._veil
    assert not veil.isEmpty()
    volume.workspace.slices.go_to(0)
    outside = canvas.layers.drawing._dim._veil
    assert outside.boundingRect().contains(veil.boundingRect())
    assert outside.contains(canvas.layers.drawing._dim._room.center()), "nothing of this slice lies in it"


def test_charges_are_placed_moved_and_changed_in_every_slice(volume, hand, cases) -> None:
    for view in cases(views(volume)):
        hand.key(KEY.Key_D)
        drag(view, (10, 12), (11, 13))
        charge = only(volume, Charge)
        assert charge.strength < 0
        assert flat(view, charge.position) == pytest.approx((11, 13), abs=PIXEL)
        drag(view, (11, 13), (12, 14), (15, 16))
        moved = only(volume, Charge)
        assert flat(view, moved.position) == pytest.approx((15, 16), abs=2 * PIXEL)
        hand.key(KEY.Key_BracketRight)
        assert only(volume, Charge).strength < moved.strength


def test_the_eraser_takes_away_particles_in_a_ball_and_no_others(volume, hand) -> None:
    hand.drag((14, 16), (14, 18), (14, 20))
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: volume.session.idle)
    before = volume.session.scene.snapshot.position
    hand.key(KEY.Key_E)
    radius = volume.canvas_area.canvas.dispatcher.tool.radius
    hand.click(7, 16)
    hand.wait(lambda: volume.session.idle and len(volume.session.scene.snapshot.position) < len(before))
    after = volume.session.scene.snapshot.position
    near = np.linalg.norm(before - (12, 7, 16), axis=1) <= radius
    left = {tuple(place) for place in np.round(after, 6).tolist()}
    kept = [tuple(place) in left for place in np.round(before, 6).tolist()]
    assert near.any()
    sure = np.abs(np.linalg.norm(before - (12, 7, 16), axis=1) - radius) > 1.0  # the pointer is between two pixels
    np.testing.assert_array_equal(np.array(kept)[sure], ~near[sure])


def test_limits_and_charges_act_on_the_run_and_come_back_with_the_session(volume, hand, tmp_path) -> None:
    hand.key(KEY.Key_B)
    hand.drag((0, 16), (5, 16), (27, 16))
    hand.key(KEY.Key_C)
    hand.drag((14, 11), (14, 12), (14, 14))
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: volume.session.idle)
    found = volume.session.scene.snapshot.position
    assert len(found) > 50
    assert (found[:, 2] < 16).all(), "no particle crosses the barrier"
    path = tmp_path / "work.cpm"
    volume.get_feature(OpenSaveFeature).document_file.save_and_wait(path)
    document = volume.session.document
    volume.session.edit("clear", lambda known: type(known)(known.image))
    volume.open_image(str(path))
    hand.wait(lambda: volume.session.document.shapes == document.shapes and volume.session.idle)
    hand.wait(lambda: volume.session.scene.snapshot is not None)
    np.testing.assert_array_equal(volume.session.scene.snapshot.position, found)


def test_the_palette_names_tools_as_they_are_called_in_volumes(volume) -> None:
    buttons = volume.findChild(ToolPalette).buttons
    assert all(button.isVisible() for button in buttons.values())
    assert [action.text() for action in buttons["Mend"].menu().actions() if action.isVisible()] == [
        "&Brush",
        "Spli&t",
    ]
    assert (buttons["Mend"].text(), buttons["Circle"].text()) == ("Brush", "Sphere")
