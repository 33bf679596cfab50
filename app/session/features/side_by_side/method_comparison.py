"""The comparison of methods: up to four of them run on the same image from the same start, each on its own thread."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from PySide6.QtCore import QObject, QTimer, Signal

from app.model.text.language import tr
from app.session.exchange.error_messages import sentence
from app.session.exchange.mailbox import Mailbox
from app.session.exchange.messages import Report
from app.session.session import Session
from app.session.tasks.tasks import Task
from cpm_core.contours.contour import Contour
from cpm_core.contours.ground_truth import Truth
from cpm_core.formats.animations.comparison import Tile, write_comparison
from cpm_core.image.image import Image
from cpm_core.numerics.types import Array
from cpm_core.segmentation.methods import CONTOUR_METHODS, Facts, Moment, Start, facts_of, moments
from cpm_core.shapes.outlines import outlines_of

PLACES = 4
"""How many methods stand side by side."""

_FRAME = 33
"""Time between two looks at what the runs have done [ms]."""

_SHOWN_EVERY = 0.04
"""Least time between two states of a run that are handed to the window [s]."""


@dataclass(frozen=True, eq=False, slots=True)
class Frame:
    """What is shown of a run: lines and particles at a step, with the facts; `trouble` is why it failed."""

    method: str
    contours: tuple[Contour, ...] = ()
    points: Array = field(default_factory=lambda: np.empty((0, 2)))
    facts: Facts | None = None
    over: bool = False
    trouble: str = ""


@dataclass(frozen=True, slots=True)
class ComparisonWritten(Report):
    """Table and picture of a comparison have been written."""

    files: tuple[Path, ...]


class _Run:
    """One method on its own thread; the newest frame waits in a mailbox."""

    def __init__(self, method: str, image: Image, start: Start, settings: Any, truth: Truth | None) -> None:
        self.frames: Mailbox[Frame] = Mailbox()
        self._stop = threading.Event()
        self._work = method, image, start, settings, truth
        self.thread = threading.Thread(target=self._run, name=f"cpm-compare-{method}", daemon=True)
        self.thread.start()

    def stop(self) -> None:
        """End after the present step."""
        self._stop.set()

    def _run(self) -> None:
        method = self._work[0]
        try:
            for frame in self._shown():
                self.frames.put(frame)
        except Exception as error:  # an error is shown in its place, and the others go on
            title = CONTOUR_METHODS[method].title
            self.frames.put(Frame(method, over=True, trouble=sentence(error, tr("running {name}").format(name=title))))

    def _shown(self) -> Iterator[Frame]:
        method, image, start, settings, truth = self._work
        due = 0.0
        for moment in moments(CONTOUR_METHODS[method], image, start, settings):
            if self._stop.is_set():
                return
            over = bool(moment.state.stop_reason)
            if over or time.perf_counter() >= due:
                yield _frame(moment, truth if over else None, over)
                due = time.perf_counter() + _SHOWN_EVERY


def _frame(moment: Moment, truth: Truth | None, over: bool) -> Frame:
    """What is shown of a moment: of particles that move only the particles, whose contours take longer to find."""
    state, points = moment.state, moment.state.points
    if len(points) and not over:
        facts = Facts(moment.method.name, state.step, moment.seconds, False, "", 0)
        return Frame(moment.method.name, (), points, facts)
    return Frame(moment.method.name, state.contours, points, facts_of(moment, truth), over)


class MethodComparison(QObject):
    """Runs methods in up to `PLACES` places, from the drawn circles, ellipses and polygons."""

    advanced = Signal(int)
    """The frame of this place has been replaced."""
    changed = Signal()
    """Runs have begun, ended or been cancelled."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self.frames: list[Frame | None] = [None] * PLACES
        self.around = False
        self._session = session
        self._runs: list[_Run | None] = [None] * PLACES
        self._ending: list[_Run] = []
        self._timer = QTimer(self)
        self._timer.setInterval(_FRAME)
        self._timer.timeout.connect(self._look)
        session.image_changed.connect(self.cancel)

    @property
    def running(self) -> bool:
        """Whether a method is running."""
        return any(run is not None for run in self._runs)

    def start_of(self) -> Start:
        """The start that is drawn; ValueError when there is none with an inside."""
        return Start(outlines_of(self._session.document.shapes), self.around)

    def run(self, place: int, method: str, settings: Any) -> None:
        """Run a method in a place from the beginning; ValueError when there is no start."""
        image, start = self._session.image, self.start_of()
        if image is None:
            return
        self._end(place)
        channel = self._session.document.parameters.channel
        taken = image if image.colors is None or method == "cpm" else Image(image.gray(channel), source=image.source)
        self.frames[place] = None
        self._runs[place] = _Run(method, taken, start, settings, self._session.scene.truth)
        self._timer.start()
        self.advanced.emit(place)
        self.changed.emit()

    def clear(self, place: int) -> None:
        """Run nothing in a place."""
        self._end(place)
        self.frames[place] = None
        self.advanced.emit(place)
        self.changed.emit()

    def cancel(self) -> None:
        """End all runs; what they have found so far stays."""
        for place in range(PLACES):
            self._end(place)
        self.changed.emit()

    def write(self, paths: tuple[Path, ...]) -> None:
        """Write table and picture of what has been found, on a thread of its own."""
        image, start = self._session.image, self.start_of()
        tiles = [Tile(frame.contours, frame.facts) for frame in self.frames if frame and frame.over and frame.facts]
        if image is None or not tiles:
            return

        def work(task: Task) -> Report:
            task.go_on()
            write_comparison(image, start, tiles, paths)
            return ComparisonWritten(paths)

        self._session.tasks.start(tr("Writing the comparison…"), work, tr("writing the comparison"), cancellable=False)

    def close(self) -> None:
        """End all runs and wait for their threads."""
        self._timer.stop()
        for run in [*self._runs, *self._ending]:
            if run is not None:
                run.stop()
        for run in [*self._runs, *self._ending]:
            if run is not None:
                run.thread.join()

    def _end(self, place: int) -> None:
        run = self._runs[place]
        if run is not None:
            run.stop()
            self._ending.append(run)
            self._runs[place] = None

    def _look(self) -> None:
        self._ending = [run for run in self._ending if run.thread.is_alive()]
        ended = False
        for place, run in enumerate(self._runs):
            frame = run.frames.take() if run is not None else None
            if frame is not None:
                self.frames[place] = frame
                if frame.over:
                    self._end(place)
                    ended = True
                self.advanced.emit(place)
        if ended:
            self.changed.emit()
        if not self.running and not self._ending:
            self._timer.stop()
