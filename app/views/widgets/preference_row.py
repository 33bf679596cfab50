"""One thing that may be preferred, as a row of the dialog of the preferences."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtWidgets import QWidget


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PreferenceRow:
    """A row of the dialog.

    Attributes
    ----------
    section : str
        Heading under which it stands; rows with the same one stand together.
    label : str
        What it is, before the widget; may be empty.
    make : callable
        Makes the widget anew each time the dialog is opened; what is chosen in it is kept at once by whoever made it.
    note : str
        A sentence below it.
    """

    section: str
    label: str
    make: Callable[[], QWidget]
    note: str = ""
