"""What was not saved when the program came to a bad end is offered again, once, and to one window only."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QLabel, QMessageBox

from app.model.document import edits
from app.session.storage.recovery import KEY, folder_of_journals, left_behind, lock_of
from app.views.features.files import OpenSaveFeature, RecoveryFeature
from app.views.window.dialogs import Button, Question
from cpm_core.formats.sessions.session_file import ImageFile, SessionFile, load_session, save_session
from cpm_core.shapes import Circle

ROOT = Path(__file__).parents[3]


def leave(folder: Path, image: Path, name: str = "left.cpm", session: str = "") -> Path:
    """A journal as a process that has ended leaves it."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}-journal.cpm"
    shapes = (Circle((30.0, 30.0), 7.0), Circle((10.0, 10.0), 5.0))
    save_session(SessionFile(ImageFile(str(image)), shapes, extra={KEY: {"session": session, "name": name}}), path)
    return path


def draw(window, row: float = 20.0) -> None:
    window.session.edit("draw circle", lambda document: edits.add_shape(document, Circle((row, 30.0), 9.0)))


def journal(window):
    return window.feature(RecoveryFeature).journal


def written(window) -> Path:
    """The journal of a window, once it has been written."""
    journal(window).write()
    journal(window).flush()
    return journal(window).path


def offer(window) -> QMessageBox | None:
    feature = window.feature(RecoveryFeature)
    feature.offer()
    return feature.box


def press(box: QMessageBox, text: str) -> None:
    next(button for button in box.buttons() if button.text().replace("&", "").startswith(text)).click()


@pytest.mark.parametrize("length", [1, 30, 80])
def test_the_whole_name_of_the_work_is_in_the_question(window, length) -> None:
    text = "Restore “" + "long name " * length + "”?"
    box = Question(window, "Restore", text, "More.", (Button("later", "&Later", "cancel"),))
    box.open()
    label = box.findChild(QLabel, "qt_msgbox_label")
    needed = label.fontMetrics().boundingRect(label.rect(), Qt.TextFlag.TextWordWrap, text)
    assert label.wordWrap() or label.fontMetrics().horizontalAdvance(text) <= label.width()
    assert needed.height() <= label.height()
    box.close()


def test_a_change_is_in_the_journal_a_moment_later_by_itself(window, hand) -> None:
    journal(window)._timer.setInterval(20)
    draw(window)
    hand.wait(journal(window).path.exists)
    journal(window).flush()
    assert load_session(journal(window).path).shapes == window.session.document.shapes


def test_the_journal_goes_when_the_work_is_saved_taken_back_or_closed(window, hand, tmp_path) -> None:
    draw(window)
    assert written(window).exists()
    window.session.undo()
    assert not written(window).exists()
    window.session.redo()
    assert written(window).exists()
    window.feature(OpenSaveFeature).document_file.save(tmp_path / "a.cpm")
    hand.wait(lambda: not window.feature(OpenSaveFeature).document_file.unsaved)
    assert not written(window).exists()
    draw(window, 40.0)
    assert written(window).exists()
    window.close()
    assert list(folder_of_journals().iterdir()) == []


def test_nothing_is_written_where_nothing_would_be_lost(window) -> None:
    assert not written(window).exists()
    assert not folder_of_journals().exists()


def test_the_journal_of_an_open_window_is_not_offered(window) -> None:
    draw(window)
    assert written(window).exists()
    assert left_behind(folder_of_journals()).leftovers == []
    assert offer(window) is None


def test_what_was_left_is_restored_with_its_file_and_counts_as_unsaved(window, hand, image_file, tmp_path) -> None:
    session_file = tmp_path / "work.cpm"
    left = leave(folder_of_journals(), image_file, "work.cpm", str(session_file))
    box = offer(window)
    assert "work.cpm" in box.text()
    assert "2" in box.informativeText()
    assert str(session_file) in box.informativeText()
    press(box, "Restore")
    hand.wait(lambda: len(window.session.document.shapes) == 2 and window.session.idle)
    document_file = window.feature(OpenSaveFeature).document_file
    assert document_file.path == session_file
    assert document_file.unsaved
    assert "restored" in window.canvas_area.messages.text
    assert not left.exists()
    # restored work is in a journal again
    assert load_session(journal(window).path).shapes == window.session.document.shapes
    assert KEY not in document_file.file.extra
    document_file.save(session_file)
    hand.wait(lambda: not document_file.unsaved)
    assert KEY not in load_session(session_file).extra


