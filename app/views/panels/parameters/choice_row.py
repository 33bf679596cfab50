"""One parameter whose values are names: label and combo box."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QWheelEvent
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QLabel, QWidget

from app.model.parameters.controls import ChoiceControl


class Box(QComboBox):
    """A combo box; the wheel changes it only while it has the focus."""

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Scroll the column unless the box has the focus."""
        if self.hasFocus():
            super().wheelEvent(event)
        else:
            event.ignore()


class ChoiceRow(QWidget):
    """Shows one choice and reports what the user takes."""

    changed = Signal(str, object)
    """Name of the parameter and its new value."""

    def __init__(self, control: ChoiceControl) -> None:
        super().__init__()
        self.control = control
        self.box = Box()
        for value, title, about in control.choices:
            self.box.addItem(title, value)
            self.box.setItemData(self.box.count() - 1, about, Qt.ItemDataRole.ToolTipRole)
        self.box.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.box.setAccessibleName(control.title)
        self.box.setAccessibleDescription(control.explanation)
        label = QLabel(control.title)
        label.setBuddy(self.box)
        for widget in (label, self.box):
            widget.setToolTip("".join(f"<p>{line}</p>" for line in control.lines))
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 2, 0, 2)
        row.addWidget(label, 1)
        row.addWidget(self.box)
        self.box.activated.connect(lambda index: self.changed.emit(control.name, self.box.itemData(index)))

    def show_value(self, value: str) -> None:
        """Show the value of a document."""
        self.box.setCurrentIndex(self.box.findData(value))
