"""Longest time for which the window's thread keeps its event loop waiting in the ordinary use.

Run by itself: ``python tests/benchmarks/blocking.py [name]``, where only what contains the name is printed. Measured is
the processor time of this thread between two returns to the loop, not what others take of the computer meanwhile.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from PySide6.QtCore import QEventLoop, QPoint, Qt, QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QDialog

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from cpm_app.model.document import edits
from cpm_app.model.document.modes import switch_mode
from cpm_app.model.preferences.table import THEME_PREFERENCE
from cpm_app.views.widgets.turns import Turns
from cpm_app.views.window.window import MainWindow

from cpm_core.shapes import Circle, Sphere
from tests.benchmarks.window import shown_window

REST, PATIENCE = 0.2, 60.0
"""Time for which nothing happens after what has been done, and the longest that is waited for that [s]."""

MANY = 150

Work = tuple[str, Callable[[], object]] | tuple[str, Callable[[], object], Callable[[], bool]]


def turn(window: MainWindow, do: Callable[[], object], done: Callable[[], bool] = lambda: True) -> float:
    """The longest turn from the beginning of something until it is done and the window has rested for a while [ms]."""
    session, loop = window.session, QEventLoop()
    longest, at, begin, busy = 0.0, time.thread_time(), time.perf_counter(), time.perf_counter()

    def beat() -> None:
        nonlocal longest, at, busy
        now, clock = time.thread_time(), time.perf_counter()
        longest, at = max(longest, now - at), now
        idle = session.idle and all(turns.is_idle for turns in window.findChildren(Turns))
        busy = busy if idle and done() else clock
        if clock - busy > REST or clock - begin > PATIENCE:
            loop.quit()

    timer = QTimer()
    timer.timeout.connect(beat)
    timer.start(1)
    do()
    loop.exec()
    return 1e3 * longest


def image_of(folder: Path, name: str, shape: tuple[int, ...]) -> Path:
    """A file with an image or a volume of discs or balls, one in each 64 pixels."""
    away = [n % 64 - 32.0 for n in np.indices(shape, dtype=np.float32, sparse=True)]
    np.save(folder / name, np.where(sum(n**2 for n in away) < 400, 200, 30).astype(np.uint8))
    return folder / name


def in_image(window: MainWindow, folder: Path) -> Iterator[Work]:
    """What is done with an image."""
    session, canvas, do = window.session, window.canvas_area.canvas, window.trigger_action
    click = Qt.MouseButton.LeftButton

    def offered() -> bool:
        return len(session.scene.objects.proposals) > MANY

    def at(row: float, col: float) -> QPoint:
        return canvas.map_from_image((row, col)).toPoint()

    for side in (4096, 896):
        path = image_of(folder, f"{side}.npy", (side, side))
        yield f"open an image of {side} x {side}", lambda path=path: session.open_file(path)
    yield "draw", lambda: session.edit("draw", lambda d: edits.add_shape(d, Circle((32.0, 32.0), 10.0)))
    yield "run, first contours", session.run
    yield (
        "a run from everywhere",
        lambda: (session.edit("all", lambda d: switch_mode(d, "automatic")), session.run()),
        offered,
    )
    yield "step back on the timeline", lambda: do("timeline_back")
    for key in (Qt.Key.Key_PageUp, Qt.Key.Key_Home, Qt.Key.Key_End):
        yield f"scrub, {key.name}", lambda key=key: QTest.keyClick(window.panels["timeline"].view, key)
    for name in ("objects", "compare", "layers", "objects", "run", "objects"):
        yield f"tab {name}", lambda name=name: window.docks.reveal_panel(name)
    yield "tool for objects", lambda: do("objects")
    yield "point at a proposal", lambda: QTest.mouseMove(canvas.viewport(), at(160, 160))
    yield "click on a proposal", lambda: QTest.mouseClick(canvas.viewport(), click, pos=at(160, 160))
    yield "escape", lambda: do("escape")
    yield "wait for proposals", lambda: None, offered
    yield "accept all", window.workspace.object_commands.accept_pending
    for name in ("undo", "redo", "undo"):
        yield f"{name} it", lambda name=name: do(name)
    yield "wait for proposals", lambda: None, offered
    yield "reject all", window.workspace.object_commands.reject_selected
    for name in ("undo", "redo", "undo", "redo", "undo"):
        yield f"{name} it", lambda name=name: do(name)
    yield "wait for proposals", lambda: None, offered
    yield "accept all again", window.workspace.object_commands.accept_pending
    yield "select one", lambda: QTest.mouseClick(canvas.viewport(), click, pos=at(352, 352))
    yield "select all", lambda: do("all_objects")
    yield "delete all", lambda: do("delete_object")
    yield "undo it", lambda: do("undo")
    for name in ("preferences", "compare", "export", "guide"):
        yield f"dialog {name}", lambda name=name: do(name)
        yield f"close {name}", lambda: [dialog.close() for dialog in window.findChildren(QDialog) if dialog.isVisible()]
    for name in ("dark", "light"):
        yield f"theme {name}", lambda name=name: window.preferences.store_preference(THEME_PREFERENCE, name)


def in_volume(window: MainWindow, folder: Path) -> Iterator[Work]:
    """What is done with a volume."""
    session, slices = window.session, window.workspace.slices
    path = image_of(folder, "volume.npy", (256,) * 3)
    yield "open a volume of 256^3", lambda: session.open_file(path)
    yield "other slices", lambda: slices.go_through((60, 90, 90))
    yield "next slice", lambda: slices.go_by(1)
    yield "slices across another axis", lambda: slices.set_axis(2)
    canvas, brush, click = window.canvas_area.canvas, window.workspace.object_brush, Qt.MouseButton.LeftButton
    for name, radius, in_space in (("a slice", 8.0, False), ("10^6 voxels in space", 62.0, True), ("it", 8.0, False)):
        yield (
            f"take the brush for {name}",
            lambda radius=radius, in_space=in_space: (
                window.canvas_area.use_tool("mend"),
                brush.set_radius(radius),
                setattr(brush, "paints_in_space", in_space),
            ),
        )
        for act, col in (
            (QTest.mousePress, 100),
            (QTest.mouseMove, 110),
            (QTest.mouseMove, 120),
            (QTest.mouseRelease, 120),
        ):
            at, held = canvas.map_from_image((100, col)).toPoint(), (click,) if act is not QTest.mouseMove else ()
            yield (
                f"paint {name}, {act.__name__}",
                lambda act=act, at=at, held=held: act(canvas.viewport(), *held, pos=at),
            )
    yield "undo painting", lambda: window.trigger_action("undo")
    yield "fill between slices", lambda: window.trigger_action("fill_between")
    sphere = Sphere((96.0, 96.0, 96.0), 10.0)
    yield "draw a sphere", lambda: session.edit("draw", lambda d: edits.add_shape(d, sphere))
    yield "run, first surface", session.run
    yield "tab in space", lambda: window.docks.reveal_panel("space")


def measure(only: str) -> None:
    """Do everything in a new window, and print how long the longest turn of it takes."""
    with shown_window(1600, 1000) as window, tempfile.TemporaryDirectory() as folder:
        turn(window, lambda: None)
        for works in (in_image, in_volume):
            for what, *work in works(window, Path(folder)):
                longest = turn(window, *work)
                if only in what:
                    sys.stdout.write(f"{longest:6.1f} ms  {what}\n")
                    sys.stdout.flush()


if __name__ == "__main__":
    measure(sys.argv[1] if len(sys.argv) > 1 else "")
