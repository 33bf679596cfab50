"""The folder in which a file dialog begins: one rule for all dialogs.

Beside the image or in the folder that the preferences name, until another one is chosen for this image. Without an
image, or with a sample image of the program, beside which nothing is kept, it is the folder that was chosen last for
this kind of file.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Literal

from app.model.document.document import Document
from app.model.document.samples import sample_at
from app.model.preferences.table import (
    EXPORT_FOLDER,
    EXPORT_PLACE,
    FIXED,
    SESSION_FOLDER,
    SESSION_PLACE,
    Choice,
    Folder,
)
from app.session.storage.preferences import Preferences

Purpose = Literal["open", "session", "export", "truth", "preset"]
"""What a dialog asks for: an image or session to open, a session to write, a result, a ground truth, a preset."""

_FIXED: dict[Purpose, tuple[Choice, Folder]] = {
    "export": (EXPORT_PLACE, EXPORT_FOLDER),
    "session": (SESSION_PLACE, SESSION_FOLDER),
}
"""Purposes for which the preferences may name one folder."""

_READ: frozenset[Purpose] = frozenset({"open", "truth"})
"""Purposes for which a folder need not be writable."""


def first_folder(preferences: Preferences, document: Document, purpose: Purpose) -> Path:
    """Folder that a dialog begins with."""
    chosen = preferences.get(_folder(purpose), "")
    last = Path(chosen) if chosen and Path(chosen).is_dir() else Path.home()
    if document.image is None:
        return last
    image = Path(document.image.path)
    if chosen and preferences.get(_image(purpose), "") == str(image):
        return last
    fixed = _fixed_folder(preferences, purpose)
    if fixed is not None:
        return fixed
    own = image.absolute().parent
    used = sample_at(image) is None and os.access(own, os.R_OK if purpose in _READ else os.W_OK)
    return own if used else last


def remember_folder(preferences: Preferences, document: Document, purpose: Purpose, path: Path) -> None:
    """A file has been chosen for this document."""
    preferences.put(_folder(purpose), str(path.absolute().parent))
    preferences.put(_image(purpose), document.image.path if document.image else "")


def _fixed_folder(preferences: Preferences, purpose: Purpose) -> Path | None:
    """The one folder that the user prefers for a purpose; None without one, or where it has disappeared."""
    if purpose not in _FIXED:
        return None
    place, folder = _FIXED[purpose]
    path = preferences.value(folder)
    return Path(path) if preferences.value(place) == FIXED and path and Path(path).is_dir() else None


def _folder(purpose: Purpose) -> str:
    return f"folders/{purpose}"


def _image(purpose: Purpose) -> str:
    """Key of the image that the folder was chosen for."""
    return f"folders/{purpose}_of"
