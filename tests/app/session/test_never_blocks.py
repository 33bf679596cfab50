"""The window's thread never keeps the event loop waiting for more than 50 ms, whatever is being done.

Measured is the time that this thread itself computes between two returns to the event loop, not what other threads,
processes or tests take of the computer meanwhile: the measure does not depend on how busy that is. Waiting for a disk
is no computing; therefore it is watched as well that this thread never writes anything through.
"""

from __future__ import annotations

import gc
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from types import FrameType

import numpy as np
import pytest
from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import QDockWidget

from app.model.document import edits
from app.session.session import Session
from app.views.application import make_application
from app.views.canvas.layers.layer import Layer
from app.views.features.file.open_save import OpenSaveFeature
from app.views.main_window import MainWindow
from cpm_core import Parameters, uniform_grid
from cpm_core.shapes import Circle, Points

LONGEST = 0.050
"""Longest that the window's thread may compute between two returns to its loop [s]."""

DEEPEST = 6
"""Calls that are told of what blocks."""

TRIES = 3
"""Times that something may be tried."""

SIDE, SPACING = 2048, 14.0
PATIENCE = 120_000


class Watch:
    """Beats whenever the event loop comes round, and looks from outside at what the thread does in between."""

    def __init__(self) -> None:
        self.longest = 0.0
        self.activity = ""
        self._at = time.thread_time()
        self._thread = threading.get_ident()
        self._clock = time.pthread_getcpuclockid(self._thread) if hasattr(time, "pthread_getcpuclockid") else None
        self._over = threading.Event()
        self._seen = ""
        self._timer = QTimer()
        self._timer.setTimerType(Qt.TimerType.PreciseTimer)
        self._timer.timeout.connect(self.beat)
        self._looker = threading.Thread(target=self._look)

    def __enter__(self) -> Watch:
        self._at = time.thread_time()
        self._timer.start(1)
        self._looker.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.beat()
        self._timer.stop()
        self._over.set()
        self._looker.join()

    def beat(self) -> None:
        """The loop has come round."""
        now = time.thread_time()
        if now - self._at > self.longest:
            self.longest, self.activity = now - self._at, self._seen
        self._at, self._seen = time.thread_time(), ""

    def _look(self) -> None:
        while self._clock is not None and not self._over.wait(0.004):
            if time.clock_gettime(self._clock) - self._at > 0.6 * LONGEST:
                self._seen = self._seen or places(sys._current_frames().get(self._thread))


def places(frame: FrameType | None) -> str:
    """Where a thread is, without the lines themselves: to read them takes longer than what is looked at may."""
    said: list[str] = []
    while frame is not None and len(said) < DEEPEST:
        code = frame.f_code
        said.append(f'  File "{code.co_filename}", line {frame.f_lineno}, in {code.co_name}')
        frame = frame.f_back
    return "\n".join(reversed(said))


def free(what: str, do: Callable[[], object]) -> None:
    """Fail when the loop is kept waiting by something.

    A caches' worth of bad luck makes even computing take longer now and then; what blocks does so each time.
    """
    watches = []
    while len(watches) < TRIES and (not watches or watches[-1].longest > LONGEST):
        with Watch() as watch:
            do()
        watches.append(watch)
    best = min(watches, key=lambda watch: watch.longest)
    assert best.longest <= LONGEST, f"{what} kept the loop waiting for {1e3 * best.longest:.0f} ms:\n{best.activity}"


