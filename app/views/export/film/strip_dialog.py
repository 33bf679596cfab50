"""The dialog of the snapshot strip: some steps side by side, each with a caption, with a preview."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import QEvent, QObject, QSize, Qt, QTimer
from PySide6.QtGui import QPixmap
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from app.model.text.language import tr
from app.model.text.reasons import reason
from app.views.export.film.frame_renderer import to_picture
from app.views.export.film.step_choice import evenly, written
from cpm_core.numerics.types import Pixels

_AFTER = 300
"""Time after the last change until the preview is updated [ms]."""

_FIRST_COUNT, _MOST = 4, 24


@dataclass(frozen=True, slots=True)
class StripPlan:
    """Settings of a strip.

    Attributes
    ----------
    steps : tuple of int
        Steps, one picture each.
    columns : int
        Pictures in a row.
    width : int
        Width of a picture [px].
    """

    steps: tuple[int, ...]
    columns: int
    width: int


class StripDialog(QDialog):
    """Asks for steps from `first` to `last` and shows the strip.

    `draw` begins to draw a strip, which `show_strip` receives when it is ready; `save` saves the strip shown.
    """

    def __init__(
        self,
        parent: QWidget,
        first: int,
        last: int,
        draw: Callable[[StripPlan], None],
        save: Callable[[Pixels], None],
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle(tr("Export snapshot strip"))
        self._span = (first, last)
        self._draw = draw
        self._save = save
        self.pixels: Pixels | None = None
        """The strip shown."""
        self._preview = QLabel(tr("Drawing…"))
        self._preview.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._preview.setMinimumSize(QSize(560, 300))
        self._preview.setAccessibleName(tr("Preview"))
        self._preview.installEventFilter(self)
        self.count = QSpinBox()
        self.count.setRange(1, _MOST)
        self.count.setValue(min(_FIRST_COUNT, last - first + 1))
        self.steps = QLineEdit()
        self.steps.setMinimumWidth(240)
        self.columns = QSpinBox()
        self.columns.setRange(1, _MOST)
        self.columns.setValue(self.count.value())
        self.width_field = QSpinBox()
        self.width_field.setRange(64, 1600)
        self.width_field.setSuffix(" px")
        self.width_field.setValue(320)
        self._error = QLabel()
        self._error.setObjectName("dim")
        self._error.setWordWrap(True)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        self.export = buttons.addButton(tr("Save…"), QDialogButtonBox.ButtonRole.ActionRole)
        self.export.clicked.connect(self._ask_to_save)
        buttons.rejected.connect(self.reject)
        self._lay_out(buttons)
        self._later = QTimer(self, singleShot=True, interval=_AFTER)
        self._later.timeout.connect(self._begin)
        self.count.valueChanged.connect(self._spread)
        self.steps.textEdited.connect(self._change)
        self.columns.valueChanged.connect(self._change)
        self.width_field.valueChanged.connect(self._change)
        self._spread()

    @property
    def plan(self) -> StripPlan:
        """The chosen settings; ValueError for invalid steps."""
        return StripPlan(written(self.steps.text(), *self._span), self.columns.value(), self.width_field.value())

    @property
    def trouble(self) -> str:
        """The error in the choice, or empty."""
        return self._error.text()

    def show_strip(self, pixels: Pixels) -> None:
        """Show a strip that is ready."""
        self.pixels = pixels
        self.export.setEnabled(True)
        self._fit()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Fit the preview into its area."""
        if event.type() == QEvent.Type.Resize:
            self._fit()
        return super().eventFilter(watched, event)

    def _lay_out(self, buttons: QDialogButtonBox) -> None:
        form, sizes = QFormLayout(), QFormLayout()
        form.addRow(tr("Pictures, evenly spaced"), self.count)
        form.addRow(tr("Steps"), self.steps)
        sizes.addRow(tr("Pictures in a row"), self.columns)
        sizes.addRow(tr("Width of each"), self.width_field)
        for rows in (form, sizes):
            rows.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.FieldsStayAtSizeHint)
        row = QHBoxLayout()
        row.addLayout(form)
        row.addSpacing(24)
        row.addLayout(sizes)
        row.addStretch(1)
        layout = QVBoxLayout(self)
        layout.addWidget(self._preview, 1)
        layout.addLayout(row)
        layout.addWidget(self._error)
        layout.addWidget(buttons)
        self.resize(760, 520)

    def _spread(self) -> None:
        steps = evenly(*self._span, self.count.value())
        self.steps.setText(", ".join(str(step) for step in steps))
        self.columns.setValue(min(len(steps), self.columns.maximum()))
        self._change()

    def _change(self) -> None:
        self.export.setEnabled(False)
        try:
            self.plan  # noqa: B018  # evaluated for its error
        except ValueError as error:
            self._error.setText(reason(error))
            self._later.stop()
            return
        self._error.setText("")
        self._later.start()

    def _begin(self) -> None:
        self._draw(self.plan)

    def _fit(self) -> None:
        if self.pixels is not None:
            whole = QPixmap.fromImage(to_picture(self.pixels))
            room = self._preview.size()
            kept, smooth = Qt.AspectRatioMode.KeepAspectRatio, Qt.TransformationMode.SmoothTransformation
            small = whole.width() <= room.width() and whole.height() <= room.height()
            self._preview.setPixmap(whole if small else whole.scaled(room, kept, smooth))

    def _ask_to_save(self) -> None:
        if self.pixels is not None:
            self._save(self.pixels)
