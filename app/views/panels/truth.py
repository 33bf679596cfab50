"""The panel of the ground truth: the agreement of the contours with it."""

from __future__ import annotations

import math
from collections.abc import Callable

from PySide6.QtCore import QSignalBlocker, QSize, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QScrollArea,
    QVBoxLayout,
    QWidget,
)

from app.model.display.differences import Difference
from app.model.text.language import tr, written
from app.session.features.truth_comparison import GroundTruth
from app.views.theme import theme
from app.views.theme.icons import swatch
from app.views.widgets.fields import MarkedSlider
from cpm_core import Comparison, SurfaceComparison
from cpm_core.contours import TOLERANCE, ObjectCounts

_MEASURES: tuple[tuple[str, str, str], ...] = (
    ("dice", tr("Dice"), tr("Overlap of the areas: 1 if they are equal, 0 if they are disjoint.")),
    ("jaccard", tr("Jaccard"), tr("Intersection of the areas divided by their union.")),
    ("hausdorff", tr("Hausdorff"), tr("Largest distance from a point on one boundary to the other boundary.")),
    ("hausdorff95", tr("95 % Hausdorff"), tr("The 95th percentile of these distances.")),
    ("mean_boundary_distance", tr("Mean distance"), tr("Mean distance between the boundaries.")),
    ("recall", tr("Recall"), tr("Fraction of the true boundary that has a contour within the tolerance.")),
    ("precision", tr("Precision"), tr("Fraction of the contours that has a true boundary within the tolerance.")),
    ("f", tr("F"), tr("Harmonic mean of recall and precision.")),
)
_DISTANCES = ("hausdorff", "hausdorff95", "mean_boundary_distance")


