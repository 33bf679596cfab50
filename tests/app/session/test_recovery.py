"""What was not saved when the program came to a bad end is offered again, once, and to one window only."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import tifffile
from cpm_app.session.storage.recovery import JOURNAL_KEY, find_leftovers, journals_folder
from cpm_app.views.features.files import OpenSaveFeature, RecoveryFeature
from cpm_app.views.features.volumes import PagesFeature
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMessageBox

from cpm_core.formats.sessions.session_file import ImageFile, SessionFile, load_session, save_session
from cpm_core.shapes import Circle
from tests.app.acting import draw_circle
from tests.app.conftest import disc


def leave(folder: Path, image: Path, name: str = "left.cpm", session: str = "") -> Path:
    """A journal as a process that has ended leaves it."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}-journal.cpm"
    shapes = (Circle((30.0, 30.0), 7.0), Circle((10.0, 10.0), 5.0))
    save_session(
        SessionFile(ImageFile(str(image)), shapes, extra={JOURNAL_KEY: {"session": session, "name": name}}), path
    )
    return path


def journal(window):
    return window.get_feature(RecoveryFeature).journal


def written(window) -> Path:
    """The journal of a window, once it has been written."""
    journal(window).write()
    journal(window).flush()
    return journal(window).path


def offer(window) -> QMessageBox | None:
    feature = window.get_feature(RecoveryFeature)
    feature.offer_recovery()
    return feature.box


def press(box: QMessageBox, text: str) -> None:
    next(button for button in box.buttons() if button.text().replace("&", "").startswith(text)).click()


def test_a_change_is_in_the_journal_a_moment_later_by_itself(window, hand) -> None:
    journal(window)._timer.setInterval(20)
    draw_circle(window)
    hand.wait(journal(window).path.exists)
    journal(window).flush()
    assert load_session(journal(window).path).shapes == window.session.document.shapes


def test_the_journal_goes_when_the_work_is_saved_taken_back_or_closed(window, hand, tmp_path) -> None:
    draw_circle(window)
    assert written(window).exists()
    window.session.undo()
    assert not written(window).exists()
    window.session.redo()
    assert written(window).exists()
    window.get_feature(OpenSaveFeature).document_file.save(tmp_path / "a.cpm")
    hand.wait(lambda: not window.get_feature(OpenSaveFeature).document_file.unsaved)
    assert not written(window).exists()
    draw_circle(window, 40.0)
    assert written(window).exists()
    window.close()
    assert list(journals_folder().iterdir()) == []


def test_the_question_counts_the_work_on_all_pages_of_a_stack(window, image_file) -> None:
    path = leave(journals_folder(), image_file)
    plain = json.loads(path.read_text("utf-8"))
    page = {"page": 2, "given": False, "session": {**plain, "shapes": plain["shapes"][:1]}}
    path.write_text(json.dumps({**plain, "pages": {"sessions": [page, {"page": 3}]}}), "utf-8")
    box = offer(window)
    assert "Objects: 0, shapes: 3" in box.informativeText()
    press(box, "Discard")


def test_the_question_counts_no_starts_that_pages_were_given(window, hand, tmp_path) -> None:
    stack = tmp_path / "cells.tif"
    tifffile.imwrite(stack, np.stack([disc(9.0)] * 3).astype(np.uint8), imagej=True, metadata={"axes": "TYX"})
    window.open_image(str(stack))
    hand.wait(lambda: window.session.document.image.name == "cells.tif" and window.session.idle)
    hand.drag((32.0, 32.0), (32.0, 36.0))
    pages = window.workspace.pages
    hand.qtbot.mouseClick(window.get_feature(PagesFeature).bar.run, Qt.MouseButton.LeftButton)
    hand.wait(lambda: not pages.running and window.session.idle)
    hand.key(Qt.Key.Key_PageDown)
    hand.wait(lambda: pages.number == 2 and window.session.idle)
    left = written(window)
    assert sum(len(document.starts) for document in pages.documents.values()) > 1
    copy = journals_folder() / f"copy-{left.name}"
    copy.write_bytes(left.read_bytes())  # as if another process had left it
    box = offer(window)
    assert "Objects: 0, shapes: 1" in box.informativeText()
    press(box, "Discard")


def test_nothing_is_written_where_nothing_would_be_lost(window) -> None:
    assert not written(window).exists()
    assert not journals_folder().exists()


def test_the_journal_of_an_open_window_is_not_offered(window) -> None:
    draw_circle(window)
    assert written(window).exists()
    assert find_leftovers(journals_folder())[0] == []
    assert offer(window) is None


def test_what_was_left_is_restored_with_its_file_and_counts_as_unsaved(window, hand, image_file, tmp_path) -> None:
    session_file = tmp_path / "work.cpm"
    left = leave(journals_folder(), image_file, "work.cpm", str(session_file))
    box = offer(window)
    assert "work.cpm" in box.text()
    assert "2" in box.informativeText()
    assert str(session_file) in box.informativeText()
    press(box, "Restore")
    hand.wait(lambda: len(window.session.document.shapes) == 2 and window.session.idle)
    document_file = window.get_feature(OpenSaveFeature).document_file
    assert document_file.path == session_file
    assert document_file.unsaved
    assert "restored" in window.canvas_area.messages.text
    assert not left.exists()
    # restored work is in a journal again
    assert load_session(journal(window).path).shapes == window.session.document.shapes
    assert JOURNAL_KEY not in document_file.content.extra
    document_file.save(session_file)
    hand.wait(lambda: not document_file.unsaved)
    assert JOURNAL_KEY not in load_session(session_file).extra


def test_what_is_discarded_is_gone_and_the_next_is_offered(window, image_file) -> None:
    older = leave(journals_folder(), image_file, "older.cpm")
    newer = leave(journals_folder(), image_file, "newer.cpm")
    os.utime(older, (1e9, 1e9))
    box = offer(window)
    assert "newer.cpm" in box.text()
    press(box, "Discard")
    assert not newer.exists()
    box = window.get_feature(RecoveryFeature).box
    assert "older.cpm" in box.text()
    press(box, "Ask me later")
    assert older.exists()


def test_what_is_left_for_later_is_offered_again_and_meanwhile_to_no_other_window(window, image_file) -> None:
    left = leave(journals_folder(), image_file)
    box = offer(window)
    assert find_leftovers(journals_folder())[0] == []
    press(box, "Ask me later")
    window.close()
    (again,) = find_leftovers(journals_folder())[0]
    assert again.journal == left
    again.keep_for_later()


def test_a_journal_of_a_missing_image_is_reported_and_stays(window, hand, tmp_path) -> None:
    left = leave(journals_folder(), tmp_path / "gone.png")
    press(offer(window), "Restore")
    hand.wait(lambda: "gone.png" in window.canvas_area.messages.text)
    assert left.exists()


def test_a_second_answer_to_the_question_about_unsaved_work_does_nothing(window, hand, image_file) -> None:
    leave(journals_folder(), image_file)
    box = offer(window)
    press(box, "Restore")
    press(box, "Restore")
    hand.wait(lambda: len(window.session.document.shapes) == 2)
