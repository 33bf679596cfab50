"""One thing that may be preferred, as a row of the dialog of the preferences, and the field of a choice."""

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


def choice(specs: Iterable[ActionSpec], current: str) -> QWidget:
    """A field that offers actions by their texts and does what the one chosen does.

    Parameters
    ----------
    specs : iterable of ActionSpec
        Alternatives.
    current : str
        Name of the one that holds.
    """
    offered = list(specs)
    field = QComboBox()
    for spec in offered:
        field.addItem(spec.text.replace("&", ""))
    names = [spec.name for spec in offered]
    field.setCurrentIndex(names.index(current) if current in names else 0)
    field.activated.connect(lambda index: offered[index].do())
    return field
