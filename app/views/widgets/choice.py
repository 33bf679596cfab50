"""A choice among actions, as a field of the dialog of the preferences."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtWidgets import QComboBox, QWidget

from app.views.widgets.action_spec import ActionSpec


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
