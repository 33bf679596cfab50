"""Windows for the tests, on small images, and checks for threads and windows that a test has not closed."""

from __future__ import annotations

import gc
import itertools
import threading
from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pytest
from cpm_app.model.document import edits
from cpm_app.session.exchange.messages import Reconstruction
from cpm_app.session.features import comparison, selector, stack_pages, timeline_navigation
from cpm_app.session.features.workspace import Workspace
from cpm_app.session.session import Session
from cpm_app.session.storage import run_collector
from cpm_app.views.features import files
from cpm_app.views.window import dialogs
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import QPoint, QSettings, Qt
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QApplication, QDialog
from pytestqt.qtbot import QtBot

from cpm_core.contours.contour import Contour
from cpm_core.results import boundaries_result
from cpm_core.shapes import Circle
from tests.app.acting import run_to_the_end
from tests.app.views.window.windows import (
    KEPT,
    Kept,
    begin_anew,
    close_window,
    close_workspace,
    fail_for_threads_since,
    is_open,
    new_window,
)

SIDE = 64

_tests = itertools.count(1)
_COLLECTED_EVERY = 20
"""Number of tests after which garbage is collected, which takes as long as the quickest of them."""

RESTS = (
    (stack_pages, "_LINK_DELAY"), (stack_pages, "_LINK_DELAY_WHILE_RUNNING"), (selector, "_PARTITION_DELAY"),
    (comparison, "_COMPARISON_DELAY"), (timeline_navigation, "_CONTOURS_DELAY"), (run_collector, "_COLLECT_DELAY"),
)  # fmt: skip
"""Times without a change after which work begins [ms]."""

T = TypeVar("T")

ASK = dialogs.ask_about_unsaved
KEEP_PICTURE = files.StartFeature._store_picture


PATIENCE = 20_000
"""Turns of a millisecond that any effect may take; no test depends on the real time, nor fails when it is stopped."""


def wait_until(qtbot: QtBot, condition: Callable[[], bool], patience: int = PATIENCE) -> None:
    """Let the window work until a condition holds."""
    for _ in range(patience):
        if condition():
            return
        qtbot.wait(1)
    pytest.fail(f"this has not happened in {patience} turns")


def show_contours(window: MainWindow, *contours: Contour) -> None:
    """Show contours as a run would have found them."""
    session, image = window.session, window.session.image
    assert image is not None
    result = boundaries_result(image.shape, "", image.spacing, image.unit, contours=tuple(contours))
    found = Reconstruction(session.store.generation, result)
    session.store.set_scene(replace(session.scene, reconstruction=found))


class Hand:
    """Real mouse and key events on a window, and waiting for their effects."""

    patience = PATIENCE

    def __init__(self, qtbot: QtBot, window: MainWindow) -> None:
        self.qtbot = qtbot
        self.window = window
        self.canvas = window.canvas_area.canvas

    def at(self, row: float, col: float) -> QPoint:
        """Point of the canvas over a position of the image."""
        return self.canvas.map_from_image((row, col)).toPoint()

    def color_at(self, row: float, col: float) -> tuple[int, int, int]:
        """Color of the canvas over a position of the image."""
        color = QColor(self.canvas.grab().toImage().pixel(self.at(row, col)))
        return color.red(), color.green(), color.blue()

    def press(self, row: float, col: float) -> None:
        """Left button down."""
        self.qtbot.mousePress(self.canvas.viewport(), Qt.MouseButton.LeftButton, pos=self.at(row, col))

    def move(self, row: float, col: float) -> None:
        """Move the pointer, with the button unchanged."""
        self.qtbot.mouseMove(self.canvas.viewport(), self.at(row, col))

    def release(self, row: float, col: float) -> None:
        """Left button up."""
        self.qtbot.mouseRelease(self.canvas.viewport(), Qt.MouseButton.LeftButton, pos=self.at(row, col))

    def click(self, row: float, col: float) -> None:
        """Press and release."""
        self.press(row, col)
        self.release(row, col)

    def double_click(self, row: float, col: float) -> None:
        """A double click, as Qt sends it: press, release, double click, release."""
        self.click(row, col)
        self.qtbot.mouseDClick(self.canvas.viewport(), Qt.MouseButton.LeftButton, pos=self.at(row, col))

    def drag(self, *positions: tuple[float, float]) -> None:
        """Press at the first position, move through the others, release at the last."""
        self.press(*positions[0])
        for position in positions[1:]:
            self.move(*position)
        self.release(*positions[-1])

    def key(self, key: Qt.Key, modifier: Qt.KeyboardModifier = Qt.KeyboardModifier.NoModifier) -> None:
        """Press a key on the focused widget, with the window's shortcuts."""
        self.window.activateWindow()
        self.qtbot.keyClick(self.window.focusWidget() or self.window, key, modifier)

    def wait(self, condition: Callable[[], bool]) -> None:
        """Wait until a condition holds."""
        wait_until(self.qtbot, condition, self.patience)

    def wait_for_phase(self, phase: str) -> None:
        """Wait until the run is in this phase."""
        self.wait(lambda: self.window.session.status.phase == phase)


