"""The tour: it goes on because the person has done the thing, stays in its place, and ends on a live button."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, QRect, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QMessageBox, QToolButton

from app.views.application import open_window
from app.views.export.dialog import ExportDialog
from app.views.features.help import SEEN, HelpFeature
from app.views.help.tour import Tour

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def tour(window, hand) -> Tour:
    window.activateWindow()
    hand.wait(window.isActiveWindow)
    window.actions_by_name["tour"].trigger()
    return window.feature(HelpFeature).tour


def place(widget, window) -> QRect:
    return QRect(widget.mapTo(window, QPoint(0, 0)), widget.size())


def test_the_bubble_and_its_button_stay_in_their_place_and_cover_no_target(window, hand, tour) -> None:
    bubble, button = tour.geometry(), place(tour.next, window)
    for number, stop in enumerate(tour._stops):
        tour.go(number)
        target = stop.target()
        assert target.isVisible(), stop.title
        assert tour.ring.geometry().intersects(place(target, window))
        assert not tour.geometry().intersects(place(target, window)), stop.title
        assert (tour.geometry(), place(tour.next, window)) == (bubble, button)
        assert window.rect().contains(bubble)
        assert not tour.geometry().intersects(place(window.canvas_area.strip, window)), "messages can be read"


def test_no_text_of_a_bubble_is_cut_off(window, hand, tour) -> None:
    for number in range(5):
        tour.go(number)
        hand.qtbot.wait(1)
        for label in (tour.title, tour.text):
            assert label.height() >= label.heightForWidth(label.width()), label.text()
            assert label.width() >= label.minimumSizeHint().width()


def test_the_tour_goes_on_because_the_things_are_done_and_ends_on_a_live_button(window, hand, tour) -> None:
    window.resize(1300, 800)
    hand.wait(lambda: window.findChild(QToolButton, "export").isVisible())
    tour.go(1)
    hand.canvas.setFocus()
    hand.key(Qt.Key.Key_W)
    hand.wait(lambda: window.workspace.object_selection.ready)
    hand.click(32.0, 32.0)
    hand.wait(lambda: bool(window.workspace.object_selection.proposals))
    hand.key(Qt.Key.Key_Return)
    hand.wait(lambda: len(window.session.document.objects.items) == 1)
    hand.qtbot.wait(300)
    assert not tour._done(), "the name is being asked for"
    hand.key(Qt.Key.Key_Return)
    hand.wait(lambda: tour.at == 2)
    hand.key(Qt.Key.Key_C)
    hand.drag((32.0, 32.0), (32.0, 37.0), (32.0, 42.0))
    hand.key(Qt.Key.Key_Space)
    hand.wait(lambda: tour.at == 3)
    hand.key(Qt.Key.Key_Q)
    hand.key(Qt.Key.Key_Right)
    hand.wait(lambda: tour.at == 4)
    button = tour._stops[4].target()
    assert button.objectName() == "export"
    hand.wait(button.isEnabled)
    hand.qtbot.mouseClick(button, LEFT)
    hand.wait(lambda: window.feature(HelpFeature).tour is None)
    window.findChild(ExportDialog).reject()


def test_next_is_the_other_way_and_runs_the_program_for_the_last_stop(ready, hand) -> None:
    ready.resize(1300, 800)
    hand.wait(lambda: ready.findChild(QToolButton, "export").isVisible())
    ready.actions_by_name["tour"].trigger()
    tour = ready.feature(HelpFeature).tour
    for at in range(4):
        assert tour.at == at
        hand.qtbot.mouseClick(tour.next, LEFT)
    hand.wait(tour._stops[4].target().isEnabled)
    hand.qtbot.mouseClick(tour.next, LEFT)
    assert ready.feature(HelpFeature).tour is None
    assert ready.preferences.get(SEEN, False)


def test_space_in_the_bubble_runs_as_it_says(ready, hand) -> None:
    ready.activateWindow()
    hand.wait(ready.isActiveWindow)
    ready.actions_by_name["tour"].trigger()
    tour = ready.feature(HelpFeature).tour
    tour.go(2)
    assert tour.next.hasFocus()
    hand.key(Qt.Key.Key_Space)
    hand.wait(lambda: ready.session.status.started)
    hand.wait(lambda: tour.at == 3)
    tour.end()


def test_the_tour_is_controlled_by_keys(window, hand, tour) -> None:
    hand.key(Qt.Key.Key_Return)
    assert tour.at == 1
    hand.key(Qt.Key.Key_Escape)
    assert window.feature(HelpFeature).tour is None


def test_back_and_skip_do_what_they_say(window, hand, tour) -> None:
    assert not tour.back.isEnabled()
    hand.qtbot.mouseClick(tour.next, LEFT)
    hand.qtbot.mouseClick(tour.back, LEFT)
    assert tour.at == 0
    hand.qtbot.mouseClick(tour.skip, LEFT)
    assert window.feature(HelpFeature).tour is None


def test_a_double_click_on_the_last_button_does_not_draw_on_the_image(window, hand, tour) -> None:
    tour.go(4)
    at = place(tour.next, window).center()
    hand.qtbot.mouseClick(tour.next, LEFT)
    QTest.mouseDClick(window.windowHandle(), LEFT, pos=at)
    assert window.session.document.shapes == ()
    assert hand.canvas.hold.dragging is False


def test_ring_and_bubble_follow_the_window(window, hand, tour) -> None:
    tour.go(4)
    window.resize(1300, 800)
    target = tour._stops[4].target()
    hand.wait(lambda: tour.ring.geometry().contains(place(target, window).center()))
    hand.wait(lambda: place(window.canvas_area, window).contains(tour.geometry()))


def test_the_tour_is_shown_once_and_only_when_a_user_starts_the_program(qtbot, compiled_loops, image_file) -> None:
    for seen_before in (False, True):
        window = open_window(str(image_file))
        qtbot.waitUntil(lambda window=window: window.session.document.image is not None)
        feature = window.feature(HelpFeature)
        assert feature.tour is None
        feature.welcome()
        assert (feature.tour is None) == seen_before
        if feature.tour is not None:
            feature.tour.end()
        window.close()
        window.deleteLater()


def test_the_tour_waits_until_a_dialog_is_answered(window, hand) -> None:
    box = QMessageBox(window)
    box.open()
    hand.wait(box.isVisible)
    feature = window.feature(HelpFeature)
    feature.welcome()
    assert feature.tour is None
    box.close()
    hand.wait(lambda: feature.tour is not None)
    feature.tour.end()


def test_the_first_image_that_the_program_opens_is_not_taken_for_one_of_the_person(qtbot, compiled_loops) -> None:
    window = open_window()
    feature = window.feature(HelpFeature)
    feature.welcome()
    qtbot.waitUntil(lambda: window.session.document.image is not None)
    assert not feature.tour._done()
    assert not feature.tour._done()
    feature.tour.end()
    window.close()
    window.deleteLater()
