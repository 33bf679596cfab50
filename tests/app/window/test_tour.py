"""The tour: five bubbles by buttons or keys, shown once to new users and again on request."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, QRect, Qt

from app.views.application import open_window
from app.views.features.help.help import SEEN, HelpFeature
from app.views.help.tour import Tour


@pytest.fixture
def tour(window, hand) -> Tour:
    window.actions_by_name["tour"].trigger()
    return window.feature(HelpFeature).tour


def place(widget, window) -> QRect:
    return QRect(widget.mapTo(window, QPoint(0, 0)), widget.size())


def test_the_bubble_points_at_each_of_five_and_covers_none_of_them(window, hand, tour) -> None:
    for number, stop in enumerate(tour._stops):
        assert tour.at == number
        target = stop.target()
        assert target.isVisible(), stop.title
        assert tour._ring.geometry().intersects(place(target, window))
        assert not tour.geometry().adjusted(14, 14, -14, -14).intersects(place(target, window)), stop.title
        assert window.rect().contains(tour.geometry())
        hand.qtbot.mouseClick(tour.next, Qt.MouseButton.LeftButton)
    assert number == 4
    assert window.feature(HelpFeature).tour is None


def test_no_text_of_a_bubble_is_cut_off(window, hand, tour) -> None:
    for number in range(5):
        tour.go(number)
        hand.qtbot.wait(1)
        for label in (tour._title, tour._text, tour._count):
            assert label.height() >= label.heightForWidth(label.width()), label.text()
            assert label.width() >= label.minimumSizeHint().width()


def test_the_tour_is_controlled_by_keys_and_starts_no_run(ready, hand) -> None:
    ready.actions_by_name["tour"].trigger()
    tour = ready.feature(HelpFeature).tour
    for key, at in ((Qt.Key.Key_Right, 1), (Qt.Key.Key_Return, 2), (Qt.Key.Key_Left, 1), (Qt.Key.Key_Space, 2)):
        hand.key(key)
        assert tour.at == at
    assert ready.session.status.phase == "ready"
    hand.key(Qt.Key.Key_Escape)
    assert ready.feature(HelpFeature).tour is None
    assert ready.preferences.get(SEEN, False)


def test_back_and_skip_do_what_they_say(window, hand, tour) -> None:
    assert not tour.back.isEnabled()
    hand.qtbot.mouseClick(tour.next, Qt.MouseButton.LeftButton)
    hand.qtbot.mouseClick(tour.back, Qt.MouseButton.LeftButton)
    assert tour.at == 0
    hand.qtbot.mouseClick(tour.skip, Qt.MouseButton.LeftButton)
    assert window.feature(HelpFeature).tour is None


def test_the_bubble_stays_with_its_target_when_the_window_is_resized(window, hand, tour) -> None:
    tour.go(4)
    window.resize(1300, 800)
    target = tour._stops[4].target()
    hand.wait(lambda: tour._ring.geometry().contains(place(target, window).center()))
    assert window.rect().contains(tour.geometry())


def test_the_window_stays_usable_during_the_tour(window, hand, tour) -> None:
    tour.go(1)
    hand.drag((40.0, 40.0), (46.0, 40.0))
    assert len(window.session.document.shapes) == 1


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