def disc(radius: float = 18.0, side: int = SIDE) -> np.ndarray:
    """A bright disc in the middle of a dark image."""
    row, col = np.indices((side, side))
    return np.where(np.hypot(row - side / 2, col - side / 2) < radius, 200.0, 20.0)


@pytest.fixture(scope="session")
def qapp_cls() -> type[QApplication]:
    return QApplication


@pytest.fixture(scope="package", autouse=True)
def garbage_is_collected_by_hand() -> Iterator[None]:
    """Objects of a window must not be destroyed on another thread; see `cpm_app.views.window.python_hooks`."""
    gc.disable()
    yield
    gc.enable()


@pytest.fixture(autouse=True)
def garbage_is_collected_now_and_then() -> Iterator[None]:
    """Collect garbage between two tests: what gathers in a shared window makes each later search for it longer."""
    yield
    if next(_tests) % _COLLECTED_EVERY == 0:
        gc.collect()


@pytest.fixture(autouse=True)
def nothing_left_behind(request: pytest.FixtureRequest, kept_window: Kept) -> Iterator[None]:
    """Fail when a test leaves a thread running or a window open; threads of a window that is shared may run on."""
    if "qtbot" in request.fixturenames and "workspace" not in request.fixturenames:
        kept_window.close()  # which could lie over the widgets of the test
    threads = set(threading.enumerate())
    yield
    if kept_window.workspace is None:
        fail_for_threads_since(threads)
    application = QApplication.instance()
    if isinstance(application, QApplication):
        others = [widget for widget in application.topLevelWidgets() if widget is not kept_window.window]
        assert not [widget for widget in others if widget.isVisible()], f"windows left open: {others}"


@pytest.fixture(autouse=True)
def own_preferences(tmp_path: Path) -> None:
    """No test reads or writes the preferences of the user."""
    QSettings.setPath(QSettings.Format.IniFormat, QSettings.Scope.UserScope, str(tmp_path / "preferences"))


@pytest.fixture(autouse=True)
def rests_are_short(monkeypatch: pytest.MonkeyPatch) -> None:
    """What begins when nothing has changed for a while begins soon; no test depends on how long it rests."""
    for module, name in RESTS:
        monkeypatch.setattr(module, name, 10)


@pytest.fixture(autouse=True)
def nothing_is_selected_in_advance(monkeypatch: pytest.MonkeyPatch) -> None:
    """No selection is made only to have the first click answered sooner; tests outside of this folder do so."""
    monkeypatch.setattr(selector, "_precompute_selection", lambda made: made)


@pytest.fixture(autouse=True)
def own_pictures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No test reads or writes the user's pictures of recent work."""
    monkeypatch.setattr(files, "thumbnails_folder", lambda: tmp_path / "pictures of work")


@pytest.fixture(autouse=True)
def no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """No pictures of the canvas are taken, which takes a tenth of a test; tests of them use `pictures_taken`."""
    monkeypatch.setattr(files.StartFeature, "_store_picture", lambda feature: None)


