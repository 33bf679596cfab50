"""How many different pictures come a second while particles flow, in the worst second, and what each of them costs.

Run by itself: ``python tests/benchmarks/frames.py [seconds [steps a second, 0 for no limit]]``, in a window of
1600 x 1000. In an image of 1400 x 1400 px with a disc, 20,000 particles start from a grid, until half of them rest; in
a volume of 256^3 voxels with eight balls, which canvas, both slices next to it and the view in space show, a grid of
points grows to 26,000 particles, and pictures count from 20,000 on. A picture counts when it is painted with other
positions than the one before it; in a volume there are some between two steps. The worst second is that with the
fewest pictures of all seconds that begin with one. The processor time of the window's thread, of the engine's and of
all is divided by their number: unlike the rate, it depends little on what else the computer does.
"""

from __future__ import annotations

import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PySide6.QtCore import QCoreApplication, QEvent, QObject, QTimer
from PySide6.QtWidgets import QApplication

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from cpm_app.model.document import edits
from cpm_app.model.state.resolve import INITIAL_PACE_INDEX, RUN_PACES
from cpm_app.session.exchange.messages import Snapshot
from cpm_app.views.window.window import MainWindow

from cpm_core import Parameters
from cpm_core.shapes import Points
from tests.benchmarks.window import shown_window

PATIENCE = 300.0


def disc() -> np.ndarray:
    """An image of a disc, so large that particles flow to its boundary for long."""
    row, col = np.indices((1400, 1400)) - 700
    return np.where(np.hypot(row, col) < 400, 200.0, 40.0)


def balls() -> np.ndarray:
    """A volume with eight balls."""
    away = (np.indices((256,) * 3, dtype=np.float32) % 128) - 64
    return np.clip(40.0 + 160.0 * (26.5 - np.sqrt((away**2).sum(axis=0))), 40.0, 200.0).astype(np.uint8)


def grid(shape: tuple[int, ...], spacing: float) -> Points:
    """Points so far from each other."""
    axes = np.meshgrid(*(np.arange(spacing / 2, side, spacing) for side in shape), indexing="ij")
    return Points(tuple(map(tuple, np.stack(axes, axis=-1).reshape(-1, len(shape)).tolist())))


class Pictures(QObject):
    """Notes when a widget is painted with other positions of the particles than before."""

    def __init__(self, widget: QObject, positions: Callable[[], np.ndarray | None]) -> None:
        super().__init__()
        self._positions = positions
        self.times: list[float] = []
        self._last: np.ndarray | None = None
        widget.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802  # Qt's name
        if event.type() == QEvent.Type.Paint:
            now = self._positions()
            if now is not None and self._last is not now and not np.array_equal(self._last, now):
                self._last = now
                self.times.append(time.perf_counter())
        return False

    def __str__(self) -> str:
        times = np.array(self.times)
        whole = times[times <= times[-1] - 1.0]
        worst = (np.searchsorted(times, whole + 1.0) - np.searchsorted(times, whole)).min(initial=len(times))
        return (
            f"worst second {worst}, mean {len(times) / np.ptp(times):.1f}, longest {1e3 * np.diff(times).max():.0f} ms"
        )


def wait(condition: Callable[[], bool]) -> None:
    """Let the event loop run until a condition holds."""
    end = time.perf_counter() + PATIENCE
    while not condition() and time.perf_counter() < end:
        QCoreApplication.processEvents()
        time.sleep(0.001)


def over(snapshot: Snapshot) -> bool:
    """Whether a run has ended, or half of its particles in an image rest."""
    return bool(snapshot.state.stop_reason) or (snapshot.position.shape[1] == 2 and snapshot.resting.mean() > 0.5)


def engine_time() -> float:
    """Processor time of the engine's thread, on Linux [s]."""
    (thread,) = (one for one in threading.enumerate() if one.name == "cpm-engine")
    fields = Path(f"/proc/self/task/{thread.native_id}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / 100.0


def measure(
    window: MainWindow, values: np.ndarray, points: Points, least: int, seconds: float, pace: float | None
) -> None:
    """Run a new window for some seconds from so many particles on, and print the figures."""
    application, session = QApplication.instance(), window.session
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "values.npy"
        np.save(path, values)
        session.open_file(path)
        wait(lambda: session.document.image is not None)
    wait(lambda: session.idle and window.turns.is_idle)
    if values.ndim == 3:
        window.workspace.slices.go_through((64,) * 3)
    else:
        session.edit("few", lambda document: edits.set_parameters(document, Parameters(scales=1)))
    session.edit("grid", lambda document: edits.add_shape(document, points))
    session.set_pace(pace)
    session.run()
    wait(lambda: session.status.count >= least and session.status.step > 0)
    canvas, flow = window.canvas_area.canvas, window.canvas_area.flow
    views = {"canvas": Pictures(canvas.viewport(), lambda: flow.scene.snapshot.position)}
    if values.ndim == 3:
        space = window.panels["space"].view
        views["space"] = Pictures(space, lambda: space.positions)
    counts, first = [len(session.scene.snapshot.position)], session.status.step
    used = np.array([time.process_time(), time.thread_time(), engine_time()])
    begin = time.perf_counter()
    QTimer.singleShot(int(seconds * 1000), lambda: application.exit(0))  # quit would ask whether to save
    session.store.scene_changed.connect(lambda: over(session.scene.snapshot) and application.exit(0))
    application.exec()
    took = time.perf_counter() - begin
    used = 1e3 * (np.array([time.process_time(), time.thread_time(), engine_time()]) - used)
    counts.append(len(session.scene.snapshot.position))
    lines = [
        f"{application.platformName()}, {counts[0]:,} to {counts[1]:,} particles, "
        f"{(session.status.step - first) / took:.1f} steps/s during {took:.1f} s, {session.resolved.state}",
        *(f"different pictures a second, {name}: {pictures}" for name, pictures in views.items()),
        "processor time [ms] for each picture of the canvas: "
        + ", ".join(
            f"{name} {value / len(views['canvas'].times):.1f}"
            for name, value in zip(("all", "window", "engine"), used, strict=True)
        ),
    ]
    sys.stdout.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 10.0
    pace = (float(sys.argv[2]) or None) if len(sys.argv) > 2 else RUN_PACES[INITIAL_PACE_INDEX]
    for values, spacing, least in ((disc(), 9.9, 0), (balls(), 16.0, 20_000)):
        with shown_window(1600, 1000) as window:
            measure(window, values, grid(values.shape, spacing), least, seconds, pace)
