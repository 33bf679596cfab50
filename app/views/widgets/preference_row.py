"""A row of the preferences dialog, and a field for alternatives."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from PySide6.QtWidgets import QComboBox, QWidget

from app.views.widgets.action_spec import ActionSpec


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PreferenceRow:
    """A row of the dialog.

    Attributes
    ----------
    section : str
        Heading above the rows of one section.
    label : str
        Label before the widget; may be empty.
    make : callable
        Makes a new widget each time the dialog opens; the widget itself stores changes immediately.
    note : str
        A sentence below it.
    """

    section: str
    label: str
    make: Callable[[], QWidget]
    note: str = ""


def choice(specs: Iterable[ActionSpec], current: str) -> QWidget:
    """A field that offers alternative actions by their texts and does the chosen one; `current` is the name in use."""
    offered = list(specs)
    field = QComboBox()
    for spec in offered:
        field.addItem(spec.text.replace("&", ""))
    names = [spec.name for spec in offered]
    field.setCurrentIndex(names.index(current) if current in names else 0)
    field.activated.connect(lambda index: offered[index].do())
    return field
