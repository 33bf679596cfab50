"""The row of controls above the view in space: which parts are shown, how the surface looks, and where it is cut."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QComboBox, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from app.model.display.space.shown_parts import ShownParts
from app.model.text.language import tr
from app.views.widgets.fields import MarkedSlider

PARTS = {
    "particles": (tr("Particles"), tr("Show the particles.")),
    "surface": (tr("Surface"), tr("Show the surface that the particles have found.")),
    "objects": (tr("Objects"), tr("Show the objects that have been selected, in the colors of their classes.")),
    "slices": (tr("Slices"), tr("Show the three slices through the cross-hair.")),
    "projection": (tr("Projection"), tr("Show the brightest voxel on each line of sight, behind everything else.")),
    "box": (tr("Box"), tr("Show the edges of the volume and the names of its axes.")),
}
"""Titles and tips of the parts by their fields in `ShownParts`."""

_CUTS = ((tr("No cut"), None), (tr("Cut planes"), 0), (tr("Cut rows"), 1), (tr("Cut columns"), 2))


class SpaceBar(QWidget):
    """Controls of what is shown in space."""

    changed = Signal(object)
    """The user has chosen other parts."""

    def __init__(self, shown: ShownParts) -> None:
        super().__init__()
        self._shown = shown
        self.checks = {name: QCheckBox(title) for name, (title, _) in PARTS.items()}
        self.opacity = MarkedSlider(0.0, 1.0, 0.05, 1.0)
        self.cut = QComboBox()
        self.cut_at = MarkedSlider(0.0, 1.0, 0.01, 0.5)
        parts, looks = QHBoxLayout(), QHBoxLayout()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(8, 3, 8, 3)
        layout.setSpacing(2)
        layout.addLayout(parts)
        layout.addLayout(looks)
        for name, check in self.checks.items():
            check.setToolTip(PARTS[name][1])
            check.setChecked(getattr(shown, name))
            check.toggled.connect(self._choose)
            parts.addWidget(check)
        parts.addStretch(1)
        label = QLabel(tr("Opacity"))
        label.setBuddy(self.opacity)
        looks.addWidget(label)
        self.opacity.setAccessibleName(tr("Opacity of surface and objects"))
        self.opacity.setToolTip(tr("A surface that is not opaque lets particles and slices behind it be seen."))
        self.opacity.show_value(shown.opacity)
        looks.addWidget(self.opacity, 1)
        for title, axis in _CUTS:
            self.cut.addItem(title, axis)
        self.cut.setAccessibleName(tr("Axis of the cut"))
        self.cut.setToolTip(tr("Take the front part of surface and particles away, to look inside."))
        looks.addWidget(self.cut)
        self.cut_at.setAccessibleName(tr("Place of the cut"))
        self.cut_at.show_value(shown.cut_at)
        looks.addWidget(self.cut_at, 1)
        self.opacity.moved_to.connect(self._choose)
        self.opacity.restored.connect(lambda: self.opacity.move_to(1.0))
        self.cut.currentIndexChanged.connect(self._choose)
        self.cut_at.moved_to.connect(self._choose)
        self.cut_at.restored.connect(lambda: self.cut_at.move_to(0.5))
        self._enable()

    @property
    def shown(self) -> ShownParts:
        """What is chosen."""
        return self._shown

    def _choose(self) -> None:
        parts = {name: check.isChecked() for name, check in self.checks.items()}
        chosen = replace(
            self._shown,
            **parts,
            opacity=self.opacity.exact,
            cut_axis=self.cut.currentData(),
            cut_at=self.cut_at.exact,
        )
        if chosen != self._shown:
            self._shown = chosen
            self._enable()
            self.changed.emit(chosen)

    def _enable(self) -> None:
        """Controls without an effect are gray."""
        self.opacity.setEnabled(self._shown.surface or self._shown.objects)
        self.cut_at.setEnabled(self._shown.cut_axis is not None)