@pytest.fixture
def pictures_taken(no_pictures: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures of the canvas are taken, as outside of tests."""
    monkeypatch.setattr(files.StartFeature, "_store_picture", KEEP_PICTURE)


@pytest.fixture(autouse=True)
def nobody_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Windows close without the question about unsaved work; tests of the question use `asked`."""
    monkeypatch.setattr(dialogs, "ask_about_unsaved", lambda parent, name, lost: "discard")


@pytest.fixture
def asked(nobody_is_asked: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """The question about unsaved work is shown, as outside of tests."""
    monkeypatch.setattr(dialogs, "ask_about_unsaved", ASK)


@pytest.fixture
def image_file(tmp_path: Path) -> Path:
    """A file with a small disc."""
    path = tmp_path / "disc.npy"
    np.save(path, disc())
    return path


@pytest.fixture(scope="session")
def kept_window() -> Kept:
    """The window that tests with the mark `shared_window` share."""
    return KEPT


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Note a failure: what a test has left in the window then shall not let others fail."""
    report = yield
    KEPT.spoiled |= report.failed
    return report


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> Generator[None]:
    """Close the window that tests have shared after the last one of their folder, and after one that has failed."""
    yield
    if KEPT.workspace is not None and (KEPT.spoiled or nextitem is None or nextitem.path.parent != item.path.parent):
        KEPT.close()


@pytest.fixture
def workspace(
    request: pytest.FixtureRequest, qapp: QApplication, compiled_loops: None, kept_window: Kept
) -> Iterator[Workspace]:
    """A session with its features, without an image unless it is shared."""
    node = request.node
    shared = bool(node.get_closest_marker("shared_window")) and not node.get_closest_marker("own_window")
    if not shared:
        kept_window.close()
    threads = set(threading.enumerate())
    made = kept_window.workspace or Workspace()
    made.session.set_pace(None)
    if shared and kept_window.workspace is None:
        kept_window.workspace, kept_window.threads = made, threads
    yield made
    if not shared:
        close_workspace(made)


@pytest.fixture
def session(workspace: Workspace) -> Session:
    """A session without an image."""
    return workspace.session


@pytest.fixture
def window(qtbot: QtBot, workspace: Workspace, image_file: Path, kept_window: Kept) -> Iterator[MainWindow]:
    """A window on the disc, with nothing drawn."""
    session, shared = workspace.session, kept_window.workspace is workspace
    if not shared:
        kept_window.close()
    made = kept_window.window or new_window(qtbot, workspace)
    if kept_window.window is not None:
        begin_anew(made, kept_window.views)
    elif shared:
        kept_window.keep(made)
    wait_until(qtbot, made.isActiveWindow)  # which the keys of actions need
    session.open_file(image_file)
    wait_until(qtbot, lambda: is_open(session, image_file))
    yield made
    if not shared:
        close_window(made)
    elif not made.isVisible():  # the test has closed it
        kept_window.close()
    for dialog in made.findChildren(QDialog) if kept_window.window is not None else ():
        dialog.close()


@pytest.fixture
def ready(window: MainWindow) -> MainWindow:
    """A window with a circle across the boundary of the disc."""
    window.session.edit("draw circle", lambda document: edits.add_shape(document, Circle((32.0, 32.0), 10.0)))
    return window


@pytest.fixture
def rested(ready: MainWindow, hand: Hand) -> MainWindow:
    """A window with a finished run."""
    run_to_the_end(ready, hand)
    return ready


@pytest.fixture
def cases(window: MainWindow, request: pytest.FixtureRequest) -> Callable[[Iterable[T]], Iterator[T]]:
    """Goes through the cases of a law in one window; each begins with the first drawing and nothing to undo or read.

    To make a window takes longer than most cases do.
    """
    first = window.session.document

    def each(values: Iterable[T]) -> Iterator[T]:
        for value in values:
            request.node.add_report_section("call", "case", f"{value!r}\n")
            window.session.load_document(first)
            window.canvas_area.messages.clear()
            yield value

    return each


@pytest.fixture
def record(window: MainWindow) -> Callable[[str], list[Any]]:
    """Records each new value of the parts of the scene, by name."""
    session = window.session

    def recorded(part: str) -> list[Any]:
        known, values = [getattr(session.scene, part)], []

        def look() -> None:
            value = getattr(session.scene, part)
            if value is not known[0]:
                known[0] = value
                values.append(value)

        session.store.scene_changed.connect(look)
        return values

    return recorded


@pytest.fixture
def hand(qtbot: QtBot, window: MainWindow) -> Hand:
    """Mouse and key events on the window; the pointer begins in its corner, as Qt reports no move to where it is."""
    qtbot.mouseMove(window, QPoint(1, 1))
    return Hand(qtbot, window)
