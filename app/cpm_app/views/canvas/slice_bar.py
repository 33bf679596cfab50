"""The bar below the canvas that selects the slice of a volume."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QButtonGroup, QHBoxLayout, QToolButton

from cpm_app.model.display.lengths import format_pixel_size
from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import tr
from cpm_app.model.volume.slices import AXIS_NAMES, Slices, name_slices
from cpm_app.views.widgets.containers import create_flat_button, fill_layout
from cpm_app.views.widgets.fields import PlaceBar
from cpm_core import Image


class SliceBar(PlaceBar):
    """Axis, slider and number of the slice, from 1, and the voxel size; hidden while no volume is open."""

    size_wanted = Signal()
    """The user wants to set the size of a voxel."""
    axis_wanted = Signal(int)
    """Axis that the user wants slices across."""

    def __init__(self) -> None:
        super().__init__(tr("Slice"), tr("Number of the slice"))
        self.axes = [QToolButton() for _ in AXIS_NAMES]
        group = QButtonGroup(self)
        for axis, button in enumerate(self.axes):
            button.setToolTip(tr("Show slices across this axis: {axis}.", axis=AXIS_NAMES[axis]))
            button.setAccessibleName(tr("Slices across the axis: {axis}", axis=AXIS_NAMES[axis]))
            button.setCheckable(True)
            group.addButton(button, axis)
        group.idClicked.connect(self.axis_wanted)
        tip = tr("Voxel size: plane × row × column. Click to change it.")
        self.voxel = create_flat_button("", tip, self.size_wanted.emit)
        self.voxel.setObjectName("dim")
        parts = *self.axes, self.slider, self.number, self.total_label, self.voxel
        row = fill_layout(QHBoxLayout(self), *parts, margins=(10, 3, 10, 3), spacing=4, wide=self.slider)
        row.insertSpacing(len(self.axes), 8)

    def show_keys(self) -> None:
        """Name the current keys in the tool tip."""
        tip = tr("Move through the slices: {key:previous_slice} and {key:next_slice}, or the wheel.")
        self.slider.setToolTip(insert_keys(tip))

    def show_slices(self, slices: Slices | None, image: Image | None) -> None:
        """Show the position of the slices, or hide when there are none."""
        self.setVisible(slices is not None)
        if slices is None or image is None:
            return
        self.show_position(slices.current.index + 1, slices.count)
        for button, name in zip(self.axes, name_slices(image), strict=True):
            button.setText(name[:1].upper() + name[1:])
        self.axes[slices.axis].setChecked(True)
        self.voxel.setText(format_pixel_size(image.spacing, image.unit) or tr("Size…"))
