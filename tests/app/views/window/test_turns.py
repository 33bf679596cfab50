"""Work in pieces is done in order, and the window answers between two of them."""

from __future__ import annotations

from cpm_app.views.canvas.side_view import SideView
from cpm_app.views.features.volumes import SlicesFeature
from cpm_app.views.widgets.turns import Turns
from PySide6.QtCore import QObject, QTimer

from tests.app.views.volume.conftest import open_file, volume_file  # noqa: F401  # a fixture


class Beat(QObject):
    """Counts the turns of the event loop."""

    def __init__(self) -> None:
        super().__init__()
        self.count = 0
        self._timer = QTimer(self, interval=0)
        self._timer.timeout.connect(self._beat)
        self._timer.start()

    def _beat(self) -> None:
        self.count += 1


def test_each_piece_has_a_turn_of_its_own_and_its_place_in_the_order(qtbot) -> None:
    beat, parent, done = Beat(), QObject(), []
    turns = Turns(parent)

    def first() -> None:
        done.append(("first", beat.count))
        turns.schedule_work(last)

    def second() -> None:
        done.append(("second", beat.count))

    def last() -> None:
        done.append(("last", beat.count))

    for piece in (first, second, first):
        turns.schedule_work(piece)
    assert not done
    qtbot.waitUntil(lambda: turns.is_idle)
    assert [name for name, _ in done] == ["first", "second", "last"]
    assert len({turn for _, turn in done}) == 3


def test_what_waits_is_forgotten_when_it_is_stopped(qtbot) -> None:
    parent, done = QObject(), []
    turns = Turns(parent)
    turns.schedule_work(lambda: done.append(1))
    turns.stop()
    qtbot.wait(5)
    assert turns.is_idle
    assert not done


def test_the_views_of_a_volume_are_made_one_in_a_turn(window, hand, volume_file, monkeypatch) -> None:  # noqa: F811
    beat, made, shown, plain = Beat(), [], [], SideView.__init__

    def make(view: SideView, *args: object) -> None:
        made.append(beat.count)
        plain(view, *args)

    monkeypatch.setattr(SideView, "__init__", make)
    window.session.image_changed.connect(lambda: shown.append(beat.count))
    open_file(window, hand, volume_file)
    assert len({*shown, *made}) == 3
    assert all(view.isVisible() for view in window.get_feature(SlicesFeature).sides)
    assert window.panels["space"].view.isVisible()
