"""Whatever fails on any thread is said once, in the message line, while the run and its last contours stay."""

from __future__ import annotations

import sys
import threading

import pytest
from cpm_app.model.export import ExportFile, ExportOrder
from cpm_app.session.exchange.messages import Reconstruction
from cpm_app.session.features.background import LatestOnlyWorker
from cpm_app.session.worker import prepared_methods
from cpm_app.views.window.python_hooks import UnexpectedErrors
from PySide6.QtCore import Qt

from cpm_core.segmentation.engine import Engine
from tests.app.reading import shown_message

pytestmark = pytest.mark.shared_window

KEY = Qt.Key


def raising(error: Exception):
    def fail(*_: object, **__: object) -> None:
        raise error

    return fail


BROKEN = [
    (Engine, "result", ValueError("the crust has no triangles")),
    (Reconstruction, "from_result", RuntimeError("measuring")),
    (Engine, "result", MemoryError()),
]


@pytest.mark.parametrize(("owner", "name", "error"), BROKEN)
def test_trouble_with_contours_is_said_while_the_run_goes_on_with_the_last_ones(
    ready, hand, monkeypatch, owner, name, error
) -> None:
    session = ready.session
    hand.key(KEY.Key_Period)
    hand.wait(lambda: bool(session.scene.contours) and session.idle)
    before = session.scene.contours
    with monkeypatch.context() as broken:
        broken.setattr(owner, name, raising(error))
        hand.key(KEY.Key_Period)
        hand.wait(lambda: bool(shown_message(ready)))
        assert ready.canvas_area.messages.is_error
        assert (str(error) or "memory").casefold() in shown_message(ready).casefold()
        assert shown_message(ready).endswith("The contours that are shown are those of an earlier step.")
        assert session.scene.contours is before
        hand.key(KEY.Key_Escape)
        hand.key(KEY.Key_Period)
        hand.wait(lambda: session.status.step == 3 and session.idle)
        assert shown_message(ready) == "", "what has been dismissed is not said again for each step"
    hand.key(KEY.Key_Period)
    hand.wait(lambda: session.scene.contours is not before)


def test_contours_of_an_earlier_step_are_not_exported_as_those_of_the_last_one(
    ready, hand, monkeypatch, tmp_path
) -> None:
    hand.key(KEY.Key_Period)
    hand.wait(lambda: bool(ready.session.scene.contours) and ready.session.idle)
    monkeypatch.setattr(Engine, "result", raising(ValueError("No triangles.")))
    hand.key(KEY.Key_Period)
    hand.wait(lambda: bool(shown_message(ready)))
    ready.session.export_files(ExportOrder((ExportFile(tmp_path / "a.svg", "contours", ".svg"),)))
    hand.wait(lambda: ready.session.idle)
    assert "No triangles." in shown_message(ready)
    assert not (tmp_path / "a.svg").exists()


def test_a_run_starts_and_goes_on_where_an_overlay_fails(ready, hand, monkeypatch) -> None:
    monkeypatch.setattr(prepared_methods, "shade_potential", raising(MemoryError()))
    ready.session.set_overlay_enabled("potential", True)
    hand.wait(lambda: "memory" in shown_message(ready))
    hand.key(KEY.Key_Period)
    hand.wait(lambda: ready.session.status.step == 1)
    ready.session.set_overlay_enabled("potential", False)
    ready.session.set_overlay_enabled("edge_map", True)
    hand.wait(lambda: "edge_map" in ready.session.scene.overlays)
    assert shown_message(ready) == ""


def test_what_background_work_fails_with_is_said_once_and_taken_back(window, hand) -> None:
    latest, results = LatestOnlyWorker(window.session, "test", "measuring"), []
    latest.submit(raising(ZeroDivisionError("by zero")), results.append)
    hand.wait(lambda: shown_message(window) == "An unexpected error occurred while measuring: by zero.")
    window.canvas_area.messages.dismiss_message()
    latest.submit(raising(ZeroDivisionError("by zero")), results.append)
    hand.wait(lambda: latest.idle)
    assert shown_message(window) == ""
    latest.submit(lambda: "done", results.append)
    hand.wait(lambda: results == ["done"])
    assert shown_message(window) == ""
    latest.close()


def test_an_error_that_nothing_expects_is_said_from_every_thread(window, hand, monkeypatch, caplog) -> None:
    monkeypatch.setattr(sys, "excepthook", sys.excepthook)
    monkeypatch.setattr(threading, "excepthook", threading.excepthook)
    errors = UnexpectedErrors(window.session)
    sys.excepthook(KeyError, KeyError("slot"), None)
    assert "slot" in shown_message(window)
    thread = threading.Thread(target=raising(RuntimeError("thread")))
    thread.start()
    thread.join()
    hand.wait(lambda: "thread" in shown_message(window))
    assert "an error that nothing expects" in caplog.text
    errors.restore_hooks()
    assert sys.excepthook != errors._on_exception
