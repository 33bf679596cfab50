"""Work is saved whole and comes back whole; nothing that is not saved is lost without a question."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from cpm_app.model.document import edits
from cpm_app.model.document.objects import accept_objects
from cpm_app.session.storage import session_file
from cpm_app.views.features.files import OpenSaveFeature
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import QMimeData, QPoint, Qt, QTimer, QUrl
from PySide6.QtGui import QDropEvent
from PySide6.QtWidgets import QApplication, QFileDialog, QMenu, QMessageBox

from cpm_core.formats.sessions.session_file import SessionFile, load_session
from cpm_core.objects.segmented import SegmentedObject
from cpm_core.shapes import PolygonRegion
from tests.app.acting import draw_circle
from tests.app.reading import document_file, treat_as_saved

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
CTRL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier


@pytest.fixture
def saved_to(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """Path that the file dialog returns for a session."""
    path = tmp_path / "work.cpm"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(path.with_suffix("")), ""))
    return path


def drop(window: MainWindow, *paths: Path) -> None:
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(path)) for path in paths])
    button, none = Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier
    window.dropEvent(QDropEvent(QPoint(50, 50), Qt.DropAction.CopyAction, data, button, none))


@contextmanager
def answering(text: str) -> Iterator[None]:
    """Click a button of the question that the block asks, now or a little later; leave no click for other questions."""
    answered = []

    def look() -> None:
        box = QApplication.activeModalWidget()
        if isinstance(box, QMessageBox):
            timer.stop()
            answered.append(text)
            next(button for button in box.buttons() if button.text().replace("&", "") == text).click()

    timer = QTimer(interval=20)
    timer.timeout.connect(look)
    timer.start()
    try:
        yield
        deadline = time.monotonic() + 20.0
        while not answered and time.monotonic() < deadline:
            QApplication.processEvents()
    finally:
        timer.stop()
    assert answered == [text]


def test_what_is_saved_by_a_key_is_restored_with_objects_and_view(ready, hand, saved_to, tmp_path) -> None:
    session, canvas = ready.session, hand.canvas
    session.edit(
        "draw region", lambda document: edits.add_shape(document, PolygonRegion(((1.0, 1.0), (1.0, 60.0), (60.0, 9.0))))
    )
    session.edit("damping", lambda document: edits.set_parameter(document, "beta", 0.5))
    vessel = SegmentedObject(1, (), name="vessel", line=((3.0, 3.0), (9.0, 50.0)))
    session.edit("accept", lambda document: accept_objects(document, (vessel,)))
    canvas.zoom_by(2.0)
    canvas.pan_by(30.0, -20.0)
    canvas.layers["image"].set_opacity(0.5)
    canvas.layers["edge_map"].set_shown(True)
    seen = canvas.view.viewRect()
    hand.key(KEY.Key_S, CTRL)
    hand.wait(saved_to.exists)
    hand.wait(lambda: not document_file(ready).unsaved)
    document = session.document
    np.save(tmp_path / "other.npy", np.eye(30))
    ready.get_feature(OpenSaveFeature).open_files([tmp_path / "other.npy"])
    hand.wait(lambda: session.document.image.name == "other.npy")
    canvas.layers["edge_map"].set_shown(False)
    canvas.layers["image"].set_opacity(1.0)
    drop(ready, saved_to)
    hand.wait(lambda: session.document.image.name == "disc.npy" and session.idle)
    assert session.document == document
    assert not document_file(ready).unsaved
    assert session.situation.undo_name == ""
    assert canvas.layers["image"].opacity == 0.5
    assert canvas.layers["edge_map"].shown
    again = canvas.view.viewRect()
    for before, after in zip(seen.getRect(), again.getRect(), strict=True):
        assert after == pytest.approx(before, abs=0.5)


def test_looking_is_not_work_that_has_to_be_saved(window, hand) -> None:
    hand.canvas.zoom_by(3.0)
    hand.canvas.layers["image"].set_opacity(0.3)
    assert not document_file(window).unsaved


def test_saving_again_asks_for_no_file_and_saving_as_keeps_to_the_new_one(
    ready, hand, saved_to, tmp_path, monkeypatch
) -> None:
    hand.key(KEY.Key_S, CTRL)
    hand.wait(lambda: not document_file(ready).unsaved)
    second = tmp_path / "second.cpm"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: pytest.fail("asked"))
    draw_circle(ready)
    hand.key(KEY.Key_S, CTRL)
    hand.wait(lambda: not document_file(ready).unsaved)
    assert len(load_session(saved_to).shapes) == 2
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(second), ""))
    hand.key(KEY.Key_S, CTRL | SHIFT)
    hand.wait(second.exists)
    hand.wait(lambda: document_file(ready).path == second)
    draw_circle(ready)
    hand.key(KEY.Key_S, CTRL)
    hand.wait(lambda: not document_file(ready).unsaved)
    assert len(load_session(second).shapes) == 3
    assert len(load_session(saved_to).shapes) == 2


def test_each_save_writes_what_was_there_when_it_was_ordered(ready, hand, tmp_path) -> None:
    """Also when the one before is still being written, and to several files."""
    paths = [tmp_path / name for name in ("one.cpm", "two.cpm", "three.cpm")]
    shapes = []
    for path in paths:
        document_file(ready).save(path)
        shapes.append(ready.session.document.shapes)
        draw_circle(ready, 10.0 + 10.0 * len(shapes))
    hand.wait(lambda: ready.session.idle and all(path.exists() for path in paths))
    assert [load_session(path).shapes for path in paths] == shapes
    assert document_file(ready).path == paths[-1]
    assert document_file(ready).unsaved


def test_what_is_saved_while_another_image_opens_is_not_the_file_of_that_image(
    ready, hand, tmp_path, image_file
) -> None:
    shapes, path = ready.session.document.shapes, tmp_path / "work.cpm"
    ready.session.open_file(image_file)
    document_file(ready).save(path)
    document_file(ready).save(path)
    hand.wait(lambda: ready.session.document.shapes == () and ready.session.idle)
    hand.wait(lambda: path.exists() and ready.session.idle)
    assert load_session(path).shapes == shapes
    assert document_file(ready).path is None


def test_a_failed_save_is_reported_and_the_work_stays_unsaved(ready, hand, tmp_path) -> None:
    document_file(ready).save(tmp_path / "no folder" / "a.cpm")
    hand.wait(lambda: "no folder" in ready.canvas_area.messages.text)
    assert document_file(ready).unsaved


def test_what_another_version_has_added_survives_saving(ready, hand, saved_to) -> None:
    document_file(ready).save(saved_to)
    hand.wait(lambda: not document_file(ready).unsaved)
    plain = json.loads(saved_to.read_text())
    saved_to.write_text(json.dumps({**plain, "weather": 3, "mode": "shape"}))
    drop(ready, saved_to)
    hand.wait(lambda: ready.session.idle)
    draw_circle(ready)
    hand.key(KEY.Key_S, CTRL)
    hand.wait(lambda: not document_file(ready).unsaved)
    again = json.loads(saved_to.read_text())
    assert (again["weather"], again["mode"], len(again["shapes"])) == (3, "shape", 2)


def test_an_image_that_has_changed_since_is_opened_with_a_warning(ready, hand, saved_to, image_file) -> None:
    document_file(ready).save(saved_to)
    hand.wait(lambda: not document_file(ready).unsaved and ready.session.idle)
    ready.canvas_area.messages.clear()
    np.save(image_file, np.load(image_file).T[:, ::-1] + 1.0)
    drop(ready, saved_to)
    hand.wait(lambda: "has changed since" in ready.canvas_area.messages.text)
    assert len(ready.session.document.shapes) == 1


# The question


def test_cancel_keeps_the_window_and_the_image(ready, hand, asked, tmp_path) -> None:
    np.save(tmp_path / "other.npy", np.eye(30))
    with answering("Keep editing"):
        drop(ready, tmp_path / "other.npy")
    ready.activateWindow()
    hand.wait(ready.isActiveWindow)
    with answering("Keep editing"):
        hand.key(KEY.Key_Q, CTRL)
    assert ready.isVisible()
    hand.wait(lambda: ready.session.idle)
    assert ready.session.document.image.name == "disc.npy"
    treat_as_saved(ready)


def test_discard_closes_the_window_without_saving(ready, asked) -> None:
    with answering("Discard changes"):
        assert ready.close()


def test_save_writes_the_file_before_the_window_closes(ready, asked, saved_to) -> None:
    with answering("Save"):
        assert ready.close()
    assert load_session(saved_to).shapes == ready.session.document.shapes


@pytest.mark.parametrize("already", ["ordered", "being written", "ordered twice"])
def test_closing_overtakes_no_save_and_does_not_ask_again(ready, asked, tmp_path, monkeypatch, already) -> None:
    write, path = session_file.save_session, tmp_path / "work.cpm"
    began = threading.Event()

    def slowly(file: SessionFile, to: Path) -> None:
        began.set()
        write(file, to)

    monkeypatch.setattr(session_file, "save_session", slowly)
    document_file(ready).save(path)
    if already != "ordered":
        while not began.is_set():
            QApplication.processEvents()
    if already == "ordered twice":
        draw_circle(ready)
        document_file(ready).save(path)
    expected = ready.session.document.shapes
    ready.close()
    assert not ready.isVisible()
    assert load_session(path).shapes == expected


def test_a_save_that_fails_or_has_no_path_keeps_the_window(ready, hand, asked, monkeypatch, tmp_path) -> None:
    answers = iter([("", ""), (str(tmp_path / "none" / "a.cpm"), "")])
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: next(answers))
    for _ in range(2):
        with answering("Save"):
            assert not ready.close()
        assert ready.isVisible()
    hand.wait(lambda: "none" in ready.canvas_area.messages.text)
    treat_as_saved(ready)


def test_there_is_no_question_where_nothing_would_be_lost(window, asked, hand, saved_to) -> None:
    draw_circle(window)
    document_file(window).save(saved_to)
    hand.wait(lambda: not document_file(window).unsaved)
    assert window.close()


# Dropped files and recent files


def recent(window: MainWindow) -> list[tuple[str, bool]]:
    menu = QMenu()
    window.get_feature(OpenSaveFeature).recent.fill_menu(menu)
    return [(action.text().partition(" ")[2], action.isEnabled()) for action in menu.actions() if "." in action.text()]


def test_files_that_were_open_are_listed_newest_first_and_gray_when_gone(window, hand, tmp_path) -> None:
    for name in ("a", "b"):
        np.save(tmp_path / f"{name}.npy", np.eye(20))
        window.open_image(str(tmp_path / f"{name}.npy"))
        hand.wait(lambda name=name: window.session.document.image.name == f"{name}.npy")
    (tmp_path / "a.npy").unlink()
    assert recent(window)[:3] == [("b.npy", True), ("a.npy", False), ("disc.npy", True)]
    menu = QMenu()
    window.get_feature(OpenSaveFeature).recent.fill_menu(menu)
    next(action for action in menu.actions() if "disc" in action.text()).trigger()
    hand.wait(lambda: window.session.document.image.name == "disc.npy")
    menu.actions()[-1].trigger()
    assert recent(window) == []


# Export, clipboard


def found(window: MainWindow, hand) -> None:
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: window.session.idle)


def test_contours_are_copied_in_all_formats_at_once_and_as_a_table(ready, hand) -> None:
    found(ready, hand)
    clipboard = QApplication.clipboard()
    clipboard.setText("nothing yet")
    hand.key(KEY.Key_C, CTRL)
    hand.wait(lambda: clipboard.mimeData().hasFormat("image/svg+xml"))
    for kind, begins in (("image/svg+xml", "<"), ("text/csv", "contour"), ("application/geo+json", "{")):
        assert bytes(clipboard.mimeData().data(kind).data()).decode().startswith(begins)
    assert clipboard.text().startswith("contour,label,")


def test_the_view_is_copied_as_it_is_seen(ready, hand) -> None:
    QApplication.clipboard().clear()
    hand.key(KEY.Key_P, CTRL | SHIFT)
    picture = QApplication.clipboard().image()
    assert picture.size() == hand.canvas.grab().size()
    middle = picture.pixelColor(hand.at(32.0, 32.0) * picture.devicePixelRatio())
    corner = picture.pixelColor(hand.at(3.0, 3.0) * picture.devicePixelRatio())
    assert middle.value() > corner.value()
