"""A person who tries everything: random gestures on the window, the same ones for the same seed.

A person who does not stop to think makes about one gesture a second: a stroke, a click on a button, a key, a choice
in a menu. So an hour is `PER_HOUR` gestures, however quickly they are made here.
"""

from __future__ import annotations

import logging
import random
import threading
import time
from collections import Counter, deque
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from cpm_app.model.preferences.table import TIMELINE_MEMORY
from cpm_app.session.worker.worker_thread import IDLE_BEFORE_RELEASE
from PySide6.QtCore import QEventLoop, QObject, QTimer
from PySide6.QtWidgets import QApplication, QWidget

from ..report import Budget, Report, going_on
from .gestures import Gesture, Hand
from .memory import Taken, quarters, still_rising, taken
from .program import IMAGES, await_true, destroyed, discarding, opened, ours, settled, surroundings
from .watch import Watch

log = logging.getLogger(__name__)

PER_HOUR = 3600
"""Gestures of a person in an hour."""

_DRAGS_AFTER = 1.0
"""Time after which an event that has not ended is taken for a drag with a loop of its own [s]."""

_REMEMBERED = 12
"""Number of gestures that are told with a failure."""


class Monkey(QObject):
    """Makes gestures on a window from timers, so that it goes on in dialogs, too."""

    def __init__(self, images: Path, seed: int, watch: Watch) -> None:
        super().__init__()
        self.made = self.events = 0
        self.last: deque[str] = deque(maxlen=_REMEMBERED)
        self.windows = 1
        self._images = images
        self._seed = seed
        self._watch = watch
        self._open: list[Gesture] = []
        self._goal = 0
        self._pause = 0.0
        self._sending: tuple[QWidget | None, float] | None = None
        self._may_go_on: Callable[[], bool] = lambda: True
        self._loop = QEventLoop(self)
        self._timer = QTimer(self, singleShot=True)
        self._timer.timeout.connect(self._go_on)
        self.window = opened(images / IMAGES[0])

    def make(self, count: int, may_go_on: Callable[[], bool] = lambda: True) -> None:
        """Make so many more gestures, as long as nothing goes wrong."""
        self._goal, self._may_go_on = self.made + count, may_go_on
        self._timer.start(0)
        self._loop.exec()

    def come_to_rest(self) -> None:
        """Answer every dialog with Escape, stop the run, and wait until nothing is going on."""
        self._open.clear()
        for _ in range(50):
            top = QApplication.activePopupWidget() or QApplication.activeModalWidget()
            if top is None:
                break
            top.close()
            QApplication.processEvents()
        self.window.session.pause()
        for task in self.window.session.tasks.current:
            task.cancel()
        await_true(lambda: self.window.session.idle, "coming to rest")

    def check(self) -> list[str]:
        """Come to rest for a moment, as a person does, and say what does not hold then."""
        self.come_to_rest()
        rested = time.monotonic() + 1.5 * IDLE_BEFORE_RELEASE
        await_true(lambda: time.monotonic() > rested, "resting")
        broken = list(self._watch.troubles)
        session = self.window.session
        before, done = session.document, 0
        while session.history.undo_name:
            session.undo()
            done += 1
        for _ in range(done):
            session.redo()
        if session.document != before:
            broken.append("to undo all and do it again gives another document")
        await_true(lambda: session.idle, "undoing all and doing it again")
        others = [top for top in QApplication.topLevelWidgets() if top.isVisible() and top.isModal()]
        if others:
            broken.append(f"left open: {[type(top).__name__ for top in others]}")
        counts = Counter(
            thread.name.rpartition("_")[0] or thread.name for thread in threading.enumerate() if ours(thread)
        )
        if max(counts.values()) > 1:
            broken.append(f"more threads than one of a kind: {counts}")
        return broken

    def store_little(self) -> None:
        """Let the runs keep few steps, so that what they may keep does not hide what else takes memory."""
        preferences = self.window.preferences
        preferences.store_preference(TIMELINE_MEMORY, TIMELINE_MEMORY.low)
        await_true(lambda: self.window.session.idle, "storing fewer steps")

    def tidy(self) -> None:
        """Close all other windows and open the first image again, so that only what is left behind takes more."""
        for top in QApplication.topLevelWidgets():
            if top.isVisible() and top is not self.window:
                top.close()
        with discarding():
            self.window.open_image(str(self._images / IMAGES[0]))
        QApplication.processEvents()
        await_true(lambda: settled(self.window), "opening the first image again")

    def close(self) -> None:
        """Close the window without saving."""
        self.come_to_rest()
        with discarding():
            self.window.close()
        destroyed(self.window)

    def _go_on(self) -> None:
        if self._sending is not None and not self._in_a_loop_of_its_own():
            self._timer.start(1)  # the event that is being sent lets other events pass
            return
        if self._watch.troubles or self.made >= self._goal or not self._may_go_on():
            if QApplication.activeModalWidget() is None and QApplication.activePopupWidget() is None:
                self._loop.quit()
                return
            self._open.clear()
            (QApplication.activePopupWidget() or QApplication.activeModalWidget()).close()  # type: ignore[union-attr]
            self._timer.start(0)
            return
        if not self.window.isVisible():
            destroyed(self.window)
            self.windows += 1
            self.window = opened(self._images / IMAGES[0])
            self._open.clear()
        if self._pause:
            milliseconds, self._pause = round(1000 * self._pause), 0.0
            self._timer.start(milliseconds)
            return
        gesture = self._open.pop() if self._open else self._next()
        # Before the event, which may open a dialog with a loop of its own.
        self._timer.start(0)
        before, self._sending = self._sending, (QApplication.activeModalWidget(), time.monotonic())
        pause = next(gesture, None)
        self._sending = before
        if pause is not None:
            self._open.append(gesture)
            self._pause = pause

    def _in_a_loop_of_its_own(self) -> bool:
        """Whether the event that is being sent has opened a dialog, or drags something."""
        assert self._sending is not None
        modal, since = self._sending
        return QApplication.activeModalWidget() is not modal or time.monotonic() - since > _DRAGS_AFTER

    def _next(self) -> Gesture:
        """The gesture of this number, which depends on the seed and on what is open."""
        choice = random.Random(f"{self._seed}:{self.made}")
        self.made += 1
        hand = Hand(self.window, choice, self._images, IMAGES)
        asked = QApplication.activePopupWidget() or QApplication.activeModalWidget()
        kinds = hand.repertoire
        kind = hand.answer if asked is not None else choice.choices(list(kinds), list(kinds.values()))[0]
        self.last.append(f"{self.made} {kind.__name__}")
        return self._counted(hand, kind())

    def _counted(self, hand: Hand, gesture: Gesture) -> Gesture:
        for pause in gesture:
            self.events += hand.events
            hand.events = 0
            yield pause
        self.events += hand.events


