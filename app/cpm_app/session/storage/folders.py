"""The folder in which a file dialog opens: one rule for all dialogs.

It is the folder of the image, until another one is selected for this image. Without an image, or with a sample image of
the program, whose folder is not for files of the user, it is the last folder selected for this kind of file.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Literal

from cpm_app.model.document.document import Document
from cpm_app.model.document.samples import find_sample_at
from cpm_app.session.storage.preferences import Preferences

Purpose = Literal["open", "session", "export", "truth"]
"""Purpose of a dialog: an image or session to open, a session to write, a result, a ground truth."""

_READING_PURPOSES = frozenset({"open", "truth"})
"""Purposes for which a folder need not be writable."""


def initial_folder(preferences: Preferences, document: Document, purpose: Purpose) -> Path:
    """Return the folder in which a dialog opens."""
    chosen = preferences.read_key(f"folders/{purpose}", "")
    last = Path(chosen) if chosen and Path(chosen).is_dir() else Path.home()
    if document.image is None:
        return last
    image = Path(document.image.path)
    if chosen and preferences.read_key(f"folders/{purpose}_of", "") == str(image):
        return last
    own = image.absolute().parent
    used = find_sample_at(image) is None and os.access(own, os.R_OK if purpose in _READING_PURPOSES else os.W_OK)
    return own if used else last


def remember_folder(preferences: Preferences, document: Document, purpose: Purpose, path: Path) -> None:
    """Remember the folder of a file that has been selected for this document."""
    preferences.store_key(f"folders/{purpose}", str(path.absolute().parent))
    preferences.store_key(f"folders/{purpose}_of", document.image.path if document.image else "")