@pytest.fixture(autouse=True)
def nothing_is_written_through_by_the_window(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    threads: list[bool] = []
    whole = os.fsync
    here = threading.current_thread()

    def fsync(file: int) -> None:
        threads.append(threading.current_thread() is here)
        whole(file)

    monkeypatch.setattr(os, "fsync", fsync)
    yield
    assert not any(threads)


@pytest.fixture
def image_file(tmp_path: Path) -> Path:
    """A large image with discs."""
    row, col = np.indices((SIDE, SIDE), dtype=np.float32) % 128
    values = np.where(np.hypot(row - 64, col - 64) < 40, 200.0, 30.0) + np.arange(SIDE) / 64
    path = tmp_path / "large.npy"
    np.save(path, values)
    return path


@pytest.fixture
def window(qtbot, session: Session) -> Iterator[MainWindow]:
    """A window without an image, as warm as after the start."""
    make_application()
    made = MainWindow(session)
    made.resize(1280, 800)
    made.show()
    qtbot.waitExposed(made)
    session.warm_up()
    qtbot.waitUntil(lambda: session.idle, timeout=PATIENCE)
    gc.collect()
    gc.freeze()
    yield made
    made.close()
    made.deleteLater()
    gc.unfreeze()


@pytest.fixture
def large(window: MainWindow, qtbot, image_file: Path) -> MainWindow:
    """The window with a large image and 20,000 particles drawn on it."""
    session = window.session

    def open_it() -> None:
        session.open(image_file)
        qtbot.wait(20)
        qtbot.waitUntil(lambda: session.idle, timeout=PATIENCE)
        qtbot.wait(100)

    free("opening a large image", open_it)
    points = Points(tuple((row, col) for row, col in uniform_grid((SIDE, SIDE), SPACING).tolist()))
    assert len(points.positions) > 20_000

    def draw() -> None:
        session.edit("draw", lambda document: replace(document, shapes=(points,)))
        qtbot.wait(50)

    free("drawing 20,000 points", draw)
    session.edit("one scale", lambda document: edits.set_parameters(document, Parameters(scales=1, d_max=0.0)))
    return window


def test_the_watch_sees_what_blocks(qtbot) -> None:
    def block() -> None:
        end = time.thread_time() + 3.0 * LONGEST
        while time.thread_time() < end:
            pass

    qtbot.wait(50)  # whatever an application does first is not what is to be seen
    with Watch() as watch:
        QTimer.singleShot(10, block)
        qtbot.wait(300)
    assert watch.longest > LONGEST
    if hasattr(time, "pthread_getcpuclockid"):
        assert "in block" in watch.activity


def test_nothing_blocks_the_window_while_it_runs(large: MainWindow, hand, qtbot) -> None:
    session, canvas = large.session, hand.canvas

    def run() -> None:
        before = session.status.step
        session.run()
        qtbot.waitUntil(lambda: session.status.step >= before + 3, timeout=PATIENCE)

    def steer() -> None:
        for name in ("beta", "ratio"):
            slider = large.panels["parameters"].rows[name].slider
            for key in (Qt.Key.Key_Right, Qt.Key.Key_Right, Qt.Key.Key_Left):
                qtbot.keyClick(slider, key)
                qtbot.wait(20)

    def zoom() -> None:
        for factor in (1.5, 1.5, 0.5):
            canvas.zoom(factor)
            qtbot.wait(20)
        canvas.fit()
        qtbot.wait(20)

    def pause() -> None:
        run()
        session.pause()
        qtbot.waitUntil(lambda: session.idle, timeout=PATIENCE)

    free("running with 20,000 particles", run)
    free("moving sliders while it runs", steer)
    for layer in canvas.layers:

        def switch(layer: Layer = layer) -> None:
            for _ in range(2):
                layer.set_shown(not layer.shown)
                qtbot.wait(40)

        free(f"showing and hiding the layer {layer.name}", switch)
    free("zooming", zoom)
    free("pausing", pause)


def test_nothing_blocks_the_window_while_it_is_worked_with(large: MainWindow, hand, qtbot, tmp_path: Path) -> None:
    session = large.session
    document_file = large.feature(OpenSaveFeature).document_file

    def edit() -> None:
        for row in range(5):
            circle = Circle((100.0 * row, 500.0), 60.0)
            session.edit("draw", lambda document, circle=circle: edits.add_shape(document, circle))
            qtbot.wait(10)
        for key in (Qt.Key.Key_Z, Qt.Key.Key_Z, Qt.Key.Key_Y, Qt.Key.Key_Z):
            hand.key(key, Qt.KeyboardModifier.ControlModifier)
            qtbot.wait(10)

    def save() -> None:
        session.edit("draw", lambda document: edits.add_shape(document, Circle((9.0, 9.0), 5.0)))
        document_file.save(tmp_path / "large.cpm")
        qtbot.waitUntil(lambda: not document_file.unsaved, timeout=PATIENCE)

    def open_again() -> None:
        session.open(tmp_path / "large.cpm")
        qtbot.wait(20)
        qtbot.waitUntil(lambda: session.idle, timeout=PATIENCE)

    for dock in large.docks:

        def reveal(dock: QDockWidget = dock) -> None:
            dock.toggleViewAction().trigger()
            qtbot.wait(20)
            dock.toggleViewAction().trigger()
            large.docks.reveal(dock.objectName())
            qtbot.wait(20)

        free(f"opening the panel {dock.objectName()}", reveal)
    free("editing, undo and redo", edit)
    free("saving", save)
    free("opening the session again", open_again)