def test_what_is_discarded_is_gone_and_the_next_is_offered(window, image_file) -> None:
    older = leave(folder_of_journals(), image_file, "older.cpm")
    newer = leave(folder_of_journals(), image_file, "newer.cpm")
    os.utime(older, (1e9, 1e9))
    box = offer(window)
    assert "newer.cpm" in box.text()
    press(box, "Discard")
    assert not newer.exists()
    box = window.feature(RecoveryFeature).box
    assert "older.cpm" in box.text()
    press(box, "Ask me later")
    assert older.exists()


def test_what_is_left_for_later_is_offered_again_and_meanwhile_to_no_other_window(window, image_file) -> None:
    left = leave(folder_of_journals(), image_file)
    box = offer(window)
    assert left_behind(folder_of_journals()).leftovers == []
    press(box, "Ask me later")
    window.close()
    (again,) = left_behind(folder_of_journals()).leftovers
    assert again.journal == left
    again.keep()


def test_a_journal_of_a_missing_image_is_reported_and_stays(window, hand, tmp_path) -> None:
    left = leave(folder_of_journals(), tmp_path / "gone.png")
    press(offer(window), "Restore")
    hand.wait(lambda: "gone.png" in window.canvas_area.messages.text)
    assert left.exists()


PROGRAM = """
import sys
from pathlib import Path
from PySide6.QtCore import QSettings, QTimer
from app.model.document import edits
from app.views.application import make_application, open_window
from cpm_core.shapes import Circle
from app.views.features.files import RecoveryFeature
from app.views.window.dialogs import Button, Question

QSettings.setPath(QSettings.Format.IniFormat, QSettings.Scope.UserScope, sys.argv[1])
application = make_application()
window = open_window(sys.argv[2])
journal = window.feature(RecoveryFeature).journal
journal._timer.setInterval(50)

def work():
    if window.session.document.image is None:
        QTimer.singleShot(20, work)
        return
    window.canvas_area.canvas.layers["image"].set_opacity(0.25)
    for radius in (5.0, 6.0, 7.0):
        circle = Circle((30.0, 31.0), radius)
        window.session.edit("draw", lambda document, circle=circle: edits.add_shape(document, circle))

QTimer.singleShot(20, work)
application.exec()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals are those of POSIX")
def test_a_process_that_is_killed_leaves_its_work_to_the_next_window(window, hand, image_file, tmp_path) -> None:
    np.save(tmp_path / "killed.npy", np.load(image_file))
    command = [sys.executable, "-c", PROGRAM, str(tmp_path / "preferences"), str(tmp_path / "killed.npy")]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "QT_QPA_PLATFORM": "offscreen"}
    with subprocess.Popen(command, env=environment, cwd=tmp_path) as process:
        end = time.monotonic() + 60
        while not _journals_with_three_shapes():
            assert time.monotonic() < end
            assert process.poll() is None
            time.sleep(0.05)
        assert left_behind(folder_of_journals()).leftovers == []
        process.send_signal(signal.SIGKILL)
    press(offer(window), "Restore")
    hand.wait(lambda: window.session.document.image.name == "killed.npy")
    assert window.session.document.shapes == tuple(Circle((30.0, 31.0), radius) for radius in (5.0, 6.0, 7.0))
    assert hand.canvas.layers["image"].opacity == 0.25
    assert window.feature(OpenSaveFeature).document_file.unsaved


def _journals_with_three_shapes() -> bool:
    return any(len(load_session(path).shapes) == 3 for path in folder_of_journals().glob("*.cpm"))


def test_a_lock_is_free_as_soon_as_its_holder_has_ended(tmp_path) -> None:
    first, second = (lock_of(tmp_path / "a.cpm") for _ in range(2))
    assert first.tryLock(0)
    assert not second.tryLock(0)
    first.unlock()
    assert second.tryLock(0)
    second.unlock()


@pytest.mark.parametrize("answer", ["Ask me later", "Discard", ""])
def test_the_keyboard_belongs_to_the_window_when_the_question_is_answered(ready, hand, image_file, answer) -> None:
    """Without a window manager no other program gives the keyboard to the window."""
    leave(folder_of_journals(), image_file)
    box = offer(ready)
    hand.wait(box.isActiveWindow)
    if answer:
        press(box, answer)
    else:
        hand.qtbot.keyClick(box, Qt.Key.Key_Escape)
    hand.wait(lambda: QGuiApplication.focusWindow() is ready.windowHandle())
    assert ready.canvas_area.canvas.hasFocus()
    hand.qtbot.keyClick(QGuiApplication.focusWindow(), Qt.Key.Key_Space)
    hand.wait(lambda: ready.session.status.started)
