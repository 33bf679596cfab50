"""The panel of the view in space: its controls, and what its menu offers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QApplication, QCheckBox, QComboBox, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from cpm_app.model.space.view_in_space import ShownParts, ViewInSpace
from cpm_app.model.state.situation import Situation, has_volume
from cpm_app.model.text.language import tr
from cpm_app.model.volume.slices import AXES, ends_of
from cpm_app.session.session import Session
from cpm_app.session.signals import EXPORTING
from cpm_app.views.volume.space_view import SpaceView
from cpm_app.views.widgets.actions import ActionSpec
from cpm_app.views.widgets.containers import arrange
from cpm_app.views.widgets.fields import MarkedSlider

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

    def __init__(self) -> None:
        super().__init__()
        self.shown = ShownParts()
        """What is chosen."""
        self.checks = {name: QCheckBox(title) for name, (title, _) in PARTS.items()}
        self.opacity = _slider(tr("Opacity of surface and objects"), 0.05, self.shown.opacity)
        self.opacity.setToolTip(tr("Through a transparent surface, particles and slices behind it are visible."))
        self.cut = QComboBox()
        self.cut.setAccessibleName(tr("Axis of the cut"))
        self.cut.setToolTip(tr("Cut away the front of the surface and particles to look inside."))
        for title, axis in _CUTS:
            self.cut.addItem(title, axis)
        self.cut_at = _slider(tr("Position of the cut"), 0.01, self.shown.cut_at)
        for name, check in self.checks.items():
            check.setToolTip(PARTS[name][1])
            check.setChecked(getattr(self.shown, name))
            check.toggled.connect(self._choose)
        looks = arrange(QHBoxLayout(), QLabel(tr("Opacity")), self.opacity)
        cut = arrange(QHBoxLayout(), self.cut, self.cut_at)
        arrange(QVBoxLayout(self), *self.checks.values(), looks, cut, None, margins=(12, 8, 8, 6), spacing=6)
        self.opacity.moved_to.connect(self._choose)
        self.cut.currentIndexChanged.connect(self._choose)
        self.cut_at.moved_to.connect(self._choose)
        self._enable()

    def _choose(self) -> None:
        chosen = replace(
            self.shown,
            **{name: check.isChecked() for name, check in self.checks.items()},
            opacity=self.opacity.exact,
            cut_axis=self.cut.currentData(),
            cut_at=self.cut_at.exact,
        )
        if chosen != self.shown:
            self.shown = chosen
            self._enable()
            self.changed.emit(chosen)

    def _enable(self) -> None:
        """Controls without an effect are gray."""
        self.opacity.setEnabled(self.shown.surface or self.shown.objects)
        self.cut_at.setEnabled(self.shown.cut_axis is not None)


def _slider(name: str, step: float, first: float) -> MarkedSlider:
    slider = MarkedSlider(0.0, 1.0, step, first)
    slider.setAccessibleName(name)
    slider.show_value(first)
    slider.restored.connect(partial(slider.move_to, first))
    return slider


class SpacePanel(QWidget):
    """The controls, and the view that shows a volume as they say, which is next to the slices."""

    def __init__(self, session: Session) -> None:
        super().__init__()
        self.contents: ViewInSpace | None = None
        """What is shown."""
        self.bar = SpaceBar()
        self.view = SpaceView(session)
        self.bar.changed.connect(lambda: self.show_contents(self.contents))
        arrange(QVBoxLayout(self), self.bar)

    def show_contents(self, contents: ViewInSpace | None) -> None:
        """Show another volume, or what a run has found in it since."""
        self.contents = None if contents is None else replace(contents, shown=self.bar.shown)
        self.view.show_view(self.contents)


_MENU = ">" + tr("In space")

_FROM = {"A": tr("From the &front"), "P": tr("From the &front"), "L": tr("From the &left side"),
         "R": tr("From the &left side"), "S": tr("From &below"), "I": tr("From &below")}  # fmt: skip
"""Where a patient is seen from along an axis that ends at a letter, as slices across it are."""


def specs(panel: SpacePanel, session: Session) -> Iterator[ActionSpec]:
    """The actions of the view in space."""

    def copy() -> None:
        QApplication.clipboard().setImage(panel.view.grab().toImage())
        session.say(tr("The view in space was copied."), topic=EXPORTING)

    def along(axis: int) -> ActionSpec:
        """A view along an axis, in words of a patient where it is known how the volume lies."""
        plain = tr("Along the &{axis}").format(axis=AXES[axis])

        def text(_: Situation) -> str:
            image = session.scene.image
            if image is None or image.geometry is None or image.ndim != 3:
                return plain
            return _FROM[ends_of(image)[axis][1]]

        return ActionSpec(f"space_along_{axis}", _MENU, plain,
                          tr("Look along this axis: {axis} ({key} in the view).")
                          .format(axis=AXES[axis], key=axis + 1), partial(panel.view.look_along, axis),
                          there=has_volume, worded=text)  # fmt: skip

    def part(name: str) -> ActionSpec:
        (title, tip), check = PARTS[name], panel.bar.checks[name]
        return ActionSpec(f"space_{name}", _MENU, title, tip, check.toggle,
                          there=has_volume, holds=lambda _: check.isChecked())  # fmt: skip

    yield ActionSpec("space_whole", _MENU, "&Whole volume",
                     "Show the whole volume from the initial direction (0 in the view).", panel.view.show_all,
                     there=has_volume)  # fmt: skip
    yield from map(along, range(3))
    yield from map(part, PARTS)
    yield ActionSpec("copy_space", _MENU, "&Copy picture",
                     "Copy the view in space to the clipboard.", copy,
                     there=has_volume)  # fmt: skip
