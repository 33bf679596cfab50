"""The window's thread never keeps the event loop waiting, whatever is being done.

Counted is what this thread calls between two returns to the event loop: the measure depends neither on the computer nor
on how busy it is. What takes long inside one call is watched by where it happens: this thread enters no room of the
core that computes, and never writes anything through to a disk. The benchmark ``blocking.py`` takes the times.
"""

from __future__ import annotations

import gc
import os
import sys
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from types import FrameType

import numpy as np
import pytest
from cpm_app.model.document import edits
from cpm_app.model.document.samples import load_samples
from cpm_app.session.features.workspace import Workspace
from cpm_app.views.application import make_application
from cpm_app.views.layers.layer import Layer
from cpm_app.views.main_window import make_window
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import Qt, QTimer

import cpm_core
from cpm_core import Parameters, uniform_grid
from cpm_core.shapes import Points

MOST_CALLS = 100_000
"""Calls of Python between two returns to the loop: 60,000 when a thousand contours arrive; too few for loops over the
20,000 particles."""

COMPUTING = tuple(
    str(Path(cpm_core.__file__).parent / room)
    for room in ("field", "model", "segmentation", "reconstruction", "medial_axis", "formats")
)
"""Rooms of the core in which there is much to be computed, read or written: they are entered by other threads."""

SIDE, LARGE = 1024, 2048
"""Sides of the images on which is computed, and on which nothing is [px]."""

LINES = 146
"""Lines and columns of the particles."""

PATIENCE = 120_000


class Watch:
    """Counts what this thread calls from one return to the event loop to the next.

    Calls are counted, not time: how many there are does not depend on what else the computer is doing.
    """

    def __init__(self) -> None:
        self.most = 0
        self.computed: set[str] = set()
        self._calls = 0
        self._timer = QTimer()
        self._timer.timeout.connect(self._beat)

    def __enter__(self) -> Watch:
        self._timer.start(1)
        sys.setprofile(self._count)
        return self

    def __exit__(self, *_: object) -> None:
        sys.setprofile(None)
        self._timer.stop()
        self._beat()

    def _beat(self) -> None:
        self.most, self._calls = max(self.most, self._calls), 0

    def _count(self, frame: FrameType, event: str, _: object) -> None:
        if event in ("call", "c_call"):
            self._calls += 1
            file = frame.f_code.co_filename
            if event == "call" and file.startswith(COMPUTING):
                self.computed.add(f"{file}:{frame.f_code.co_qualname}")


def free(what: str, do: Callable[[], object]) -> None:
    """Fail when the loop is kept waiting by something."""
    with Watch() as watch:
        do()
    assert watch.most <= MOST_CALLS, f"{what} takes {watch.most} calls at once"
    assert not watch.computed, f"{what} computes on the window's thread: {watch.computed}"


def test_the_rooms_in_which_is_computed_are_there() -> None:
    assert [room for room in COMPUTING if not Path(room).is_dir()] == []


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


def write_discs(path: Path, side: int) -> Path:
    """Write an image of this side with discs, of which a row or column has one in each 64 pixels."""
    row, col = np.indices((side, side), dtype=np.float32) % 64
    np.save(path, np.where(np.hypot(row - 32, col - 32) < 20, 200.0, 30.0) + np.arange(side) / 64)
    return path


@pytest.fixture
def image_file(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """An image with discs, of the side that the test asks for."""
    return write_discs(tmp_path / "large.npy", getattr(request, "param", SIDE))


@pytest.fixture
def window(qtbot, workspace: Workspace) -> Iterator[MainWindow]:
    """A window without an image, as warm as after the start."""
    make_application()
    made, session = make_window(workspace), workspace.session
    made.resize(1280, 800)
    made.show()
    qtbot.waitExposed(made)
    session.warm_up()
    load_samples()  # of which the first is opened at the start
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
        session.open_file(image_file)
        qtbot.wait(20)
        qtbot.waitUntil(lambda: session.idle, timeout=PATIENCE)
        qtbot.wait(100)

    free("opening a large image", open_it)
    shape = np.load(image_file, mmap_mode="r").shape
    points = Points(tuple((row, col) for row, col in uniform_grid(shape, shape[0] / LINES).tolist()))
    assert len(points.positions) > 20_000

    def draw() -> None:
        session.edit("draw", lambda document: replace(document, shapes=(points,)))
        qtbot.wait(50)

    free("drawing 20,000 points", draw)
    session.edit("one scale", lambda document: edits.set_parameters(document, Parameters(scales=1, d_max=0.0)))
    return window


@pytest.mark.long
def test_nothing_blocks_the_window_while_it_runs(large: MainWindow, hand, qtbot) -> None:
    session, canvas = large.session, hand.canvas

    def run() -> None:
        before = session.status.step
        session.run()
        qtbot.waitUntil(lambda: session.status.step >= before + 3, timeout=PATIENCE)

    def steer() -> None:
        for name in ("beta", "ratio"):
            slider = large.panels["run"].parameters.rows[name].slider
            for key in (Qt.Key.Key_Right, Qt.Key.Key_Right, Qt.Key.Key_Left):
                qtbot.keyClick(slider, key)
                qtbot.wait(20)

    def zoom() -> None:
        for factor in (1.5, 1.5, 0.5):
            canvas.zoom_by(factor)
            qtbot.wait(20)
        canvas.fit_image()
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
