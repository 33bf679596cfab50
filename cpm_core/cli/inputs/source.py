"""Where the image of a command is and how it is read: as the command line says, else as the session does."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from cpm_core.formats.sessions.chosen_part import part_for
from cpm_core.formats.sessions.session_file import SessionFile, find_image, load_session


def session_of(arguments: argparse.Namespace) -> SessionFile:
    """The session that is named, else an empty one; ValueError when there is no image."""
    session = load_session(Path(arguments.session)) if arguments.session else SessionFile()
    if arguments.image is None and session.image is None:
        raise ValueError("No IMAGE is given: name one, or with --session FILE a session that has one.")
    return session


def in_volume(session: SessionFile) -> bool:
    """Whether a session is about a volume."""
    return session.image is not None and len(session.image.shape) == 3


def image_of(named: str | None, session: SessionFile, source: str | Path | None) -> tuple[Path, tuple[str, ...]]:
    """Path of the image that is named, or else of that of the session of a file, and notes on it."""
    if named is not None or session.image is None or source is None:
        return Path(named or ""), ()
    return find_image(session.image, Path(source).absolute().parent)


def reading_of(named: str | None, session: SessionFile, path: Path) -> dict[str, Any]:
    """How a session says that the image at a path is read: its own, or the one that is named."""
    if session.image is None:
        return {}
    reading = session.image.reading
    return reading.arguments if named is None else part_for(path, reading)
