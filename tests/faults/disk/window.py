"""The window on a disk that fails: it says so, keeps the work, and saves it when the disk is well again."""

from __future__ import annotations

import errno
import logging
import random
import time
from collections.abc import Callable
from pathlib import Path

from cpm_app.model.document import edits
from cpm_app.model.export import ExportFile, ExportOrder
from cpm_app.session.storage.recovery import Journal
from cpm_app.views.features.files import OpenSaveFeature, RecoveryFeature
from cpm_app.views.window.window import MainWindow

from cpm_core.formats.sessions.session_file import load_session
from cpm_core.shapes import Circle

from ..kills.windows import opened, until
from ..report import going_on
from .core import ERRORS, OLD
from .injection import Faults, can_fail, injected

_TARGETS = ("work.cpm", "a.svg")


def trials(folder: Path, seconds: float, every: int, seed: int) -> tuple[int, list[str]]:
    """Save, export and keep a journal while operations on files fail; how many were tried, and what went wrong."""
    logging.disable()
    drawn = random.Random(seed)
    window = opened(folder)
    (folder / "work").mkdir()
    circle = Circle((20.0, 20.0), 6.0)
    window.session.edit("draw", lambda document: edits.add_shape(document, circle))
    window.session.step()
    until(lambda: window.session.status.step > 0 and window.session.idle)
    end, count, failures = time.monotonic() + seconds, 0, []
    for work in (_save, _export, _journal):
        if not window.get_feature(OpenSaveFeature).document_file.unsaved:
            _change(window)
        with injected(Faults(folder)) as known:
            work(window, folder)
        assert known.operations, f"{work.__name__[1:]} touches no file"
        planned = [
            (number, error, lasting)
            for number, operation in enumerate(known.operations, start=1)
            for error in ERRORS
            if can_fail(operation, error)
            for lasting in (False, True)
        ]
        drawn.shuffle(planned)
        for number, error, lasting in planned[::every]:
            if not going_on(end):
                return count, failures
            count += 1
            try:
                _tried(window, folder, work, Faults(folder, number, error, lasting))
            except AssertionError as failure:
                where = (
                    f"{work.__name__[1:]}, {errno.errorcode[error]} at operation {number} of {len(known.operations)}"
                )
                failures.append(f"{where}{' and later' if lasting else ''}: {failure}")
    return count, failures


def _tried(window: MainWindow, folder: Path, work: Callable[[MainWindow, Path], Path], faults: Faults) -> None:
    window.canvas_area.messages.clear()
    _change(window)
    for name in _TARGETS:
        (folder / "work" / name).write_bytes(OLD)
    with injected(faults):
        target = work(window, folder)
    said = window.canvas_area.messages.text
    assert "unexpected" not in said.lower(), said
    document_file = window.get_feature(OpenSaveFeature).document_file
    if work is _journal:
        assert not target.exists() or load_session(target)
        kept = _shapes(work(window, folder)) if document_file.unsaved else 0
        assert kept in (0, len(window.session.document.shapes)), "the journal is not written later"
        return
    whole = target.read_bytes() != OLD
    _journal_of(window).flush()  # which is written meanwhile, and has drafts of its own until then
    assert not list(folder.rglob("*.part")) or faults.lasting, "a draft stays"
    for draft in folder.rglob("*.part"):
        draft.unlink()
    if not whole:
        assert said.endswith("."), f"it fails without a word, or with {said!r}"
        assert work is _export or document_file.unsaved, "it counts as saved"
    work(window, folder)
    assert target.read_bytes() != OLD, f"the next time says {window.canvas_area.messages.text!r}"
    if work is _save:
        assert _shapes(target) == len(window.session.document.shapes), "the next time saves something else"
        assert not document_file.unsaved


def _change(window: MainWindow) -> None:
    """Add a circle, or take it away again."""
    session = window.session
    if len(session.document.shapes) > 1:
        session.undo()
    else:
        session.edit("draw", lambda document: edits.add_shape(document, Circle((24.0, 24.0), 3.0)))


def _save(window: MainWindow, folder: Path) -> Path:
    target = folder / "work" / "work.cpm"
    document_file = window.get_feature(OpenSaveFeature).document_file
    document_file.save(target)
    until(lambda: not window.session.tasks.current and window.session.idle)
    return target


def _export(window: MainWindow, folder: Path) -> Path:
    target = folder / "work" / "a.svg"
    window.session.export_files(ExportOrder((ExportFile(target, "contours", target.suffix),)))
    until(lambda: window.session.idle)
    return target


def _journal(window: MainWindow, folder: Path) -> Path:
    journal = _journal_of(window)
    journal.write()
    journal.flush()
    return journal.path


def _journal_of(window: MainWindow) -> Journal:
    journal = window.get_feature(RecoveryFeature).journal
    assert journal is not None
    return journal


def _shapes(path: Path) -> int:
    return len(load_session(path).shapes)