def play(
    budget: Budget, gestures: int | None = None, between: int = 200, checks: int = 5
) -> tuple[Report, list[Taken]]:
    """Make gestures until the time is over, or so many; check after every so many, and measure after some checks."""
    failures: list[str] = []
    measured: list[Taken] = []
    end = time.monotonic() + budget.seconds
    with surroundings(budget.folder) as images, Watch().kept() as watch:
        monkey = Monkey(images, budget.seed, watch)
        checked = 0
        while going_on(end) and (gestures is None or monkey.made < gestures):
            monkey.make(between, lambda: going_on(end))
            try:
                broken = monkey.check()
            except TimeoutError as error:
                broken = [str(error)]
            failures += [f"seed {budget.seed}, after {', '.join(monkey.last)}: {sentence}" for sentence in broken]
            watch.troubles.clear()
            checked += 1
            if checked % checks:
                continue
            monkey.store_little()
            monkey.tidy()
            measured.append(taken())
            mark = measured[-1]
            log.info("%d gestures: %.0f MiB, %d Qt objects", monkey.made, mark.resident, mark.qt_objects)
        monkey.close()
        failures += watch.troubles
    hours = monkey.made / PER_HOUR
    told = f"{monkey.made:,} gestures of {monkey.events:,} events, {hours:.1f} hours of a person"
    return Report(monkey.events, 0, tuple(failures), told=(told,)), measured


def try_gestures(budget: Budget) -> Report:
    """Make gestures until the time is over, and tell what memory was taken after each quarter."""
    report, measured = play(budget)
    marks = quarters(measured)
    quarter = "; ".join(f"{mark.resident:.0f} MiB and {mark.qt_objects} Qt objects" for mark in marks)
    return replace(
        report,
        failures=(*report.failures, *still_rising(marks)),
        told=(*report.told, f"in the four quarters {quarter}"),
    )
