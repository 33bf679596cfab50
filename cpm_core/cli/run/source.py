"""Where the image of ``cpm run`` is and how it is read: as the command line says, else as the session does."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
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


def image_of(arguments: argparse.Namespace, session: SessionFile) -> tuple[Path, tuple[str, ...]]:
    """Path of the given image, or else of that of the session, and notes on it."""
    if arguments.image is not None or session.image is None:
        return Path(arguments.image), ()
    return find_image(session.image, Path(arguments.session).absolute().parent)


def reading_of(
    arguments: argparse.Namespace, session: SessionFile, path: Path, given: Mapping[str, Any]
) -> dict[str, Any]:
    """How the image is read: what was given, and for the rest what the session says."""
    if session.image is None:
        return dict(given)
    reading = session.image.reading
    own = reading.arguments if arguments.image is None else part_for(path, reading)
    kept = {name: value for name, value in own.items() if name != "page" or getattr(arguments, "pages", None) is None}
    return {**kept, **given}
