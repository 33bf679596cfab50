"""The panel of the view in space: the controls above the view, and what its menu offers."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

from PySide6.QtCore import QPoint, Signal
from PySide6.QtWidgets import QApplication, QCheckBox, QComboBox, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from app.model.display.space.view_in_space import Contents, ShownParts
from app.model.state.situation import Condition, Situation, has_volume
from app.model.text.language import tr
from app.model.volume.slices import AXES, ends_of
from app.session.session import Session
from app.session.signals import EXPORTING
from app.views.volume.space_view import SpaceView
from app.views.widgets.actions import ActionSpec
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


class SpacePanel(QWidget):
    """Shows contents as the controls say."""

    def __init__(self, session: Session) -> None:
        super().__init__()
        self._contents: Contents | None = None
        self.bar = SpaceBar(ShownParts())
        self.view = SpaceView(session)
        self.bar.changed.connect(self._show)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.bar)
        layout.addWidget(self.view, 1)

    @property
    def contents(self) -> Contents | None:
        """What could be shown."""
        return self._contents

    def menu_at(self, point: QPoint | None) -> tuple[str, QPoint]:
        """The menu of the view; see `MenuOwner`."""
        return "" if self._contents is None else "space", point or self.view.geometry().center()

    def show_contents(self, contents: Contents | None) -> None:
        """Show another volume, or what a run has found in it since."""
        self._contents = contents
        if contents is not None:
            self.view.marks.unit, self.view.marks.names = contents.image.unit, ends_of(contents.image)
        self._show()

    def _show(self) -> None:
        self.view.show_view(None if self._contents is None else self._contents.view(self.bar.shown))


_MENU = "View>" + tr("In s&pace")

_FROM = {"A": tr("From the &front"), "P": tr("From the &front"), "L": tr("From the &left side"),
         "R": tr("From the &left side"), "S": tr("From &below"), "I": tr("From &below")}  # fmt: skip
"""Where a patient is seen from along an axis that ends at a letter, as slices across it are."""


def specs(panel: SpacePanel, session: Session) -> Iterator[ActionSpec]:
    """The actions of the view in space."""
    view, bar = panel.view, panel.bar
    yield ActionSpec("space_whole", _MENU, tr("&Whole volume"),
                     tr("See the whole volume from where it is seen first (0 in the view)."), view.show_all,
                     when=has_volume)  # fmt: skip
    for axis, name in enumerate(AXES):
        yield ActionSpec(f"space_along_{axis}", _MENU, tr("Along the &{axis}").format(axis=name),
                         tr("Look at the volume as at its slices across the axis: {axis} ({key} in the view).")
                         .format(axis=name, key=axis + 1), partial(view.look_along, axis), when=has_volume,
                         worded=_worded(session, axis))  # fmt: skip
    for name, (title, tip) in PARTS.items():
        yield ActionSpec(f"space_{name}", _MENU, title, tip, bar.checks[name].toggle, gap=name == "particles",
                         when=has_volume, holds=_is_shown(panel, name))  # fmt: skip
    yield ActionSpec("copy_space", _MENU, tr("&Copy picture"),
                     tr("Copy what the view in space shows to the clipboard."), partial(_copy, panel, session),
                     gap=True, when=has_volume)  # fmt: skip


def _worded(session: Session, axis: int) -> Callable[[Situation], str]:
    """The text of a view along an axis: in words of a patient where the volume tells how it lies."""

    def text(_: Situation) -> str:
        image = session.scene.image
        if image is None or image.geometry is None or image.ndim != 3:
            return tr("Along the &{axis}").format(axis=AXES[axis])
        return _FROM[ends_of(image)[axis][1]]

    return text


def _is_shown(panel: SpacePanel, name: str) -> Condition:
    return lambda _: panel.bar.checks[name].isChecked()


def _copy(panel: SpacePanel, session: Session) -> None:
    QApplication.clipboard().setImage(panel.view.picture())
    session.say(tr("The picture in space is on the clipboard."), topic=EXPORTING)
