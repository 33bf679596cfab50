"""Everything of the core that reads or writes files, on a disk that fails."""

from __future__ import annotations

import contextlib
import errno
import io
import resource
import shutil
from collections.abc import Callable
from pathlib import Path

from cpm_core import cli
from cpm_core.formats.common.atomic import draft_files
from cpm_core.formats.sessions.session_file import SessionFile, load_session, save_session

from ..kills.command_line import draw_images
from ..kills.nursery import outcome
from .injection import Faults, can_fail, injected

ERRORS = (errno.ENOSPC, errno.EIO, errno.EACCES, errno.EROFS)
OLD = b"an older file\n"


def save(folder: Path) -> str:
    """Save a session; what is said when that fails."""
    return _told(lambda: save_session(SessionFile(mode="skeleton"), folder / "a.cpm"))


def load(folder: Path) -> str:
    """Read a session."""
    return _told(lambda: load_session(folder / "start.cpm"))


def film(folder: Path) -> str:
    """Write a file that is too large to be made in memory."""

    def write() -> None:
        with draft_files(folder / "a.mp4") as (draft,), draft.open("wb") as stream:
            for _ in range(3):
                stream.write(b"new" * 10_000)

    return _told(write)


def run(folder: Path) -> str:
    """``cpm run`` with exports."""
    files = [str(folder / f"a.{suffix}") for suffix in ("svg", "csv", "zip")]
    return _command(
        "run", f"{folder}/0.npy", "--session", f"{folder}/start.cpm", "--max-steps", "1", "--export", *files
    )


def batch(folder: Path) -> str:
    """``cpm batch`` of three images, in one process."""
    images = [f"{folder}/{number}.npy" for number in range(3)]
    place = ("--output", f"{folder}/out", "--workers", "1", "--contours", "--export", "svg", ".csv")
    return _command("batch", *images, "--session", f"{folder}/start.cpm", "--max-steps", "1", *place)


def _told(call: Callable[[], object]) -> str:
    try:
        call()
    except ValueError as error:
        return str(error)
    return ""


def _command(*arguments: str) -> str:
    said = io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
        status = cli.main(arguments)
    text = said.getvalue()
    assert (status == 0) or text, "it fails without a word"
    return text if status else ""


WORKS: dict[str, Callable[[Path], str]] = {"save": save, "load": load, "film": film, "run": run, "batch": batch}
"""What is done on a disk that fails; each returns what it says, or nothing when all went well."""


_OWN = ("out/summary.csv",)
"""Files that tell of the time, and are never the same."""


def _limited(size: int, work: Callable[[Path], str], folder: Path) -> str:
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
    return work(folder)


class Disk:
    """A folder for one kind of work, as it is before it."""

    def __init__(self, folder: Path, kind: str) -> None:
        self._before, self._now, self._kind = folder / "before", folder / "now", kind
        self._before.mkdir()
        draw_images(self._before)
        for name in ("a.cpm", "a.mp4", "a.svg", "a.csv", "a.zip"):
            (self._before / name).write_bytes(OLD)
        self._renew()
        with injected(Faults(self._now)) as faults:
            assert WORKS[kind](self._now) == ""
        self.operations = tuple(faults.operations)
        self._new = _files(self._now)

    def trials(self) -> list[tuple[int, int, bool]]:
        """What can be tried: the number of an operation, an error that it can have, and whether that lasts."""
        return [
            (number, error, lasting)
            for number, operation in enumerate(self.operations, start=1)
            for error in ERRORS
            if can_fail(operation, error)
            for lasting in (False, True)
        ]

    def trial(self, number: int, error: int, lasting: bool) -> None:
        """Let one operation fail, or all from it on; nothing may be lost, half-written or unsaid."""
        self._renew()
        with injected(Faults(self._now, number, error, lasting)):
            said = WORKS[self._kind](self._now)
        later = " and later" if lasting else ""
        operation = self.operations[number - 1]
        self._check(said, f"{self._kind}, {errno.errorcode[error]} at operation {number}{later} ({operation})")

    def limited(self, size: int) -> None:
        """Let no file become longer than a size, as on a disk that is nearly full."""
        self._renew()
        told = outcome(self._now, _limited, size, WORKS[self._kind], self._now)
        where = f"{self._kind}, files of at most {size} bytes"
        assert not told.killed, f"{where}: it has died"
        self._check(told.value, where)

    def _check(self, said: str, where: str) -> None:
        assert "Traceback" not in said, f"{where}: {said}"
        assert "unexpected" not in said.lower(), f"{where}: {said}"
        old, found = _files(self._before), _files(self._now)
        for name, content in found.items():
            whole = [files[name] for files in (old, self._new) if name in files]
            assert content in whole or name in _OWN, f"{where}: {name} is neither the old file nor the new one"
        assert old.keys() <= found.keys(), f"{where}: {min(old.keys() - found.keys(), default='')} is lost"
        if not said:
            missing = [name for name, content in self._new.items() if found.get(name) != content and name not in _OWN]
            assert not missing, f"{where}: {missing[0]} was not written, and nothing was said"
        again = WORKS[self._kind](self._now)
        assert not again, f"{where}: the next time says {again}"

    def _renew(self) -> None:
        shutil.rmtree(self._now, ignore_errors=True)
        shutil.copytree(self._before, self._now)


def _files(folder: Path) -> dict[str, bytes]:
    """Content of all files but drafts that could not be removed, by their places in a folder."""
    paths = (path for path in folder.rglob("*") if path.is_file() and not path.name.endswith(".part"))
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}
