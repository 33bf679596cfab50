"""Atomic writing: a file is either the old one or the whole new one, never half of it."""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
import secrets
import signal
import stat
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import FrameType

_DRAFT = ".cpm-"
"""Beginning of the name of a draft."""

_ABANDONED = 600.0
"""Age of a draft that nobody writes any more [s]: its writer was killed."""


def write_together(contents: Sequence[tuple[Path, bytes]]) -> None:
    """Write temporary files next to the targets first, and rename them once all of them are on the disk.

    Parameters
    ----------
    contents : sequence of (Path, bytes)
        Where to, and what. Files that exist are replaced and keep their rights; through a link, the file that it points
        to. An interrupt (Ctrl+C) that comes while files are renamed waits until all of them are.

    Raises
    ------
    ValueError
        When one cannot be written, is read-only or not an ordinary file; then none of them is changed, unless the move
        of a later one fails, which the message tells.
    """
    moves: list[tuple[Path, Path]] = []
    moved = 0
    try:
        for path, content in contents:
            with _failures_told(path):
                target = path.resolve()
                draft = _draft_beside(target)
            moves.append((draft, target))
            with draft.open("xb") as stream:
                stream.write(content)
                stream.flush()  # what is still in the buffer would not be brought to the disk
                _finish(stream.fileno(), target)
        with interrupts_put_off():
            for draft, target in moves:
                _move(draft, target)
                moved += 1
    except OSError as error:
        target = moves[moved if moved else -1][1]
        before = f" {moved} of {len(moves)} files were written before." if moved else ""
        raise ValueError(f"{target} cannot be written: {error.strerror or error}.{before}") from error
    finally:
        for draft, _ in moves:
            with contextlib.suppress(OSError):
                draft.unlink()


@contextlib.contextmanager
def draft_of(path: Path) -> Iterator[Path]:
    """Give a temporary file next to a target, for content that is too large to be made in memory.

    Parameters
    ----------
    path : Path
        Where to. A file that exists is replaced and keeps its rights; through a link, the file that it points to.

    Yields
    ------
    Path
        The file to write. When the block ends without an error it replaces the target; otherwise it is removed.

    Raises
    ------
    ValueError
        When it cannot be written, is read-only or not an ordinary file.
    """
    with _failures_told(path):
        target = path.resolve()
        draft = _draft_beside(target)
        try:
            yield draft
            with draft.open("rb+") as stream:
                _finish(stream.fileno(), target)
            with interrupts_put_off():
                _move(draft, target)
        finally:
            with contextlib.suppress(OSError):
                draft.unlink()


def append(path: Path, content: bytes) -> None:
    """Append to a file, whose reader ignores an end that is cut short; ValueError when it cannot be written."""
    with _failures_told(path), path.open("ab") as stream:
        stream.write(content)


def check_place(file: Path) -> None:
    """Check in advance whether a file could be written to a path.

    Raises
    ------
    ValueError
        When the path is a folder, a device or a read-only file, or its folder does not exist or is not writable.
    """
    with _failures_told(file):
        if file.is_dir():
            raise ValueError(f"{file} is a folder: name a file in it.")
        if not file.parent.is_dir():
            raise ValueError(f"{file} cannot be written: there is no folder {file.parent}.")
        if not os.access(file.parent, os.W_OK):
            raise ValueError(f"{file} cannot be written: you have no permission to write into {file.parent}.")
        _check_target(file.resolve())


@contextlib.contextmanager
def _failures_told(file: Path) -> Iterator[None]:
    """Let ValueError say in a sentence what the system refuses to do with a file."""
    try:
        yield
    except (OSError, RuntimeError) as error:  # some releases of Python call links in a circle a RuntimeError
        reason = (error.strerror if isinstance(error, OSError) else "") or error
        raise ValueError(f"{file} cannot be written: {reason}.") from error


def remove_abandoned(folder: Path, stem: str = _DRAFT) -> None:
    """Remove drafts from a folder whose writers were killed, of all targets or those whose names begin with a stem."""
    oldest = time.time() - _ABANDONED
    with contextlib.suppress(OSError):
        for left in folder.glob(f"{stem}*.part"):
            if left.stat().st_mtime < oldest:
                left.unlink()


def _check_target(target: Path) -> os.stat_result | None:
    """What is known of a target that exists; ValueError when it must not be replaced."""
    try:
        known = target.stat()
    except OSError as error:
        if error.errno == errno.ELOOP:  # newer releases of Python resolve links in a circle without an error
            raise
        return None
    if not stat.S_ISREG(known.st_mode):
        raise ValueError(f"{target} is not an ordinary file and is not replaced: name another one.")
    # the superuser may write everything, but a file that nobody may write is meant to stay
    if not known.st_mode & (stat.S_IWUSR | stat.S_IWGRP | stat.S_IWOTH) or not os.access(target, os.W_OK):
        raise ValueError(f"{target} is read-only and is not replaced: make it writable, or name another one.")
    return known


def _draft_beside(target: Path) -> Path:
    """A new name of fixed length for a draft of a target; drafts of it that have been left behind are removed."""
    _check_target(target)
    stem = f"{_DRAFT}{hashlib.sha256(os.fsencode(target.name)).hexdigest()[:12]}"
    remove_abandoned(target.parent, stem)
    return target.with_name(f"{stem}-{secrets.token_hex(6)}.part")


def _finish(descriptor: int, target: Path) -> None:
    """Give a draft the rights of its target, and bring it to the disk."""
    known = _check_target(target)
    if known is not None and hasattr(os, "fchmod"):
        os.fchmod(descriptor, stat.S_IMODE(known.st_mode))
    os.fsync(descriptor)


def _move(draft: Path, target: Path) -> None:
    """Let a draft take the place of its target, and note that."""
    draft.replace(target)


@contextlib.contextmanager
def interrupts_handled(handler: Callable[[int, FrameType | None], object] | signal.Handlers) -> Iterator[None]:
    """Handle Ctrl+C in the block by `handler`; in any but the main thread, which alone is interrupted, as before."""
    try:
        before = signal.signal(signal.SIGINT, handler)
    except ValueError:  # only the main thread may change it
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextlib.contextmanager
def interrupts_put_off() -> Iterator[None]:
    """Let Ctrl+C wait until the end of the block, and then have the effect that it would have had."""
    before = signal.getsignal(signal.SIGINT)
    if not callable(before):  # ignored, or not of Python
        yield
        return
    came: list[tuple[int, FrameType | None]] = []
    with interrupts_handled(lambda *told: came.append(told)):
        yield
    if came:
        before(*came[0])
