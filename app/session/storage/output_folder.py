"""Where files are written by default: one rule for all dialogs.

Beside the image or in the folder that the preferences name, until another folder is chosen for this image. Beside a
sample image of the program nothing is written: there it is the folder that was chosen last.
"""

from __future__ import annotations

import os
from pathlib import Path

from app.model.document.document import Document
from app.model.document.samples import sample_at
from app.model.preferences.preference import Choice, Folder
from app.model.preferences.table import EXPORT_FOLDER, EXPORT_PLACE, FIXED, SESSION_FOLDER, SESSION_PLACE
from app.session.storage.preferences import Preferences

_FOLDER, _CHOSEN_FOR = "files/exports", "files/exports_of"
"""Preferences: the folder that was chosen last, and the image that it was chosen for."""


def output_folder(preferences: Preferences, document: Document) -> Path:
    """Folder that a dialog begins with."""
    last = Path(preferences.get(_FOLDER, "") or Path.home())
    if document.image is None:
        return last
    image = Path(document.image.path)
    if preferences.get(_CHOSEN_FOR, "") == str(image) and last.is_dir():
        return last
    fixed = _fixed_folder(preferences, EXPORT_PLACE, EXPORT_FOLDER)
    if fixed is not None:
        return fixed
    own = image.absolute().parent
    return own if sample_at(image) is None and os.access(own, os.W_OK) else last


def session_folder(preferences: Preferences) -> Path | None:
    """The one folder for all sessions, if the user prefers one."""
    return _fixed_folder(preferences, SESSION_PLACE, SESSION_FOLDER)


def _fixed_folder(preferences: Preferences, place: Choice, folder: Folder) -> Path | None:
    """The preferred folder, None where files go beside the image or the folder has disappeared."""
    path = preferences.value(folder)
    return Path(path) if preferences.value(place) == FIXED and path and Path(path).is_dir() else None


def remember_output_folder(preferences: Preferences, document: Document, path: Path) -> None:
    """A file has been written."""
    preferences.put(_FOLDER, str(path.absolute().parent))
    preferences.put(_CHOSEN_FOR, document.image.path if document.image else "")
