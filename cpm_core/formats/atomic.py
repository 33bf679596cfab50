"""Atomic writing: a file is either the old one or the whole new one, never half of it."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence
from pathlib import Path


def write_together(contents: Sequence[tuple[Path, bytes]]) -> None:
    """Write files beside their places first, and put them there once all of them are on the disk.

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
