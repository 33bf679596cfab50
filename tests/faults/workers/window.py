"""The window while the work of its threads fails: it says so in a sentence, and the next attempt works."""

from __future__ import annotations

import logging
import random
import time
from collections.abc import Callable
from pathlib import Path

from cpm_app.model.document import edits
from cpm_app.model.export import ExportFile, ExportOrder
from cpm_app.views.features.files import OpenSaveFeature
from cpm_app.views.window.window import MainWindow

from cpm_core.shapes import Circle

from ..kills.windows import opened, until
from ..report import going_on
from .raising import Raising

_ERRORS: tuple[Callable[[], Exception], ...] = (
    MemoryError,
    lambda: RuntimeError("a defect"),
    lambda: OSError(5, "Input/output error"),
    lambda: ValueError("This cannot be."),
)


def trials(folder: Path, seconds: float, least: int, seed: int) -> tuple[int, list[str]]:
    """Let calls of the core fail while the window works; how many were tried, and what went wrong."""
    logging.disable()
    drawn, raising = random.Random(seed), Raising()
    window = opened(folder)
    window.session.edit("draw", lambda document: edits.add_shape(document, Circle((20.0, 20.0), 6.0)))
    raising.place()
    calls = {work: _counted(window, folder, work, raising) for work in _WORKS}
    end, count, failures = time.monotonic() + seconds, 0, []
    while going_on(end) or count < least:
        work = _WORKS[count % len(_WORKS)]
        number, error = drawn.randint(1, calls[work]), drawn.choice(_ERRORS)()
        count += 1
        try:
            _tried(window, folder, work, raising, number, error)
        except AssertionError as failure:
            failures.append(f"{work.__name__[1:]}, {type(error).__name__} at call {number} of {calls[work]}: {failure}")
    return count, failures


def _counted(window: MainWindow, folder: Path, work: Callable[[MainWindow, Path], bool], raising: Raising) -> int:
    """Number of calls of the core that a kind of work makes."""
    raising.arm(0, None)
    assert work(window, folder), f"{work.__name__} fails without a fault: {window.canvas_area.messages.text!r}"
    return raising.calls


def _tried(
    window: MainWindow,
    folder: Path,
    work: Callable[[MainWindow, Path], bool],
    raising: Raising,
    number: int,
    error: Exception,
) -> None:
    window.canvas_area.messages.clear()
    raising.arm(number, error)
    fine = work(window, folder)
    raising.arm(0, None)
    said = window.canvas_area.messages.text
    assert "Traceback" not in said
    assert "\n" not in said
    assert fine or said.endswith("."), f"it fails without a word, or with {said!r}"
    assert work(window, folder), f"the next time says {window.canvas_area.messages.text!r}"


def _step(window: MainWindow, _: Path) -> bool:
    """One step from the start, with its contours."""
    session = window.session
    session.reset()
    until(lambda: session.idle)
    session.step()
    until(lambda: session.idle)
    return session.status.step == 1 and session.scene.contours is not None


def _export(window: MainWindow, folder: Path) -> bool:
    target = folder / "a.svg"
    target.unlink(missing_ok=True)
    if window.session.status.step == 0:
        _step(window, folder)
    window.session.export(ExportOrder((ExportFile(target, "contours", target.suffix),)))
    until(lambda: window.session.idle)
    return target.exists()


def _open(window: MainWindow, folder: Path) -> bool:
    """Open the image again, with a start on it."""
    session, before = window.session, window.session.image_generation
    window.feature(OpenSaveFeature).document_file.forget()  # so that nobody is asked about unsaved work
    session.open(folder / "0.npy")
    until(lambda: not session.opening and not session.tasks.current and session.idle)
    if not session.document.shapes:
        session.edit("draw", lambda document: edits.add_shape(document, Circle((20.0, 20.0), 6.0)))
    return session.image_generation != before


_WORKS = (_step, _export, _open)
