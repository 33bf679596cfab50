"""Modes: each sets its preset and initialization in one undoable change, and Run uses its method."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cpm_app.model.document import edits
from cpm_app.model.document.document import ImageReference
from cpm_app.model.document.modes import switch_mode
from cpm_app.model.document.saving import from_session_file, to_session_file
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QToolButton

from cpm_core.formats import SKELETONS_WRITABLE, to_bytes
from cpm_core.image.region import Region
from cpm_core.objects.segmented.segmented_object import Click, SegmentedObject, SegmentedObjects
from cpm_core.parameters import PRESETS
from cpm_core.shapes import Barrier, Circle
from tests.app.exporting import asked, check, offered, order

pytestmark = pytest.mark.shared_window

IMAGE = ImageReference("disc.png", "disc.png", (64, 64), 180.0)
CIRCLE, BARRIER = Circle((32.0, 32.0), 10.0), Barrier(((1.0, 2.0), (3.0, 4.0)))


def test_modes_are_switched_with_mouse_and_keys_and_undone_in_one_step(ready, hand) -> None:
    session = ready.session
    before = session.document
    button = ready.findChild(QToolButton, "mode_automatic")
    hand.qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
    assert session.document == switch_mode(before, "automatic")
    assert button.isChecked()
    hand.qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
    assert button.isChecked()
    hand.key(Qt.Key.Key_F3, Qt.KeyboardModifier.ControlModifier)
    assert session.document.mode == "skeleton"
    session.undo()
    session.undo()
    assert session.document == before
    assert ready.actions_by_name["mode_shape"].isChecked()
    assert not button.isChecked()


def test_automatic_segmentation_needs_no_drawing(window, hand) -> None:
    hand.key(Qt.Key.Key_F2, Qt.KeyboardModifier.ControlModifier)
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: window.session.idle)
    assert len(window.session.status.contours) == 1


def test_a_skeleton_is_found_shown_followed_and_exported(window, hand, tmp_path, monkeypatch) -> None:
    session, layer = window.session, window.canvas_area.canvas.layers["skeleton"]
    hand.key(Qt.Key.Key_F3, Qt.KeyboardModifier.ControlModifier)
    assert not window.actions_by_name["export"].isEnabled()
    hand.key(Qt.Key.Key_Space)
    hand.wait(lambda: session.scene.skeleton is not None and session.idle)
    first = session.scene.skeleton
    assert (session.status.phase, session.status.method, session.status.step) == ("finished", "skeleton", 3)
    assert window.session.resolved.numbers[0][:2] == ("Branches", str(len(first.contours)))
    # The medial axis of a disc of radius 18 is its center.
    middle, radius = first.contours[0].points, first.radii[0]
    assert np.hypot(*(middle - 32.0).T).max() < 2.0
    assert radius.max() == pytest.approx(18.0, abs=1.0)
    assert layer.disks.count >= 1
    dialog = asked(hand.qtbot, window)
    kinds = {suffix for what, _, suffix in (key.partition(":") for key in offered(dialog)) if what == "skeleton"}
    assert kinds == set(SKELETONS_WRITABLE)
    check(hand.qtbot, dialog, "skeleton:.csv")
    (path,) = order(hand.qtbot, window, dialog, tmp_path)
    assert path.name.endswith("_skeleton.vertices.csv")
    assert path.read_bytes() == to_bytes(first, ".csv")
    window.activateWindow()
    hand.wait(window.isActiveWindow)
    hand.canvas.setFocus()
    session.edit("change of smoothing", lambda document: edits.set_parameter(document, "smoothing", 2.0))
    hand.wait(lambda: session.scene.skeleton is not first and session.idle)
    assert session.status.step == 6
    session.edit("sure edge", lambda document: edits.set_parameter(document, "sure_edge", 0.5))
    hand.wait(lambda: session.status.step == 9 and session.idle)
    hand.key(Qt.Key.Key_F1, Qt.KeyboardModifier.ControlModifier)
    assert session.scene.skeleton is not None
    hand.key(Qt.Key.Key_R)
    assert session.scene.skeleton is None
    assert (layer.branches.count, layer.disks.count) == (0, 0)


def test_particles_and_skeleton_replace_each_other_when_the_mode_changes(ready, hand) -> None:
    session = ready.session
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: session.idle)
    assert len(session.status.contours) == 1
    hand.key(Qt.Key.Key_F3, Qt.KeyboardModifier.ControlModifier)
    assert session.status.stale
    hand.key(Qt.Key.Key_Space)
    hand.wait(lambda: session.scene.skeleton is not None and session.idle)
    assert session.scene.contours == ()
    assert not session.status.stale
    hand.key(Qt.Key.Key_F1, Qt.KeyboardModifier.ControlModifier)
    assert session.status.stale
    hand.key(Qt.Key.Key_Space)
    hand.wait(lambda: session.status.phase == "finished" and session.idle)
    assert (session.status.method, len(session.status.contours)) == ("cpm", 1)


def test_a_mode_leaves_what_was_found_until_the_next_run(ready, hand) -> None:
    session, selection = ready.session, ready.workspace.object_selection
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: session.idle and selection.idle and selection.offer_is_known)
    found, offered, numbers = session.scene.reconstruction, selection.proposals, session.resolved.numbers
    assert found.result.contours and offered
    for mode in ("automatic", "skeleton", "published", "shape"):
        hand.qtbot.mouseClick(ready.findChild(QToolButton, f"mode_{mode}"), Qt.MouseButton.LeftButton)
        hand.qtbot.wait(50)
        hand.wait(lambda: session.idle and selection.idle)
        assert session.document.mode == mode
        assert session.scene.reconstruction is found
        assert session.resolved.numbers == numbers
        assert ("stays until Run" in ready.canvas_area.hint.text()) == (mode in ("skeleton", "published"))
        assert [each.selection for each in selection.proposals] == [each.selection for each in offered]
    hand.key(Qt.Key.Key_F3, Qt.KeyboardModifier.ControlModifier)
    hand.canvas.setFocus()
    hand.key(Qt.Key.Key_Space)
    hand.wait(lambda: session.scene.skeleton is not None and session.idle)
    hand.wait(lambda: not selection.proposals)


def find_skeleton(window, hand):
    """Find the skeleton by keys."""
    hand.key(Qt.Key.Key_F3, Qt.KeyboardModifier.ControlModifier)
    hand.key(Qt.Key.Key_Space)
    hand.wait(lambda: window.session.scene.skeleton is not None and window.session.idle)
    return window.session.scene.skeleton


def test_run_is_not_said_to_start_over_where_nothing_is_drawn_to_start_from(window, hand) -> None:
    hand.qtbot.mouseClick(window.findChild(QToolButton, "mode_automatic"), Qt.MouseButton.LeftButton)
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: "Enter accepts" in window.canvas_area.hint.text())
    found = window.canvas_area.hint.text()
    hand.qtbot.mouseClick(window.findChild(QToolButton, "mode_shape"), Qt.MouseButton.LeftButton)
    hand.wait(lambda: window.session.status.stale)
    assert window.canvas_area.hint.text() == found


def test_sliders_of_the_skeleton_act_without_a_new_run_and_are_undone(window, hand) -> None:
    rows = window.panels["run"].parameters.rows
    assert not rows["pruning"].isVisibleTo(window)
    first = find_skeleton(window, hand)
    for name in ("polarity", "max_width", "pruning"):
        assert rows[name].isVisibleTo(window.panels["run"].parameters)
    assert not any(rows[name].isVisibleTo(window.panels["run"].parameters) for name in ("beta", "ratio", "annealing"))
    assert (rows["polarity"].number.text(), rows["max_width"].number.text()) == ("auto", "auto")
    session = window.session
    rows["pruning"].slider.setFocus()
    hand.qtbot.keyClick(rows["pruning"].slider, Qt.Key.Key_PageUp)
    hand.wait(lambda: session.scene.skeleton is not first and session.idle)
    assert session.document.parameters.pruning > 1.0
    assert session.status.step == 4  # of boundary and axis nothing is found again
    hand.qtbot.keyClick(rows["polarity"].slider, Qt.Key.Key_Home)
    hand.wait(lambda: session.status.phase == "finished" and session.idle)
    assert (rows["polarity"].number.text(), session.document.parameters.polarity) == ("dark", -1.0)
    assert session.scene.skeleton is None  # the disc is light
    session.undo()
    hand.wait(lambda: session.scene.skeleton is not None and session.idle)
    session.undo()
    assert session.document.parameters == PRESETS["noisy"]


def test_closed_contours_have_a_skeleton_of_their_own_until_the_image_is_asked_for(ready, hand) -> None:
    session = ready.session
    assert not ready.actions_by_name["skeleton"].isEnabled()
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: session.idle)
    ready.actions_by_name["skeleton"].trigger()
    hand.wait(lambda: session.scene.skeleton is not None and session.idle)
    assert len(session.document.outlined.contours) == 1
    radius = session.scene.skeleton.radii[0].max()
    outline = np.array(session.document.outlines[0])
    middle = session.scene.skeleton.contours[0].points[0]
    assert radius == pytest.approx(np.hypot(*(outline - middle).T).min(), abs=0.1)
    ready.actions_by_name["image_skeleton"].trigger()
    hand.wait(lambda: session.scene.skeleton is not None and session.idle and not session.document.outlines)
    assert not ready.actions_by_name["image_skeleton"].isEnabled()
    session.undo()
    assert len(session.document.outlines) == 1


def test_objects_have_a_skeleton_of_their_own_that_follows_them(window, hand) -> None:
    session = window.session
    boundary = ((20.0, 10.0), (20.0, 54.0), (30.0, 54.0), (30.0, 10.0))
    item = SegmentedObject(1, (Click(((25.0, 30.0),)),), Region((boundary,)))
    with_it = SegmentedObjects((item,))
    session.edit("an object", lambda document: replace(document, objects=with_it))
    window.workspace.object_list.select_objects([1])
    window.actions_by_name["skeleton"].trigger()
    hand.wait(lambda: session.scene.skeleton is not None and session.idle)
    first = session.scene.skeleton
    assert np.concatenate(first.radii).max() == pytest.approx(5.0, abs=0.1)
    larger = replace(item, region=Region((tuple((row * 1.2, col) for row, col in boundary),)))
    session.edit("larger", lambda document: replace(document, objects=SegmentedObjects((larger,))))
    hand.wait(lambda: session.scene.skeleton not in (None, first) and session.idle)
    assert np.concatenate(session.scene.skeleton.radii).max() == pytest.approx(6.0, abs=0.1)
    assert (
        from_session_file(to_session_file(session.document, {}), IMAGE, PRESETS["noisy"]).outlined
        == session.document.outlined
    )
