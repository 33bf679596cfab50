"""The panel of the ground truth: the agreement of the contours with it."""

from __future__ import annotations

import math
from collections.abc import Callable

from PySide6.QtCore import QSignalBlocker, QSize
from PySide6.QtWidgets import QCheckBox, QGridLayout, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from app.model.display.differences import Difference
from app.model.text.language import tr, written
from app.session.features.truth_comparison import GroundTruth
from app.views.theme import theme
from app.views.theme.icons import swatch
from app.views.widgets.containers import Scrolled, arrange, wrapped
from app.views.widgets.fields import MarkedSlider
from cpm_core import Comparison, SurfaceComparison
from cpm_core.contours import TOLERANCE

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
_LEGEND = (
    (theme.TRUTH, tr("true"), tr("True boundary (thin line).")),
    (theme.MISSING, tr("missing"), tr("True boundary without a contour (dashed line).")),
    (theme.WRONG, tr("wrong"), tr("Contour without a true boundary (wide line).")),
)
_LEAST = 120
"""Least height of the panel [px]."""


class TruthPanel(QWidget):
    """Shows the measures of a comparison with the ground truth, and its settings.

    `load` asks for a file, `jump` shows a difference on the canvas.
    """

    def __init__(self, truth: GroundTruth, load: Callable[[], None], jump: Callable[[Difference], None]) -> None:
        super().__init__()
        self._truth, self._jump = truth, jump
        self._next = 0
        self.source, self.objects, self.pieces = wrapped(), wrapped(), wrapped(dim=True)
        self.objects.setToolTip(
            tr(
                "An object is found if a closed contour shares more than half of their common area with it. A contour "
                "that contains more than half of two objects merges them. AP@0.5 is found / (found + missed + extra)."
            )
        )
        self._forget_button = _button(tr("Remove"), truth.forget)
        self.worst_button = _button(tr("Largest difference"), self.jump_to_worst)
        self._next_button = _button(tr("Next difference"), self.jump_to_next)
        self.holes = QCheckBox(tr("Inner contours are holes"))
        self.holes.setToolTip(tr("Otherwise everything inside a contour belongs to the object."))
        self.holes.toggled.connect(truth.set_holes)
        self._tolerance_label = QLabel()
        self.tolerance = MarkedSlider(0.25, 10.0, 0.25, TOLERANCE)
        self.tolerance.setAccessibleName(tr("Tolerance"))
        self.tolerance.moved_to.connect(truth.set_tolerance)
        self.tolerance.moved_to.connect(self._show)
        self.tolerance.restored.connect(lambda: self.tolerance.move_to(TOLERANCE))
        self.values: dict[str, QLabel] = {}
        measures, legend = QGridLayout(), QHBoxLayout()
        measures.setHorizontalSpacing(10)
        measures.setVerticalSpacing(3)
        for index, (name, title, tip) in enumerate(_MEASURES):
            self.values[name] = QLabel()
            for column, label in enumerate((wrapped(title, dim=True), self.values[name])):
                label.setToolTip(tip)
                measures.addWidget(label, index // 2, 2 * (index % 2) + column)
        measures.setColumnStretch(1, 1)
        measures.setColumnStretch(3, 1)
        for color, text, tip in _LEGEND:
            picture, words = QLabel(), wrapped(text, dim=True)
            picture.setPixmap(swatch(color).pixmap(QSize(16, 14)))
            words.setToolTip(tip)
            legend.addWidget(picture)
            legend.addWidget(words, 1)
        content = QWidget()
        arrange(
            QVBoxLayout(content),
            self.source,
            arrange(QHBoxLayout(), _button(tr("Load…"), load), self._forget_button, spacing=6),
            self.holes,
            measures,
            self._tolerance_label,
            self.tolerance,
            self.objects,
            self.pieces,
            arrange(QHBoxLayout(), self.worst_button, self._next_button, spacing=6),
            legend,
            None,
            margins=(12, 8, 12, 8),
            spacing=7,
        )
        arrange(QVBoxLayout(self), Scrolled(content, _LEAST))
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
        found = self._truth.verified.differences if self._truth.verified else ()
        if found:
            self._jump(found[self._next % len(found)])
            self._next += 1

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
        self.objects.setText("")
        if verified:
            counts = verified.comparison.objects
            text = tr("Objects: {found} found, {missed} missed, {extra} extra, {merged} merged; AP@0.5 {precision}.")
            precision = written(f"{counts.average_precision:.3f}")
            self.objects.setText(text.format(found=counts.found, missed=counts.missed, extra=counts.extra,
                                             merged=counts.merged, precision=precision))  # fmt: skip
        self.pieces.setText(self._summary())
        tolerance = tr("Tolerance: {tolerance:g} voxels") if in_volume else tr("Tolerance: {tolerance:g} px")
        self._tolerance_label.setText(tolerance.format(tolerance=self._truth.tolerance))
        self.tolerance.show_value(self._truth.tolerance)
        self.holes.setVisible(not in_volume)
        with QSignalBlocker(self.holes):
            self.holes.setChecked(self._truth.holes)
        differences = len(verified.differences) if verified else 0
        self._forget_button.setEnabled(truth is not None)
        self.worst_button.setEnabled(differences > 0)
        self._next_button.setEnabled(differences > 1)

    def _summary(self) -> str:
        """How many pieces differ, or why that is not known."""
        verified = self._truth.verified
        if self._truth.truth is None:
            return ""
        if verified is None and self._truth.lacks_result:
            no_surface, no_contours = tr("No surface yet. Start the run."), tr("No contours yet. Start the run.")
            return no_surface if self._truth.in_volume else no_contours
        if verified is None:
            return tr("Comparing…")
        if not verified.differences:
            return tr("All boundaries agree within the tolerance.")
        missing = sum(difference.kind == "missing" for difference in verified.differences)
        farthest = verified.differences[0].farthest
        return tr("{missing} missing and {wrong} wrong segments; the largest distance is {farthest}.").format(
            missing=missing,
            wrong=len(verified.differences) - missing,
            farthest=tr("infinite") if math.isinf(farthest) else _distance(farthest, verified.comparison, 1),
        )


def _button(text: str, do: Callable[[], object]) -> QPushButton:
    button = QPushButton(text)
    button.clicked.connect(lambda _=False: do())
    return button


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
