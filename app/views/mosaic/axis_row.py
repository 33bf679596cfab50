"""One of the two parameters of a mosaic, with its values."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QComboBox, QGridLayout, QLabel, QLineEdit

from app.model.display.mosaic import Axis, in_text, read_values, sensible_values
from app.model.parameters.controls import Control
from app.model.text.language import tr
from cpm_core.parameters import Parameters


class AxisRow(QObject):
    """A choice among all parameters (`first` is the name of the initial one), and a line for its values."""

    changed = Signal()
    """A different parameter has been chosen."""

    def __init__(self, title: str, controls: tuple[Control, ...], first: str) -> None:
        super().__init__()
        self._controls = controls
        self._title = title
        self.choice = QComboBox()
        self.choice.addItems([f"{control.title}  {control.symbol}" for control in controls])
        self.choice.setCurrentIndex(next(i for i, control in enumerate(controls) if control.name == first))
        self.choice.setAccessibleName(title)
        self.values = QLineEdit()
        self.values.setAccessibleName(tr("Values"))
        self.values.setToolTip(tr("Values of the parameter, separated by commas."))
        self.choice.currentIndexChanged.connect(self.changed)

    @property
    def control(self) -> Control:
        """The chosen parameter."""
        return self._controls[self.choice.currentIndex()]

    def add_to(self, grid: QGridLayout, row: int) -> None:
        """Add its widgets to a grid."""
        grid.addWidget(QLabel(self._title), row, 0)
        grid.addWidget(self.choice, row, 1)
        grid.addWidget(self.values, row, 2)

    def suggest(self, parameters: Parameters, contrast: float, count: int) -> None:
        """Suggest values around the present one."""
        self.values.setText(in_text(sensible_values(self.control, parameters, contrast, count)))

    def axis(self) -> Axis:
        """The chosen parameter and values; raises `ValueError` if the values are not valid."""
        return Axis(self.control, read_values(self.control, self.values.text()))
