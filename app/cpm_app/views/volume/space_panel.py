"""The panel of the view in space: its controls and its menu."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QApplication, QCheckBox, QComboBox, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from cpm_app.model.space.view_in_space import ShownParts, ViewInSpace
from cpm_app.model.state.situation import Situation, has_volume
from cpm_app.model.text.language import tr
from cpm_app.model.volume.slices import AXIS_NAMES, axis_ends
from cpm_app.session.session import Session
from cpm_app.session.session_messages import EXPORTING_CATEGORY
from cpm_app.views.volume.space_view import SpaceView
from cpm_app.views.widgets.actions import ActionSpec
from cpm_app.views.widgets.containers import fill_layout
from cpm_app.views.widgets.fields import MarkedSlider

_SHOWN_PARTS = {
    "particles": (tr("Particles"), tr("Show the particles.")),
    "surface": (tr("Surface"), tr("Show the surface that the particles have found.")),
    "objects": (tr("Objects"), tr("Show the objects that have been selected, in the colors of their classes.")),
    "slices": (tr("Slices"), tr("Show the three slices through the cross-hair.")),
    "projection": (tr("Projection"), tr("Show the brightest voxel on each line of sight, behind everything else.")),
    "box": (tr("Box"), tr("Show the edges of the volume and the names of its axes.")),
}
"""Titles and tips of the parts by their fields in `ShownParts`."""

_ALTERNATIVES = {"slices": "projection", "projection": "slices"}
"""Parts that replace one another: slices hide nearly all brightest voxels, which lie behind them."""

_CUT_AXES = ((tr("No cut"), None), (tr("Cut planes"), 0), (tr("Cut rows"), 1), (tr("Cut columns"), 2))
"""Titles of the cuts, and the axes across which they run."""


class SpaceBar(QWidget):
    """Controls for the parts shown in space."""

    changed = Signal(object)
    """The user has changed the shown parts: `ShownParts`."""

    def __init__(self) -> None:
        super().__init__()
        self.shown = ShownParts()
        """Parts that are shown."""
        self.checks = {name: QCheckBox(title) for name, (title, _) in _SHOWN_PARTS.items()}
        self.opacity = _create_slider(tr("Opacity of surface and objects"), 0.05, self.shown.opacity)
        self.opacity.setToolTip(tr("Through a transparent surface, particles and slices behind it are visible."))
        self.cut = QComboBox()
        self.cut.setAccessibleName(tr("Axis of the cut"))
        self.cut.setToolTip(tr("Cut away the front of the surface and particles to look inside."))
        for title, axis in _CUT_AXES:
            self.cut.addItem(title, axis)
        self.cut_at = _create_slider(tr("Position of the cut"), 0.01, self.shown.cut_at)
        for name, check in self.checks.items():
            check.setToolTip(_SHOWN_PARTS[name][1])
            check.setChecked(getattr(self.shown, name))
            check.toggled.connect(partial(self._on_part_toggled, name))
        looks = fill_layout(QHBoxLayout(), QLabel(tr("Opacity")), self.opacity)
        cut = fill_layout(QHBoxLayout(), self.cut, self.cut_at)
        fill_layout(QVBoxLayout(self), *self.checks.values(), looks, cut, None, margins=(12, 8, 8, 6), spacing=6)
        self.opacity.moved_to.connect(self._on_control_changed)
        self.cut.currentIndexChanged.connect(self._on_control_changed)
        self.cut_at.moved_to.connect(self._on_control_changed)
        self._update_enabled()

    def _on_part_toggled(self, name: str, on: bool) -> None:
        if on and name in _ALTERNATIVES:
            self.checks[_ALTERNATIVES[name]].setChecked(False)
        self._on_control_changed()

    def _on_control_changed(self) -> None:
        shown = replace(
            self.shown,
            **{name: check.isChecked() for name, check in self.checks.items()},
            opacity=self.opacity.exact,
            cut_axis=self.cut.currentData(),
            cut_at=self.cut_at.exact,
        )
        if shown != self.shown:
            self.shown = shown
            self._update_enabled()
            self.changed.emit(shown)

    def _update_enabled(self) -> None:
        """Disable the controls that have no effect."""
        self.opacity.setEnabled(self.shown.surface or self.shown.objects)
        self.cut_at.setEnabled(self.shown.cut_axis is not None)


def _create_slider(name: str, step: float, first: float) -> MarkedSlider:
    slider = MarkedSlider(0.0, 1.0, step, first)
    slider.setAccessibleName(name)
    slider.show_value(first)
    slider.restored.connect(partial(slider.move_to, first))
    return slider


class SpacePanel(QWidget):
    """The controls, and the view next to the slices that shows a volume accordingly."""

    def __init__(self, session: Session) -> None:
        super().__init__()
        self.contents: ViewInSpace | None = None
        """View that is shown."""
        self.bar = SpaceBar()
        self.view = SpaceView(session)
        self.bar.changed.connect(lambda: self.show_contents(self.contents))
        fill_layout(QVBoxLayout(self), self.bar)

    def show_contents(self, contents: ViewInSpace | None) -> None:
        """Show another volume, or newer results of a run."""
        self.contents = None if contents is None else replace(contents, shown=self.bar.shown)
        self.view.show_view(self.contents)


_SPACE_MENU = ">" + tr("In space")
"""Submenu of the view in space."""

_PATIENT_VIEWS = {"A": tr("From the &front"), "P": tr("From the &front"), "L": tr("From the &left side"),
         "R": tr("From the &left side"), "S": tr("From &below"), "I": tr("From &below")}  # fmt: skip
"""Titles of the views along an axis, by the letter at its end, as slices across the axis are seen."""


def space_action_specs(panel: SpacePanel, session: Session) -> Iterator[ActionSpec]:
    """Return the actions of the view in space."""

    def copy_picture() -> None:
        QApplication.clipboard().setImage(panel.view.grab().toImage())
        session.messages.show(tr("The view in space was copied."), category=EXPORTING_CATEGORY)

    def create_axis_action(axis: int) -> ActionSpec:
        """Create the action for a view along an axis, titled by anatomy where the orientation is known."""
        plain = tr("Along the &{axis}", axis=AXIS_NAMES[axis])

        def format_title(_: Situation) -> str:
            image = session.scene.image
            if image is None or image.geometry is None or image.ndim != 3:
                return plain
            return _PATIENT_VIEWS[axis_ends(image)[axis][1]]

        return ActionSpec(f"space_along_{axis}", _SPACE_MENU, plain,
                          tr("Look along this axis: {axis} ({key} in the view).", axis=AXIS_NAMES[axis], key=axis + 1),
                          partial(panel.view.look_along, axis),
                          visible_when=has_volume, text_for=format_title)  # fmt: skip

    def create_part_action(name: str) -> ActionSpec:
        (title, tip), check = _SHOWN_PARTS[name], panel.bar.checks[name]
        return ActionSpec(f"space_{name}", _SPACE_MENU, title, tip, check.toggle,
                          visible_when=has_volume, checked_when=lambda _: check.isChecked())  # fmt: skip

    yield ActionSpec("space_whole", _SPACE_MENU, "&Whole volume",
                     "Show the whole volume from the initial direction (0 in the view).", panel.view.show_all,
                     visible_when=has_volume)  # fmt: skip
    yield from map(create_axis_action, range(3))
    yield from map(create_part_action, _SHOWN_PARTS)
    yield ActionSpec("copy_space", _SPACE_MENU, "&Copy picture",
                     "Copy the view in space to the clipboard.", copy_picture,
                     visible_when=has_volume)  # fmt: skip
