"""A row of the preferences dialog that is more than the value of one preference."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtWidgets import QWidget


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PreferenceRow:
    """A row of the dialog.

    Attributes
    ----------
    page : str
        Name of its page in `PAGES`.
    label : str
        Label before the widget.
    make : callable
        Makes a new widget each time the dialog opens.
    note : str
        A sentence below it.
    """

    page: str
    label: str
    make: Callable[[], QWidget]
    note: str = ""
