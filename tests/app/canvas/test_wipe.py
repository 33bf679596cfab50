"""The wipe between two results."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, Qt

from app.views.features.view import ComparingFeature

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
SHIFT, CTRL = Qt.KeyboardModifier.ShiftModifier, Qt.KeyboardModifier.ControlModifier


@pytest.fixture
def rested(ready, hand):
    """A window with a finished run."""
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: ready.session.scene.contours.result is not None and ready.session.idle)
    return ready


@pytest.fixture
def feature(window) -> ComparingFeature:
    """The wipe of the window."""
    return window.feature(ComparingFeature)


def choose(window, kind: str) -> None:
    other = window.workspace.other_result
    other.choose(next(choice for choice in other.choices if choice.kind == kind))


def test_a_wipe_shows_the_image_alone_beside_the_result_at_the_same_place(rested, feature, hand) -> None:
    hand.key(KEY.Key_D, CTRL)
    mirror, wipe = feature.wipe.mirror, feature.wipe
    assert [name.text() for name in wipe.names] == ["Result", "Image alone"]
    assert mirror.layers.contours.counts == (0, 0)
    assert sum(hand.canvas.layers.contours.counts) > 0
    for act in (lambda: hand.canvas.zoom(2.0), lambda: hand.canvas.pan(30.0, 10.0)):
        act()
        assert mirror.view.viewRect().center().x() == pytest.approx(hand.canvas.view.viewRect().center().x(), abs=1e-6)
        assert mirror.magnification == pytest.approx(hand.canvas.magnification)
    hand.key(KEY.Key_D, CTRL)
    assert wipe.mirror is None
    assert not wipe.divider.isVisible()


def test_the_divider_is_dragged_and_moved_by_arrow_keys_and_esc_ends_the_wipe(rested, feature, hand, qtbot) -> None:
    hand.key(KEY.Key_D, CTRL)
    divider = feature.wipe.divider
    assert divider.hasFocus()
    start = divider.geometry().center()
    qtbot.mousePress(divider, Qt.MouseButton.LeftButton, pos=divider.rect().center())
    qtbot.mouseMove(divider, divider.rect().center() + QPoint(-100, 0))
    qtbot.mouseRelease(divider, Qt.MouseButton.LeftButton)
    # a test moves the pointer without a button
    feature.wipe.move_to(0.25)
    assert divider.geometry().center().x() < start.x()
    before = feature.wipe.share
    hand.key(KEY.Key_Right)
    assert feature.wipe.share == pytest.approx(before + 0.05, abs=0.01)
    hand.key(KEY.Key_Left, SHIFT)
    assert feature.wipe.share < before + 0.05
    hand.key(KEY.Key_End)
    assert feature.wipe.share == 1.0
    hand.key(KEY.Key_Escape)
    assert feature.wipe.mirror is None
    assert hand.canvas.hasFocus()


def test_a_kept_result_is_compared_with_a_later_one(rested, feature, hand) -> None:
    before = rested.session.scene.contours.items
    hand.key(KEY.Key_D, CTRL | SHIFT)
    rested.workspace.review.select(item.key for item in rested.workspace.review.items)
    rested.workspace.review.judge("rejected")
    choose(rested, "kept")
    assert sum(feature.wipe.mirror.layers.contours.counts) == len(before)
    assert sum(hand.canvas.layers.contours.counts) == 0


def test_branches_are_compared_with_particles_and_contours(rested, feature, hand) -> None:
    rested.workspace.navigation.go(rested.workspace.navigation.place[0], 5)
    hand.wait(lambda: rested.session.status.step == 5 and rested.session.idle)
    row = rested.panels["run"].parameters.rows["beta"]
    row.changed.emit("beta", 1.7)
    hand.key(KEY.Key_Period)
    hand.wait(lambda: len(rested.workspace.navigation.outline.branches) == 2 and rested.session.idle)
    choose(rested, "branch")
    hand.wait(lambda: rested.session.scene.compared is not None and feature.wipe.mirror.layers.particles.count > 0)
    hand.wait(lambda: rested.session.scene.compared.result is not None)
    branches = rested.workspace.navigation.outline.branches
    assert {name.text() for name in feature.wipe.names} == {branch.name for branch in branches}
    rested.workspace.navigation.comparison.compare(None)
    hand.wait(lambda: feature.wipe.mirror is None)


def test_layers_on_both_sides_follow_the_same_settings(rested, feature, hand) -> None:
    hand.key(KEY.Key_D, CTRL)
    layer, mirrored = hand.canvas.layers["image"], feature.wipe.mirror.layers["image"]
    layer.choose("gamma", 2.0)
    layer.set_opacity(0.5)
    assert (mirrored.number("gamma"), mirrored.opacity) == (2.0, 0.5)
