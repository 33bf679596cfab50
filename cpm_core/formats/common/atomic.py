"""Atomic writing: a file is either the old one or the whole new one, never half of it."""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
import secrets
import stat
import time
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from cpm_core.formats.common.content import AnyPath, format_location
from cpm_core.parameters.formatting import format_choice, quote_value

_DRAFT_PREFIX = ".cpm-"
"""Prefix of the names of drafts."""

_ABANDONED_AGE = 600.0
"""Age beyond which a draft is abandoned: its writer was killed [s]."""


def write_together(contents: Sequence[tuple[Path, bytes]]) -> None:
    """Write files whose contents are in memory, all or none; see `draft_files`.

    Parameters
    ----------
    contents : sequence of (Path, bytes)
        Targets and their contents.
    """
    with draft_files(*(path for path, _ in contents)) as drafts:
        for draft, (path, content) in zip(drafts, contents, strict=True):
            with _explain_failures(path):
                draft.write_bytes(content)


@contextlib.contextmanager
def draft_files(*paths: Path) -> Iterator[list[Path]]:
    """Provide temporary files next to their targets.

    Parameters
    ----------
    *paths : Path
        Targets. Existing files are replaced and keep their permissions; links are followed.

    Yields
    ------
    list of Path
        The files to write. When the block ends without an error, all are flushed to disk and replace their targets,
        which an interrupt (Ctrl+C) cannot stop halfway; otherwise they are removed.

    Raises
    ------
    ValueError
        When one cannot be written, is read-only or is not an ordinary file. Then no target has changed, unless moving a
        later file failed, which the message reports.
    """
    moves: list[tuple[Path, Path]] = []
    try:
        for path in paths:
            with _explain_failures(path):
                target = path.resolve()
                _stat_replaceable(target)
                moves.append((_create_draft(target), target))
        with _explain_failures(paths[-1] if paths else Path()):
            yield [draft for draft, _ in moves]
        for draft, target in moves:
            with _explain_failures(target), draft.open("rb+") as stream:
                known = _stat_replaceable(target)
                if known is not None and hasattr(os, "fchmod"):
                    os.fchmod(stream.fileno(), stat.S_IMODE(known.st_mode))
                os.fsync(stream.fileno())
        for moved, (draft, target) in enumerate(moves):
            with _explain_failures(target, f" {moved} of {len(moves)} files were written before." if moved else ""):
                draft.replace(target)
    finally:
        for draft, _ in moves:
            with contextlib.suppress(OSError):
                draft.unlink()


def _create_draft(target: Path) -> Path:
    """Create a draft for a target: under its usual name, or a unique one while another writer uses that."""
    draft = target.with_name(f"{_DRAFT_PREFIX}{hashlib.sha256(os.fsencode(target.name)).hexdigest()[:12]}.part")
    _remove_if_abandoned(draft)
    try:
        draft.touch(exist_ok=False)
    except FileExistsError:
        draft = draft.with_name(f"{draft.stem}-{secrets.token_hex(6)}.part")
    return draft


def append_bytes(path: Path, content: bytes) -> None:
    """Append to a file whose reader ignores a truncated end; ValueError when it cannot be written."""
    with _explain_failures(path), path.open("ab") as stream:
        stream.write(content)


def find_suffix(path: AnyPath, known: Iterable[str]) -> str:
    """Return the longest of the known suffixes that ends a file name, in lower case; empty if none, or if it is all."""
    name = Path(path).name.lower()
    suffix = max((one for one in known if name.endswith(one)), key=len, default="")
    return suffix if len(suffix) < len(name) else ""


def check_target(path: AnyPath, known: Iterable[str], purpose: str = "that can be written") -> None:
    """Check in advance whether a file with one of these suffixes could be written to a path.

    Raises
    ------
    ValueError
        When the suffix is unknown, or `check_writable` raises.
    """
    file = Path(path)
    if not find_suffix(file, known) and not file.is_dir():
        named = f"ends in {quote_value(file.suffix)}" if file.suffix and file.suffix not in known else "has no suffix"
        choice = format_choice(file.suffix, known)
        raise ValueError(f"{file.name} {named}, which names no format {purpose}: choose {choice}")
    check_writable(file)


def check_writable(file: Path) -> None:
    """Check in advance whether a file could be written to a path.

    Raises
    ------
    ValueError
        When the path is a folder, a device or a read-only file, or its folder does not exist or is not writable.
    """
    with _explain_failures(file):
        if file.is_dir():
            raise ValueError(f"{format_location(file)} is a folder: name a file in it.")
        if not file.parent.is_dir():
            raise ValueError(f"{format_location(file)} cannot be written: there is no such folder.")
        if not os.access(file.parent, os.W_OK):
            raise ValueError(
                f"{format_location(file)} cannot be written: you have no permission to write into that folder."
            )
        _stat_replaceable(file.resolve())


@contextlib.contextmanager
def _explain_failures(file: Path, addition: str = "") -> Iterator[None]:
    """Turn errors of the operating system into a ValueError that explains the failure in a sentence."""
    try:
        yield
    except (OSError, RuntimeError) as error:  # some releases of Python raise RuntimeError for circular links
        reason = (error.strerror if isinstance(error, OSError) else "") or error
        raise ValueError(f"{format_location(file)} cannot be written: {reason}.{addition}") from error


def remove_abandoned_drafts(folder: Path) -> None:
    """Remove the drafts of killed writers from a folder."""
    for draft in folder.glob(f"{_DRAFT_PREFIX}*.part"):
        _remove_if_abandoned(draft)


def _remove_if_abandoned(draft: Path) -> None:
    """Remove a draft if it is old enough to be abandoned."""
    with contextlib.suppress(OSError):
        if draft.stat().st_mtime < time.time() - _ABANDONED_AGE:
            draft.unlink()


def _stat_replaceable(target: Path) -> os.stat_result | None:
    """Return the status of an existing target, None for a new one; ValueError when it must not be replaced."""
    try:
        known = target.stat()
    except OSError as error:
        if error.errno == errno.ELOOP:  # newer releases of Python resolve circular links without an error
            raise
        return None
    if not stat.S_ISREG(known.st_mode):
        raise ValueError(f"{format_location(target)} is not an ordinary file and is not replaced: name another one.")
    # the superuser may write everything, but a file without any write permission should be kept
    if not known.st_mode & (stat.S_IWUSR | stat.S_IWGRP | stat.S_IWOTH) or not os.access(target, os.W_OK):
        raise ValueError(
            f"{format_location(target)} is read-only and is not replaced: make it writable, or name another one."
        )
    return known
