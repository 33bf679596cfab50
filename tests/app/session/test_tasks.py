"""Long tasks show their progress and remaining time, and can be cancelled at once."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from cpm_app.model.export import ExportFile, ExportOrder
from cpm_app.session.exchange.messages import CommandFailed, CompilationProgress, Report, WarmedUp
from cpm_app.session.features.workspace import Workspace
from cpm_app.session.tasks import opening
from cpm_app.session.tasks.tasks import BackgroundTask, Cancelled, TaskManager
from cpm_app.session.worker.commands import WorkerCommand
from cpm_app.views.application import make_application
from cpm_app.views.features.run import TasksFeature
from cpm_app.views.main_window import make_window
from PySide6.QtCore import QObject, Qt
from PySide6.QtWidgets import QProgressBar, QToolButton

from cpm_core import Image, load_image

PATIENCE = 20_000


def test_advance_of_a_cancelled_task_raises() -> None:
    task = BackgroundTask("Counting")
    task.advance(0.1)
    task.cancel()
    with pytest.raises(Cancelled):
        task.advance(0.2)
    assert task.is_over


@pytest.fixture
def reports() -> list[Report]:
    return []


@pytest.fixture
def tasks(qapp: QObject, reports: list[Report]) -> Iterator[TaskManager]:
    made = TaskManager(reports.append, lambda: None)
    yield made
    made.close()


def settled(tasks: TaskManager) -> bool:
    tasks.announce_changes()
    return tasks.idle


def test_the_result_and_the_error_of_a_task_are_reported(qtbot, tasks, reports) -> None:
    def fall(task: BackgroundTask) -> Report:
        raise ValueError("the disk is full")

    tasks.start_task("Good", lambda task: CommandFailed("News."), "being good")
    qtbot.waitUntil(lambda: settled(tasks), timeout=PATIENCE)
    tasks.start_task("Bad", fall, "being bad")
    qtbot.waitUntil(lambda: settled(tasks), timeout=PATIENCE)
    assert reports == [CommandFailed("News."), CommandFailed("The disk is full.")]


def test_nothing_comes_of_a_task_that_was_given_up_whether_it_notices_or_not(qtbot, tasks, reports) -> None:
    gate = threading.Event()

    def deaf(task: BackgroundTask) -> Report:
        assert gate.wait(20)
        return CommandFailed("Too late.")

    def listening(task: BackgroundTask) -> Report:
        assert gate.wait(20)
        task.advance(0.5)
        return CommandFailed("Too late.")

    for work in (deaf, listening):
        task = tasks.start_task("Work", work, "working")
        assert tasks.current[-1] is task
        task.cancel()
        assert task not in tasks.current
    assert not tasks.idle
    gate.set()
    qtbot.waitUntil(lambda: settled(tasks), timeout=PATIENCE)
    assert reports == []


def test_closing_gives_everything_up_and_leaves_no_thread(tasks, reports) -> None:
    began = threading.Event()

    def endless(task: BackgroundTask) -> Report:
        began.set()
        while True:
            task.advance(0.5)

    tasks.start_task("Endless", endless, "going on")
    assert began.wait(20)
    tasks.close()
    assert (tasks.idle, reports) == (True, [])


def waiting(gate: threading.Event) -> WorkerCommand:
    """Blocks the worker until it is released."""
    return WorkerCommand(lambda _: gate.wait(20))


class Gated:
    """Reads images, but those called slow only when it is released."""

    def __init__(self) -> None:
        self.gate = threading.Event()

    def __call__(self, path: Path, check_cancelled: Callable[[], object], **_: object) -> Image:
        if path.name.startswith("slow"):
            assert self.gate.wait(20)
        return load_image(path, check_cancelled=check_cancelled)


@pytest.fixture
def reader() -> Gated:
    return Gated()


@pytest.fixture
def workspace(
    qapp: QObject, compiled_loops: None, reader: Gated, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Workspace]:
    monkeypatch.setattr(opening, "load_image", reader)
    made = Workspace()
    made.session.set_pace(None)
    yield made
    reader.gate.set()
    made.session.close()


@pytest.fixture
def slow_file(tmp_path: Path) -> Path:
    path = tmp_path / "slow.npy"
    np.save(path, np.eye(40))
    return path


def test_an_image_that_takes_long_is_given_up_by_a_click_and_the_one_before_runs_on(
    ready, hand, slow_file, reader, qtbot
) -> None:
    session, bar = ready.session, ready.get_feature(TasksFeature).bar
    session.set_pace(30.0)
    hand.key(Qt.Key.Key_Space)
    hand.wait(lambda: session.status.step >= 1)
    session.open_file(slow_file)
    hand.wait(bar.isVisible)
    assert bar.text.startswith("Opening slow.npy…")
    assert session.resolved.state.startswith("Running")  # the bar tells of the other image
    step = session.status.step
    hand.wait(lambda: session.status.step > step or session.status.phase == "finished")
    qtbot.mouseClick(bar.findChild(QToolButton), Qt.MouseButton.LeftButton)
    assert not bar.isVisible()
    reader.gate.set()
    session.pause()
    hand.wait(lambda: session.idle)
    assert session.document.image.name == "disc.npy"
    assert session.document.shapes
    assert session.status.step > 0


def test_the_first_compilation_moves_a_bar_until_its_end(ready, hand) -> None:
    session, bar = ready.session, ready.get_feature(TasksFeature).bar

    def report(told: Report) -> None:
        session.post_command(WorkerCommand(lambda context: context.report(told), "telling"))

    for percent in (25, 75):
        report(CompilationProgress(percent))
        hand.wait(lambda done=percent: bar.isVisible() and bar.findChild(QProgressBar).value() == 10 * done)
    assert bar.text.startswith("Preparing, only this once…")
    report(WarmedUp())
    hand.wait(lambda: not bar.isVisible())


def test_of_two_images_opened_in_a_row_the_later_one_is_open(window, hand, slow_file, reader, tmp_path) -> None:
    np.save(tmp_path / "quick.npy", np.eye(24))
    window.session.open_file(slow_file)
    window.session.open_file(tmp_path / "quick.npy")
    hand.wait(lambda: window.session.document.image.name == "quick.npy")
    reader.gate.set()
    hand.wait(lambda: window.session.idle)
    assert window.session.document.image.name == "quick.npy"


def test_an_export_that_was_given_up_writes_nothing(ready, hand, tmp_path) -> None:
    session = ready.session
    hand.key(Qt.Key.Key_Period)
    hand.wait(lambda: session.status.step == 1 and session.idle)
    gate = threading.Event()
    session.post_command(waiting(gate))  # so that the export has not begun when it is cancelled
    session.export_files(ExportOrder((ExportFile(tmp_path / "a.csv", "contours", ".csv"),)))
    for task in session.tasks.current:
        task.cancel()
    session.export_files(ExportOrder((ExportFile(tmp_path / "b.csv", "contours", ".csv"),)))
    gate.set()
    hand.wait(lambda: session.idle)
    assert (tmp_path / "b.csv").exists()
    assert not (tmp_path / "a.csv").exists()


def test_closing_while_an_image_is_being_opened_ends_at_once_and_well(
    qtbot, workspace: Workspace, slow_file: Path, reader: Gated
) -> None:
    make_application()
    window, session = make_window(workspace), workspace.session
    window.show()
    session.open_file(slow_file)
    reader.gate.set()
    window.close()
    assert session.document.image is None
    window.deleteLater()
