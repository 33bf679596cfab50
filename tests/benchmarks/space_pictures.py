"""How many different pictures of a volume come a second while the engine runs, and what each of them costs.

Run by itself: ``python tests/benchmarks/space_pictures.py [seconds]``. A grid of points starts in a volume of 256^3
voxels with eight balls, which some 26,000 particles cover in the end, in a window of 1600 x 1000 with canvas, both
slices beside it and the view in space. From 20,000 on, a picture counts when it shows a step that none before it has
shown. The processor time of the window's thread, of the engine's and of all is divided by their number: unlike the
rate, it depends little on what else the computer does.
"""

from __future__ import annotations

import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
from PySide6.QtCore import QCoreApplication, QEvent, QObject, QTimer

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from app.model.document import edits
from app.session.features.workspace import Workspace
from app.views.application import make_application
from app.views.features.files import OpenSaveFeature
from app.views.features.volumes import SlicesFeature
from app.views.main_window import make_window
from app.views.window.window import MainWindow
from cpm_core.shapes import Points

SIDE, APART, RADIUS = 256, 128, 26.0
SPREAD = 16.0
"""Distance of the points that the particles start from."""

_FROM = 20_000
"""Particles from which on pictures are counted."""


def balls() -> np.ndarray:
    """A volume with eight balls."""
    away = (np.indices((SIDE, SIDE, SIDE), dtype=np.float32) % APART) - APART / 2
    return np.clip(40.0 + 160.0 * (RADIUS + 0.5 - np.sqrt((away**2).sum(axis=0))), 40.0, 200.0).astype(np.uint8)


class Shown(QObject):
    """Counts the paints of a view that show another step than the paint before."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__()
        self._session = window.session
        self.count = 0
        self._last: object = None

    def note(self) -> None:
        """A picture has come."""
        if self._session.scene.snapshot is not self._last:
            self._last = self._session.scene.snapshot
            self.count += 1

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802  # Qt's name
        if event.type() == QEvent.Type.Paint:
            self.note()
        return False


def wait(application: QCoreApplication, condition, seconds: float) -> None:
    """Let the event loop run until a condition holds."""
    end = time.perf_counter() + seconds
    while not condition() and time.perf_counter() < end:
        application.processEvents()
        time.sleep(0.002)


def engine_time() -> float:
    """Processor time of the engine's thread, on Linux [s]."""
    (thread,) = (one for one in threading.enumerate() if one.name == "cpm-engine")
    fields = Path(f"/proc/self/task/{thread.native_id}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / 100.0


def measure(seconds: float) -> None:
    """Run the window for some seconds and print the figures."""
    application = make_application()
    workspace = Workspace()
    window, session = make_window(workspace), workspace.session
    window.resize(1600, 1000)
    window.show()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "balls.npy"
        np.save(path, balls())
        session.open(path)
        wait(application, lambda: session.document.image is not None and session.scene.slices is not None, 60)
    session.warm_up()
    wait(application, lambda: session.idle and window.turns.idle, 300)
    workspace.slices.through((APART // 2,) * 3)
    axis = np.arange(SPREAD / 2, SIDE, SPREAD)
    places = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    points = Points(tuple(map(tuple, places.tolist())))
    session.edit("grid", lambda document: edits.add_shape(document, points))
    session.set_pace(None)
    session.run()
    wait(application, lambda: session.status.count >= _FROM or session.status.phase == "finished", 300)
    space = window.panels["space"].view
    views = {"canvas": Shown(window), "space": Shown(window)}
    views["canvas"].count = views["space"].count = 0
    window.canvas_area.canvas.viewport().installEventFilter(views["canvas"])
    space.drawn.connect(views["space"].note)
    counts = [len(session.scene.snapshot.position)]
    first, begin = session.status.step, time.perf_counter()
    used = time.process_time(), time.thread_time(), engine_time()
    QTimer.singleShot(int(seconds * 1000), lambda: application.exit(0))
    application.exec()
    took, steps = time.perf_counter() - begin, session.status.step - first
    used = time.process_time() - used[0], time.thread_time() - used[1], engine_time() - used[2]
    counts.append(len(session.scene.snapshot.position))
    every = {name: shown.count for name, shown in views.items()}
    sys.stdout.write(
        f"{counts[0]:,} to {counts[1]:,} particles, {steps / took:.1f} steps/s, {session.resolved.state}\n"
        f"different pictures a second: canvas {every['canvas'] / took:.1f}, space {every['space'] / took:.1f} "
        f"({space.width()} x {space.height()}), sides {len(window.feature(SlicesFeature).sides)}\n"
        "processor time [ms] for each picture of the canvas: "
        + ", ".join(
            f"{name} {1e3 * value / max(every['canvas'], 1):.1f}"
            for name, value in zip(("all", "window", "engine"), used, strict=True)
        )
        + "\n"
    )
    window.feature(OpenSaveFeature).document_file.forget()  # without a question whether to save
    window.close()


if __name__ == "__main__":
    measure(float(sys.argv[1]) if len(sys.argv) > 1 else 10.0)
