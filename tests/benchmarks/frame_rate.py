"""How smoothly the window runs; prints the figures.

Run by itself: ``python tests/benchmarks/frame_rate.py [seconds]``. First a uniform grid of points starts on a 700 x 700
image of many discs and the engine steps without a limit; then, to measure the drawing alone, 20,000 and 100,000
particles that only tremble take sixty steps a second, the former colored by their speed as well. Meanwhile each
repaint of the canvas is timed, and a second thread presses an arrow key on the damping slider every tenth of a second:
from the moment that it is sent to the moment that the document has changed is the reaction, and the next repaint after
that is when the user sees it. The whole canvas is repainted in every frame, whether the engine has taken a step
meanwhile or not.
"""

from __future__ import annotations

import sys
import tempfile
import threading
import time
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from PySide6.QtCore import QCoreApplication, QEvent, QObject, Qt, QTimer
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QWidget

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from app.model.document import edits
from app.session.exchange.messages import Core, Snapshot
from app.session.features.workspace import Workspace
from app.session.session import FRAME
from app.views.application import make_application
from app.views.features.files import OpenSaveFeature
from app.views.main_window import make_window
from cpm_core.contours.result import Result
from cpm_core.model.starts import uniform_grid
from cpm_core.model.state import Particles
from cpm_core.segmentation.engine import Engine
from cpm_core.shapes import Points

SIDE = 700
SPACING = 12.5
KEY_EVERY = 0.1


def print_line(line: str) -> None:
    """Write a line of the report."""
    sys.stdout.write(f"{line}\n")


@dataclass
class Times:
    """Moments on one clock [s]."""

    paints: list[float] = field(default_factory=list)
    sent: list[float] = field(default_factory=list)
    executed: list[float] = field(default_factory=list)
    counts: list[int] = field(default_factory=list)
    steps: list[int] = field(default_factory=list)

    def note(self, snapshot: Snapshot | None) -> None:
        """Keep count and step of what is drawn."""
        if snapshot is not None:
            self.counts.append(len(snapshot.position))
            self.steps.append(snapshot.state.step)


class PaintClock(QObject):
    """Notes when the canvas is painted."""

    def __init__(self, times: Times) -> None:
        super().__init__()
        self.times = times

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802  # Qt's name
        if event.type() == QEvent.Type.Paint:
            self.times.paints.append(time.perf_counter())
        return False


