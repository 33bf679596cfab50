"""A choice among actions, as a field of the dialog of the preferences."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtWidgets import QComboBox, QWidget

from app.views.widgets.action_spec import ActionSpec


def choice(entries: Iterable[ActionSpec], current: str) -> QWidget:
    """A field that offers entries by their texts and does what the one chosen does.

    Parameters
    ----------
    entries : iterable of ActionSpec
        Alternatives.
    current : str
        Name of the one that holds.
    """
    offered = list(entries)
    field = QComboBox()
    for entry in offered:
        field.addItem(entry.text.replace("&", ""))
    names = [entry.name for entry in offered]
    field.setCurrentIndex(names.index(current) if current in names else 0)
    field.activated.connect(lambda index: offered[index].do())
    return field