class TruthPanel(QWidget):
    """Shows the measures of a comparison with the ground truth, and its settings."""

    load_requested = Signal()
    """The user asks for the dialog that chooses a file."""
    jump_requested = Signal(object)
    """The user asks to see a Difference on the canvas."""

    def __init__(self, truth: GroundTruth) -> None:
        super().__init__()
        self._truth = truth
        self._next = 0
        self.source, self.objects, self.pieces = QLabel(), QLabel(), QLabel()
        for label in (self.source, self.objects, self.pieces):
            label.setWordWrap(True)
        self.pieces.setObjectName("dim")
        self.objects.setToolTip(
            tr(
                "An object is found if a closed contour shares more than half of their common area with it. A contour "
                "that contains more than half of two objects merges them. AP@0.5 is found / (found + missed + extra)."
            )
        )
        self.values: dict[str, QLabel] = {}
        self.load_button = _button(tr("Load…"), self.load_requested.emit)
        self.forget_button = _button(tr("Remove"), truth.forget)
        self.worst_button = _button(tr("Largest difference"), self.jump_to_worst)
        self.next_button = _button(tr("Next difference"), self.jump_to_next)
        self.holes = QCheckBox(tr("Inner contours are holes"))
        self.holes.setToolTip(tr("Otherwise everything inside a contour belongs to the object."))
        self.holes.toggled.connect(truth.set_holes)
        self.tolerance = MarkedSlider(0.25, 10.0, 0.25, TOLERANCE)
        self.tolerance.setAccessibleName(tr("Tolerance"))
        self.tolerance.moved_to.connect(self._set_tolerance)
        self.tolerance.restored.connect(lambda: self.tolerance.move_to(TOLERANCE))
        self._tolerance_label = QLabel()
        self._lay_out()
        truth.changed.connect(self._show)
        truth.compared.connect(self._show)
        self._show()

    def sizeHint(self) -> QSize:
        """As wide as the other panels."""
        return QSize(320, 380)

    def jump_to_worst(self) -> None:
        """Show the place where the boundaries are farthest apart."""
        self._next = 0
        self.jump_to_next()

    def jump_to_next(self) -> None:
        """Show the next difference; after the last one, the largest again."""
        found = self._differences
        if found:
            self.jump_requested.emit(found[self._next % len(found)])
            self._next += 1

    @property
    def _differences(self) -> tuple[Difference, ...]:
        return self._truth.verified.differences if self._truth.verified else ()

    def _lay_out(self) -> None:
        inner, area = QWidget(), QScrollArea()
        inner.setObjectName("scrolled")
        area.setWidgetResizable(True)
        area.setWidget(inner)
        column = QVBoxLayout(inner)
        column.setContentsMargins(12, 8, 12, 8)
        column.setSpacing(7)
        column.addWidget(self.source)
        column.addLayout(_row(self.load_button, self.forget_button))
        column.addWidget(self.holes)
        grid = QGridLayout()
        grid.setHorizontalSpacing(10)
        grid.setVerticalSpacing(3)
        for index, (name, title, tip) in enumerate(_MEASURES):
            label, value = QLabel(title), QLabel("–")
            label.setObjectName("dim")
            for widget in (label, value):
                widget.setToolTip(tip)
            self.values[name] = value
            grid.addWidget(label, index // 2, 2 * (index % 2))
            grid.addWidget(value, index // 2, 2 * (index % 2) + 1)
        grid.setColumnStretch(1, 1)
        grid.setColumnStretch(3, 1)
        column.addLayout(grid)
        column.addWidget(self._tolerance_label)
        column.addWidget(self.tolerance)
        column.addWidget(self.objects)
        column.addWidget(self.pieces)
        column.addLayout(_row(self.worst_button, self.next_button))
        column.addLayout(_legend())
        column.addStretch(1)
        outer = QVBoxLayout(self)
        outer.setContentsMargins(0, 0, 0, 0)
        outer.addWidget(area)

    def _set_tolerance(self, tolerance: float) -> None:
        self._truth.set_tolerance(tolerance)
        self._show_tolerance()

    def _show_tolerance(self) -> None:
        text = tr("Tolerance: {tolerance:g} voxels") if self._truth.in_volume else tr("Tolerance: {tolerance:g} px")
        self._tolerance_label.setText(text.format(tolerance=self._truth.tolerance))

    def _show(self) -> None:
        truth, verified, in_volume = self._truth.truth, self._truth.verified, self._truth.in_volume
        if truth is not None:
            self.source.setText(tr("Compared with {name}").format(name=truth.source))
        elif in_volume:
            self.source.setText(tr("Load a label volume for the comparison."))
        else:
            self.source.setText(tr("Load a mask or contours for the comparison."))
        for name, label in self.values.items():
            label.setText(_value(verified.comparison, name) if verified else "–")
        self.objects.setText(_objects(verified.comparison.objects) if verified else "")
        self.pieces.setText(self._summary())
        self.tolerance.show_value(self._truth.tolerance)
        self._show_tolerance()
        self.holes.setVisible(not in_volume)
        with QSignalBlocker(self.holes):
            self.holes.setChecked(self._truth.holes)
        self.forget_button.setEnabled(truth is not None)
        self.worst_button.setEnabled(bool(self._differences))
        self.next_button.setEnabled(len(self._differences) > 1)

    def _summary(self) -> str:
        if self._truth.truth is None:
            return ""
        verified, differences = self._truth.verified, self._differences
        if verified is None:
            nothing = (
                tr("No surface yet. Start the run.") if self._truth.in_volume else tr("No contours yet. Start the run.")
            )
            return nothing if self._truth.lacks_result else tr("Comparing…")
        if not differences:
            return tr("All boundaries agree within the tolerance.")
        missing = sum(difference.kind == "missing" for difference in differences)
        summary = tr("{missing} missing and {wrong} wrong segments; the largest distance is {farthest}.")
        farthest = _distance(differences[0].farthest, verified.comparison, 1)
        if math.isinf(differences[0].farthest):
            farthest = tr("infinite")
        return summary.format(missing=missing, wrong=len(differences) - missing, farthest=farthest)


def _button(text: str, do: Callable[[], object]) -> QPushButton:
    button = QPushButton(text)
    button.clicked.connect(lambda _=False: do())
    return button


def _objects(counts: ObjectCounts) -> str:
    text = tr("Objects: {found} found, {missed} missed, {extra} extra, {merged} merged; AP@0.5 {precision}.")
    return text.format(
        found=counts.found, missed=counts.missed, extra=counts.extra, merged=counts.merged,
        precision=written(f"{counts.average_precision:.3f}"),
    )  # fmt: skip


def _value(comparison: Comparison | SurfaceComparison, name: str) -> str:
    value = getattr(comparison, name)
    if not math.isfinite(value):
        return "–"
    return _distance(value, comparison, 2) if name in _DISTANCES else written(f"{value:.4f}")


def _distance(value: float, comparison: Comparison | SurfaceComparison, decimals: int) -> str:
    """A distance with its unit."""
    if isinstance(comparison, SurfaceComparison):
        return written(f"{value:.{decimals}f} {comparison.unit or tr('voxels')}")
    return tr("{distance} px").format(distance=written(f"{value:.{decimals}f}"))


def _row(*widgets: QWidget) -> QHBoxLayout:
    row = QHBoxLayout()
    row.setSpacing(6)
    for widget in widgets:
        row.addWidget(widget, 1)
    return row


def _legend() -> QHBoxLayout:
    row = QHBoxLayout()
    row.setSpacing(5)
    for color, text, tip in (
        (theme.TRUTH, tr("true"), tr("True boundary (thin line).")),
        (theme.MISSING, tr("missing"), tr("True boundary without a contour (dashed line).")),
        (theme.WRONG, tr("wrong"), tr("Contour without a true boundary (wide line).")),
    ):
        picture, words = QLabel(), QLabel(text)
        picture.setPixmap(swatch(color).pixmap(QSize(16, 14)))
        words.setObjectName("dim")
        words.setToolTip(tip)
        row.addWidget(picture)
        row.addWidget(words)
        row.addSpacing(8)
    row.addStretch(1)
    return row
