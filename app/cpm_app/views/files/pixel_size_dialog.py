"""Dialog that asks for the size of a pixel or of a voxel."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QDoubleSpinBox,
    QFormLayout,
    QWidget,
)

from cpm_app.model.text.language import tr
from cpm_app.views.widgets.containers import AcceptButtons, lay_out_form
from cpm_app.views.widgets.fields import DecimalField
from cpm_core.numerics.types import Sides

LENGTH_UNITS = ("nm", "µm", "mm", "cm", "m")
"""Units of length that can be selected."""

_SIDE_LABELS = (tr("Distance between planes"), tr("Distance between rows"), tr("Distance between columns"))
"""Labels of the sides of a voxel, in the order of the axes."""

_MIN_SIDE = 1e-6
"""Smallest side of a voxel, in the selected unit."""

_MAX_SIDE = 1e6
"""Largest side of a voxel, in the selected unit."""


class PixelSizeDialog(QDialog):
    """Dialog with a size along each axis and a unit.

    Parameters
    ----------
    parent : QWidget
        The window.
    spacing : tuple of float
        Current size of a pixel along each axis.
    unit : str or None
        Its unit; None if unknown.
    stated : str
        Size in the file as text; empty if it has none.
    """

    size_selected = Signal(object, str)
    """The user has entered a size along each axis and the unit."""
    reset_requested = Signal()
    """The user asks for the size in the file."""

    def __init__(self, parent: QWidget, spacing: Sides, unit: str | None, stated: str) -> None:
        super().__init__(parent)
        volume = len(spacing) == 3
        self.setWindowTitle(tr("Voxel size") if volume else tr("Pixel size"))
        self.sides = tuple(_create_size_field(side) for side in spacing)
        self.unit = QComboBox()
        self.unit.addItems(LENGTH_UNITS)
        self.unit.setCurrentText(unit if unit in LENGTH_UNITS else "mm" if volume else "µm")
        form = QFormLayout()
        for label, field in zip(_SIDE_LABELS[-len(spacing) :], self.sides, strict=True):
            form.addRow(label, field)
        form.addRow(tr("Unit"), self.unit)
        buttons = AcceptButtons(self, tr("Use"))
        self.use_button = buttons.accept_button
        self.reset_button = buttons.addButton(tr("As in the file"), QDialogButtonBox.ButtonRole.ResetRole)
        self.reset_button.clicked.connect(self.reset_requested)
        self.reset_button.clicked.connect(self.reject)
        self.accepted.connect(
            lambda: self.size_selected.emit(tuple(field.value() for field in self.sides), self.unit.currentText())
        )
        text = tr("Size in the file: {size}.", size=stated) if stated else tr("The file does not contain the size.")
        lay_out_form(self, text, form, buttons)


def _create_size_field(size: float) -> QDoubleSpinBox:
    field = DecimalField(_MIN_SIDE, _MAX_SIDE, decimals=6)
    field.setStepType(QDoubleSpinBox.StepType.AdaptiveDecimalStepType)
    field.setValue(size)
    return field