class Trembling(Engine):
    """So many particles along curves, of which some tremble for ever: they cost next to nothing but to be drawn."""

    count = 0

    def start(self, seeds):
        rng = np.random.default_rng(1)
        rings = max(1, self.count // 400)
        side = int(np.ceil(np.sqrt(rings)))
        ring, angle = np.arange(self.count) % rings, rng.uniform(0.0, 2.0 * np.pi, self.count)
        center = (np.stack([ring // side, ring % side], 1) + 0.5) * SIDE / side
        self._at = center + 0.4 * SIDE / side * np.stack([np.sin(angle), np.cos(angle)], 1)
        self._trembling = np.where(ring % 3 > 0, 0.0, 0.3)[:, None] * rng.normal(size=(2, self.count, 2))
        return self._placed(super().start(seeds), 0)

    def step(self, state, parameters, charges=()):
        return self._placed(state, state.step + 1)

    def result(self, state, parameters):
        return Result(state.position, (), None, state.step, False, "", state.shape, (1.0, 1.0), None, "")

    def _placed(self, state, step):
        offset = self._trembling[step % 2]
        particles = replace(Particles.at_rest(self._at + offset), velocity=offset)
        return replace(state, particles=particles, scale=0, step=step, epsilon=1.0)


def trembling(count: int) -> Core:
    """A core with so many random particles."""
    return Core(methods={"cpm": type("TremblingCrowd", (Trembling,), {"count": count})})


def discs(side: int) -> np.ndarray:
    """An image of many discs of several gray levels."""
    rng = np.random.default_rng(1)
    row, col = np.indices((side, side))
    values = np.full((side, side), 40.0)
    for center_row in range(50, side, 100):
        for center_col in range(50, side, 100):
            radius = rng.uniform(18, 42)
            inside = (row - center_row) ** 2 + (col - center_col) ** 2 <= radius**2
            values[inside] = rng.uniform(90, 240)
    return values


def press_keys(slider: QWidget, times: Times, end: threading.Event) -> None:
    """Press an arrow key every now and then, back and forth."""
    keys = (Qt.Key.Key_Right, Qt.Key.Key_Left)
    while not end.wait(KEY_EVERY):
        key = keys[len(times.sent) % 2]
        event = QKeyEvent(QEvent.Type.KeyPress, key, Qt.KeyboardModifier.NoModifier)
        times.sent.append(time.perf_counter())
        QCoreApplication.postEvent(slider, event)


def wait(application: QCoreApplication, condition, seconds: float) -> None:
    """Let the event loop run until a condition holds."""
    end = time.perf_counter() + seconds
    while not condition() and time.perf_counter() < end:
        application.processEvents()
        time.sleep(0.001)


def measure(seconds: float, count: int | None = None, color: str = "state") -> Times:
    """Run the window for some seconds, with that many random particles or with the engine itself.

    The particles are colored by whether they rest, or by another quantity.
    """
    application = make_application()
    workspace = Workspace(trembling(count) if count else None)
    window, session = make_window(workspace), workspace.session
    window.canvas_area.canvas.layers["particles"].choose("colour", color)
    window.showMaximized()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "discs.npy"
        np.save(path, discs(SIDE))
        session.open(path)
        wait(application, lambda: session.document.image is not None, 60)
    session.warm_up()
    wait(application, lambda: session.idle, 120)
    points = Points(tuple(map(tuple, uniform_grid((SIDE, SIDE), SPACING))))
    session.edit("grid", lambda document: edits.add_shape(document, points))
    session.edit("one scale", lambda document: edits.set_parameter(document, "scales", 1))
    session.edit("no insertion", lambda document: edits.set_parameter(document, "d_max", 0.0))
    session.set_pace(60.0 if count else None)
    times = Times()
    clock = PaintClock(times)
    session.run()
    wait(application, lambda: session.status.step > 0, 60)
    window.canvas_area.canvas.viewport().installEventFilter(clock)
    session.document_changed.connect(lambda _: times.executed.append(time.perf_counter()))
    session.scene_changed.connect(lambda: times.note(session.scene.snapshot))
    end = threading.Event()
    keys = threading.Thread(target=press_keys, args=(window.panels["run"].parameters.rows["beta"].slider, times, end))
    keys.start()
    # The engine may take fewer steps a second than there are frames; every frame is drawn all the same, as at worst.
    frame = QTimer()
    frame.setTimerType(Qt.TimerType.PreciseTimer)
    frame.timeout.connect(window.canvas_area.canvas.viewport().update)
    frame.start(FRAME)
    QTimer.singleShot(int(seconds * 1000), lambda: application.exit(0))  # quit would ask whether to save
    application.exec()
    end.set()
    keys.join()
    print_line(
        f"platform {application.platformName()}, "
        f"canvas {window.canvas_area.canvas.width()} x {window.canvas_area.canvas.height()}, "
        f"at the end: {session.resolved.state}"
    )
    window.feature(OpenSaveFeature).document_file.forget()  # without a question whether to save
    window.close()
    return times


def report(times: Times) -> None:
    """Print the figures."""
    paints = np.array(times.paints)
    gaps = 1e3 * np.diff(paints)
    executed = np.array(times.executed)
    sent = np.array(times.sent[: len(executed)])
    reaction = 1e3 * (executed - sent)
    following = np.searchsorted(paints, executed)
    seen = 1e3 * (paints[following[following < len(paints)]] - sent[following < len(paints)])
    duration = paints[-1] - paints[0]
    print_line(
        f"particles {min(times.counts)} to {max(times.counts)}, "
        f"{(times.steps[-1] - times.steps[0]) / duration:.0f} steps/s"
    )
    print_line(f"frames/s {len(gaps) / duration:.1f}")
    for name, values in (("between frames", gaps), ("key to document", reaction), ("key to repaint", seen)):
        median, late = np.percentile(values, [50, 99])
        print_line(f"{name}: median {median:.1f} ms, 99 % {late:.1f} ms, longest {values.max():.1f} ms ({len(values)})")


if __name__ == "__main__":
    for crowd, color in ((None, "state"), (20_000, "state"), (20_000, "speed"), (100_000, "state")):
        print_line(f"{crowd:,} random particles, colored by {color}" if crowd else "the engine at full speed")
        report(measure(float(sys.argv[1]) if len(sys.argv) > 1 else 10.0, crowd, color))
