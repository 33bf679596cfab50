"""Closing the window at every moment of everything that goes on in the background."""

from __future__ import annotations

import itertools
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from cpm_app.model.document import edits
from cpm_app.model.export import ExportFile, ExportOrder
from cpm_app.views.export.frames import AnimationPlan
from cpm_app.views.features.animation import AnimationFeature
from cpm_app.views.features.files import OpenSaveFeature, RecoveryFeature
from cpm_app.views.tools import TOOLS
from cpm_app.views.window.window import MainWindow
from PySide6.QtWidgets import QApplication

from cpm_core.formats import load_image
from cpm_core.formats.sessions.session_file import load_session
from cpm_core.shapes import Circle

from ..clock import now
from ..report import Budget, Report, going_on
from .delays import Delays
from .program import IMAGES, await_true, destroyed, discarding, opened, ours, settled, surroundings
from .watch import ANSWERS_WITHIN, Watch

MOMENTS = (0.0, 0.002, 0.01, 0.04, 0.15)
"""Times from the beginning of a task until the window is closed [s]."""


def open_next(window: MainWindow, folder: Path) -> None:
    window.open_image(str(folder.parent / "images" / IMAGES[1]))


def prepare_partition(window: MainWindow, folder: Path) -> None:
    press(window, TOOLS[0].name)


def write_film(window: MainWindow, folder: Path) -> None:
    steps = tuple(range(4))
    window.get_feature(AnimationFeature).export_animation(1, AnimationPlan(steps, (160, 160), 10), folder / "film.gif")


def export(window: MainWindow, folder: Path) -> None:
    window.session.export_files(ExportOrder((ExportFile(folder / "contours.csv", "contours", ".csv"),)))


def save(window: MainWindow, folder: Path) -> None:
    window.get_feature(OpenSaveFeature).document_file.save(folder / "work.cpm")


def write_journal(window: MainWindow, folder: Path) -> None:
    journal = window.get_feature(RecoveryFeature).journal
    assert journal is not None
    journal.write()


def run(window: MainWindow, folder: Path) -> None:
    window.session.run()


def find_skeleton(window: MainWindow, folder: Path) -> None:
    press(window, "image_skeleton")


def compare_with_truth(window: MainWindow, folder: Path) -> None:
    window.workspace.comparison.load_truth_file(folder.parent / "images" / IMAGES[0])


def compare_two_results(window: MainWindow, folder: Path) -> None:
    compared = window.workspace.comparison
    compared.select_row(max(compared.rows))


TASKS: Sequence[Callable[[MainWindow, Path], None]] = (
    open_next, prepare_partition, write_film, export, save, write_journal, run, find_skeleton,
    compare_with_truth, compare_two_results,
)  # fmt: skip


def press(window: MainWindow, name: str) -> None:
    """Do an action."""
    window.actions_by_name[name].trigger()


def closed_during(task: Callable[[MainWindow, Path], None], moment: float, image: Path, folder: Path) -> list[str]:
    """Begin a task in a window with a short run, close the window after a moment, and say what does not hold then."""
    folder.mkdir()
    before = set(threading.enumerate())
    window = opened(image)
    session = window.session
    session.edit("draw", lambda document: edits.add_shape(document, Circle((30.0, 30.0), 12.0)))
    for step in range(1, 4):
        session.step()
        await_true(lambda step=step: session.status.step == step, "a step")  # type: ignore[misc]
    await_true(lambda: settled(window), "the first steps")
    task(window, folder)
    end = time.monotonic() + moment
    while time.monotonic() < end:
        QApplication.processEvents()
    began = now()
    window.close()
    seconds = now() - began
    broken = []
    if window.isVisible():
        broken.append("the window is open")
    if seconds > ANSWERS_WITHIN:
        broken.append(f"closing took {seconds:.1f} s")
    destroyed(window)
    left = [thread.name for thread in set(threading.enumerate()) - before if ours(thread)]
    if left:
        broken.append(f"threads are left: {left}")
    others = [type(top).__name__ for top in QApplication.topLevelWidgets() if top.isVisible()]
    if others:
        broken.append(f"windows are left: {others}")
    return broken + damaged(folder, saved=task is save)


def damaged(folder: Path, saved: bool) -> list[str]:
    """What is not whole of the files in a folder."""
    broken = []
    for path in folder.iterdir():
        match path.suffix:
            case ".cpm":
                load_session(path)
            case ".csv":
                if not path.read_text(encoding="utf-8").endswith("\n"):
                    broken.append(f"{path.name} is cut off")
            case ".gif":
                load_image(path)
            case _:
                broken.append(f"{path.name} is left")
    if saved and not (folder / "work.cpm").exists():
        broken.append("what was saved is not there")
    return broken


def try_closing(
    budget: Budget,
    tasks: Sequence[Callable[[MainWindow, Path], None]] = TASKS,
    moments: Sequence[float] = MOMENTS,
    rounds: int | None = None,
) -> Report:
    """Close during each task at each moment, and again with other delays until the time or the rounds are over."""
    tried = faults = 0
    failures: list[str] = []
    end = time.monotonic() + budget.seconds
    pairs = list(itertools.product(moments, tasks))
    with surroundings(budget.folder) as images, discarding(), Watch().kept() as watch:
        for moment, task in itertools.chain.from_iterable(itertools.repeat(pairs, 1_000 if rounds is None else rounds)):
            if not going_on(end):
                break
            tried += 1
            with Delays(f"{budget.seed}:{tried}").injected() as delays:
                broken = closed_during(task, moment, images / IMAGES[0], budget.folder / f"closed {tried}")
            faults += delays.count
            what = f"closed {moment} s after {task.__name__} (seed {budget.seed}, number {tried})"
            failures += [f"{what}: {sentence}" for sentence in (*broken, *watch.troubles)]
            watch.troubles.clear()
    return Report(tried, faults, tuple(failures))
