"""The line below the image: messages, hints and the legend."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFrame, QLabel

from cpm_core.contours.contour import Contour
from tests.app.conftest import show_contours
from tests.app.reading import contour_counts

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
LONG = "Something is wrong with this file, " * 12 + "so nothing was written."


@pytest.fixture
def rested(ready, hand):
    """A window with a finished run."""
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: ready.session.scene.result is not None and ready.session.idle)
    ready.canvas_area.strip.legend.update_now()
    return ready


def test_a_message_neither_covers_nor_moves_the_image(ready) -> None:
    area = ready.canvas_area
    place, seen = area.canvas.geometry(), area.canvas.view.viewRect()
    for text, error in (("By the way.", False), (LONG, True), ("", False)):
        ready.session.messages.show(text, error)
        assert area.canvas.geometry() == place
        assert area.canvas.view.viewRect() == seen
        assert not area.canvas.geometry().intersects(area.strip.geometry())
        assert area.strip.height() < 2 * area.fontMetrics().height()


def test_a_long_message_has_one_line_and_details(ready, qtbot) -> None:
    messages = ready.canvas_area.messages
    ready.session.messages.show("Short.", True)
    assert not messages.details.isVisible()
    ready.session.messages.show(LONG, True)
    qtbot.waitUntil(messages.details.isVisible)
    qtbot.mouseClick(messages.details, Qt.MouseButton.LeftButton)
    popups = [frame for frame in ready.findChildren(QFrame) if frame.windowType() == Qt.WindowType.Popup]
    (popup,) = [frame for frame in popups if frame.isVisible()]
    assert [label.text() for label in popup.findChildren(QLabel)] == [LONG]
    popup.close()


@pytest.mark.own_window
def test_the_legend_names_and_counts_what_is_there_and_nothing_else(rested) -> None:
    layers, legend = rested.canvas_area.canvas.layers, rested.canvas_area.strip.legend
    offered = rested.session.scene.objects.proposals
    rested.canvas_area.strip.legend.update_now()
    shown = (("contours", sum(contour_counts(layers.contours))), ("proposals", len(offered)), ("area of the start", 1))
    assert {entry.text: entry.count for entry in legend.entries} == {text: count for text, count in shown if count}
    for name in ("contours", "objects", "start_area"):
        layers[name].set_shown(False)
    legend.update_now()
    assert legend.entries == ()
    assert legend.isHidden()


def test_the_legend_drops_its_words_where_there_is_no_room_and_can_be_folded(rested, hand, qtbot) -> None:
    strip = rested.canvas_area.strip
    legend = strip.legend
    hand.wait(lambda: rested.workspace.object_selection.idle)
    legend.update_now()
    strip.setFixedWidth(2000)
    qtbot.waitUntil(lambda: strip.width() == 2000)
    whole = legend.sizeHint().width()
    strip.setFixedWidth(100)
    qtbot.waitUntil(lambda: legend.sizeHint().width() < whole)
    strip.setFixedWidth(2000)
    qtbot.waitUntil(lambda: legend.sizeHint().width() == whole)
    hand.key(KEY.Key_L, Qt.KeyboardModifier.AltModifier)
    assert not legend.button.isChecked()
    assert rested.preferences.read_key("legend/folded", False)
    hand.key(KEY.Key_L, Qt.KeyboardModifier.AltModifier)
    assert legend.button.isChecked()


def test_particles_lead_during_a_run_and_recede_after_it(rested) -> None:
    particles = rested.canvas_area.canvas.layers.particles
    assert particles.diameter_factor(rested.session.scene.snapshot) < 1.0
    rested.session.reset()
    assert particles.diameter_factor(rested.session.scene.snapshot) == 1.0


def test_short_open_contours_recede_and_closed_ones_do_not(rested) -> None:
    layer, points = rested.canvas_area.canvas.layers.contours, rested.session.scene.contours[0].points[:3]
    for closed in (False, True):
        show_contours(rested, Contour(points, closed))
        assert layer.short.count == (not closed)
