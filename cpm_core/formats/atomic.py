"""Atomic writing: a file is either the old one or the whole new one, never half of it."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator, Sequence
from pathlib import Path


def write_together(contents: Sequence[tuple[Path, bytes]]) -> None:
    """Write temporary files beside the targets first, and rename them once all of them are on the disk.

    Parameters
    ----------
    contents : sequence of (Path, bytes)
        Where to, and what. Files that exist are replaced; through a link, the file that it points to.

    Raises
    ------
    ValueError
        When one cannot be written; then none of them is changed, unless the very last move fails.
    """
    moves: list[tuple[Path, Path]] = []
    try:
        for path, content in contents:
            target = path.resolve()
            draft = target.with_name(f".{target.name}.{os.getpid()}.{len(moves)}.part")
            moves.append((draft, target))
            with draft.open("xb") as stream:
                stream.write(content)
                stream.flush()
                os.fsync(stream.fileno())
        for draft, target in moves:
            draft.replace(target)
    except OSError as error:
        raise ValueError(f"{moves[-1][1]} cannot be written: {error.strerror or error}.") from error
    finally:
        for draft, _ in moves:
            with contextlib.suppress(OSError):
                draft.unlink()


@contextlib.contextmanager
def draft_of(path: Path) -> Iterator[Path]:
    """Give a temporary file beside a target, for content that is too large to be made in memory.

    Parameters
    ----------
    path : Path
        Where to. A file that exists is replaced; through a link, the file that it points to.

    Yields
    ------
    Path
        The file to write. When the block ends without an error it replaces the target; otherwise it is removed.

    Raises
    ------
    ValueError
        When it cannot be written.
    """
    target = path.resolve()
    draft = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        yield draft
        with draft.open("rb+") as stream:
            os.fsync(stream.fileno())
        draft.replace(target)
    except OSError as error:
        raise ValueError(f"{target} cannot be written: {error.strerror or error}.") from error
    finally:
        with contextlib.suppress(OSError):
            draft.unlink()


def check_place(file: Path) -> None:
    """Check in advance whether a file could be written to a path.

    Raises
    ------
    ValueError
        When the path is a folder, or its folder does not exist or is not writable.
    """
    if file.is_dir():
        raise ValueError(f"{file} is a folder: name a file in it.")
    if not file.parent.is_dir():
        raise ValueError(f"{file} cannot be written: there is no folder {file.parent}.")
    if not os.access(file.parent, os.W_OK):
        raise ValueError(f"{file} cannot be written: you have no permission to write into {file.parent}.")
