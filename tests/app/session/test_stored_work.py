"""What is stored and cannot be read is never deleted or replaced, and the window says where it is."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from cpm_app.session.storage import recovery
from cpm_app.session.storage.recovery import JOURNAL_KEY, find_leftovers, journals_folder
from cpm_app.views.features.files import RecoveryFeature

from cpm_core.formats.sessions.session_file import ImageFile, SessionFile, save_session
from cpm_core.shapes import Circle
from tests.app.acting import draw_circle
from tests.app.reading import shown_message
from tests.app.session.test_recovery import journal, leave, offer, press, written

PLAIN = {"cpm-session": 3, "image": {"path": "a.png"}, JOURNAL_KEY: {"name": "a"}}


UNREADABLE = {
    "empty": b"",
    "cut off": b'{"cpm-session": 3, "image": ',
    "not text": b"\xff\xfe\x00",
    "newer": json.dumps({**PLAIN, "cpm-session": 7}).encode(),
    "unknown shape": json.dumps({**PLAIN, "shapes": [{"kind": "torus"}]}).encode(),
    "no journal": json.dumps({"cpm-session": 3, "image": {"path": "a.png"}}).encode(),
    "no image": json.dumps({"cpm-session": 3, JOURNAL_KEY: {"name": "a"}}).encode(),
}


@pytest.mark.parametrize("content", UNREADABLE.values(), ids=UNREADABLE)
def test_a_journal_that_cannot_be_read_is_set_aside_and_the_window_says_where(window, content) -> None:
    journals_folder().mkdir(parents=True)
    path = journals_folder() / "x.cpm"
    path.write_bytes(content)
    assert offer(window) is None
    kept = path.with_suffix(".unreadable")
    assert kept.read_bytes() == content
    assert str(kept) in shown_message(window)
    assert not path.exists()
    assert find_leftovers(journals_folder())[1] == []


def test_one_failing_read_leaves_a_journal_where_it_is_for_the_next_start(window, image_file, monkeypatch) -> None:
    left = leave(journals_folder(), image_file)
    whole = Path.open

    def refuse(path: Path, *how, **more):
        if path == left:
            raise OSError(5, "Input/output error")
        return whole(path, *how, **more)

    with monkeypatch.context() as broken:
        broken.setattr(Path, "open", refuse)
        assert offer(window) is None
    assert "Input/output error" in shown_message(window)
    assert str(left) in shown_message(window)
    assert "left.cpm" in offer(window).text()


def test_work_that_could_not_be_restored_is_not_deleted_by_opening_a_session(
    window, hand, image_file, tmp_path
) -> None:
    left = leave(journals_folder(), tmp_path / "gone.png")
    press(offer(window), "Restore")
    hand.wait(lambda: "gone.png" in shown_message(window))
    save_session(SessionFile(ImageFile(str(image_file)), (Circle((9.0, 9.0), 4.0),)), tmp_path / "other.cpm")
    window.session.open_file(tmp_path / "other.cpm")
    hand.wait(lambda: len(window.session.document.shapes) == 1)
    assert left.exists()


def test_restored_work_stays_in_its_journal_until_another_one_holds_it(window, hand, image_file, monkeypatch) -> None:
    left = leave(journals_folder(), image_file, "work.cpm")

    def refuse(*_: object) -> None:
        raise ValueError("No space left on device.")

    monkeypatch.setattr(recovery, "save_session", refuse)
    press(offer(window), "Restore")
    hand.wait(lambda: len(window.session.document.shapes) == 2 and window.session.idle)
    assert left.exists()


def test_work_that_no_journal_can_take_is_said_once_and_taken_back(window, hand, monkeypatch) -> None:
    def refuse(*_: object) -> None:
        raise ValueError("No space left on device.")

    with monkeypatch.context() as full:
        full.setattr(recovery, "save_session", refuse)
        draw_circle(window)
        journal(window).write()
        hand.wait(lambda: "No space left on device." in shown_message(window))
        assert shown_message(window).startswith("Unsaved work cannot be protected")
        window.canvas_area.messages.dismiss_message()
        journal(window).write()
        journal(window).flush()
    written(window)
    hand.wait(lambda: shown_message(window) == "")


def test_a_folder_that_takes_no_journal_is_said(window, hand) -> None:
    journals_folder().parent.mkdir(parents=True, exist_ok=True)
    journals_folder().write_text("a file in its place")
    draw_circle(window)
    journal(window).write()
    hand.wait(lambda: journals_folder().name in shown_message(window))
    assert window.get_feature(RecoveryFeature).close()
