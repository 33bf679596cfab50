"""The dialog for the export of an animation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import QRectF
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDialog,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from app.model.text.language import reason, tr, written
from app.session.storage.preferences import Preferences
from app.views.export.frames import NARROWEST, WIDEST, frame_size
from app.views.widgets.containers import AcceptButtons, arrange, wrapped
from cpm_core.formats import check_encoder

_FORMATS = (
    (".gif", tr("GIF, shown by all programs")),
    (".png", tr("APNG, in full color, shown by browsers")),
    (".mp4", tr("MP4, a film for slides and players")),
)
_KEY = "animation/"


@dataclass(frozen=True, slots=True)
class AnimationPlan:
    """Settings of an animation.

    Attributes
    ----------
    steps : tuple of int
        Steps, one per frame.
    size : tuple of int
        Width and height of a frame [px].
    frames_per_second : int
        Speed.
    zoomed : bool
        Whether frames show only the visible part of the canvas.
    suffix : str
        Format.
    """

    steps: tuple[int, ...]
    size: tuple[int, int]
    frames_per_second: int
    zoomed: bool
    suffix: str


def every(first: int, last: int, stride: int) -> tuple[int, ...]:
    """Every `stride`-th step from the first, and always the last."""
    steps = list(range(first, last + 1, max(stride, 1)))
    return tuple(steps if steps and steps[-1] == last else [*steps, last])


class AnimationDialog(QDialog):
    """Asks for steps from `first` to `last`, size, speed and format; the preferences store the choice.

    `part` returns the part of the image that is shown: all of it, or the visible part for True.
    """

    def __init__(
        self, parent: QWidget, preferences: Preferences, first: int, last: int, part: Callable[[bool], QRectF]
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle(tr("Export animation"))
        self._preferences = preferences
        self._part = part
        self.first = _number(first, last, first)
        self.last = _number(first, last, last)
        self.stride = _number(1, max(last - first, 1), min(preferences.get(_KEY + "every", 1), max(last - first, 1)))
        self.width_field = _number(NARROWEST, WIDEST, preferences.get(_KEY + "width", 640), " px")
        self.speed = _number(1, 50, preferences.get(_KEY + "speed", 15), tr(" frames per second"))
        self.zoomed = QCheckBox(tr("Only the part that the canvas shows now"))
        self.format = QComboBox()
        for suffix, text in _FORMATS:
            self.format.addItem(text, suffix)
        chosen = self.format.findData(preferences.get(_KEY + "format", ".gif"))
        self.format.setCurrentIndex(max(chosen, 0))
        self._summary = wrapped(dim=True)
        self._summary.setMinimumSize(380, 3 * self.fontMetrics().lineSpacing())
        buttons = AcceptButtons(self, tr("Export…"))
        self.export = buttons.accept_button
        self.first.setAccessibleName(tr("First step"))
        self.last.setAccessibleName(tr("Last step"))
        self.stride.setAccessibleName(tr("Steps from frame to frame"))
        form = QFormLayout()
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.FieldsStayAtSizeHint)
        form.addRow(tr("Steps"), arrange(QHBoxLayout(), self.first, QLabel(tr("to")), self.last, None))
        form.addRow(tr("Every"), self.stride)
        form.addRow(tr("Width"), self.width_field)
        form.addRow("", self.zoomed)
        form.addRow(tr("Speed"), self.speed)
        form.addRow(tr("Format"), self.format)
        form.addRow("", self._summary)
        layout = QVBoxLayout(self)
        layout.addLayout(form)
        layout.addStretch(1)
        layout.addWidget(buttons)
        for field in (self.first, self.last, self.stride, self.width_field, self.speed):
            field.valueChanged.connect(self._follow)
        self.zoomed.toggled.connect(self._follow)
        self.format.currentIndexChanged.connect(self._follow)
        self._follow()

    @property
    def plan(self) -> AnimationPlan:
        """The chosen settings."""
        zoomed = self.zoomed.isChecked()
        return AnimationPlan(
            every(self.first.value(), max(self.last.value(), self.first.value()), self.stride.value()),
            frame_size(self._part(zoomed), self.width_field.value()),
            self.speed.value(),
            zoomed,
            str(self.format.currentData()),
        )

    @property
    def summary(self) -> str:
        """The summary of the choice, or what is missing for it."""
        return self._summary.text()

    def _follow(self) -> None:
        plan = self.plan
        missing = ""
        try:
            check_encoder(plan.suffix)
        except ValueError as error:
            missing = reason(error)
        seconds = len(plan.steps) / plan.frames_per_second
        words = tr("{count} frames of {width} × {height} px, {seconds} s. The layers are drawn as on the canvas now.")
        summary = words.format(
            count=len(plan.steps), width=plan.size[0], height=plan.size[1], seconds=written(f"{seconds:.1f}")
        )
        self._summary.setText(missing or summary)
        self.stride.setSuffix(tr(" steps") if self.stride.value() > 1 else tr(" step"))
        self.export.setEnabled(not missing)

    def accept(self) -> None:
        """Keep the choice for the next time."""
        plan = self.plan
        self._preferences.put(_KEY + "every", self.stride.value())
        self._preferences.put(_KEY + "width", self.width_field.value())
        self._preferences.put(_KEY + "speed", plan.frames_per_second)
        self._preferences.put(_KEY + "format", plan.suffix)
        super().accept()


def _number(least: int, most: int, value: int, suffix: str = "") -> QSpinBox:
    field = QSpinBox()
    field.setRange(least, most)
    field.setSuffix(suffix)
    field.setValue(value)
    return field
