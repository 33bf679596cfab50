"""Panel of the comparison: a table of results, a ground truth from a file, and the differences."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from operator import attrgetter

from PySide6.QtCore import QSignalBlocker, QSize, Qt
from PySide6.QtGui import QFont
from PySide6.QtWidgets import (
    QCheckBox,
    QHBoxLayout,
    QLabel,
    QVBoxLayout,
    QWidget,
)

from cpm_app.model.display.differences import Difference
from cpm_app.model.display.lengths import PixelSize, preferred_pixel_size
from cpm_app.model.text.language import localize_number, tr
from cpm_app.session.features.comparison import CURRENT_KEY, TRUTH_KEY, ComparedResults, ComparisonRow
from cpm_app.session.session import Session
from cpm_app.views.panels.tables import Column, ItemTable, Role, TableModel, create_wide_button
from cpm_app.views.widgets.actions import ActionButton, add_menu_action
from cpm_app.views.widgets.containers import FoldableSection, create_wrapped_label, fill_layout
from cpm_app.views.widgets.fields import MarkedSlider
from cpm_core.contours import DEFAULT_TOLERANCE
from cpm_core.numerics.types import Callback


def _build_columns(compared: ComparedResults) -> tuple[Column[ComparisonRow], ...]:
    """Build the columns in the order shown."""

    def agreement_of(name: str) -> Callable[[ComparisonRow], float | None]:
        """Return a function from a row to a measure of agreement, or None while it is unknown."""
        get = attrgetter(name)
        return lambda row: get(compared.agreements[row.key]) if row.key in compared.agreements else None

    return (
        Column("name", tr("Result"), tr("The results; the reference, with which the others are compared, is bold."),
               lambda row: row.title, "Run 1"),
        Column("dice", tr("Dice"), tr("Overlap of the areas: 1 if they are equal, 0 if they are disjoint."),
               agreement_of("dice"), "0.000", number_format=".3f"),
        Column("mean", tr("Mean [{unit}]"), tr("Mean distance between the boundaries."),
               agreement_of("mean_boundary_distance"), "00.00", 1, number_format=".2f"),
        Column("largest", tr("Largest [{unit}]"),
               tr("Largest distance from a point on one boundary to the other boundary (Hausdorff)."),
               agreement_of("hausdorff"), "000.0", 1, number_format=".1f"),
        Column("count", tr("Found"), tr("Number of objects, or of contours if there are none."),
               lambda row: row.count, "000", number_format=".0f"),
        Column("f", tr("F"), tr("Harmonic mean of recall and precision."), agreement_of("f"), "0.000",
               number_format=".3f"),
        Column("recall", tr("Recall"),
               tr("Fraction of the boundary of the reference that is found within the tolerance."),
               agreement_of("recall"), "0.000", number_format=".3f"),
        Column("precision", tr("Precision"),
               tr("Fraction of the found boundary that lies within the tolerance of the reference."),
               agreement_of("precision"), "0.000", number_format=".3f"),
        Column("jaccard", tr("Jaccard"), tr("Intersection of the areas divided by their union."),
               agreement_of("jaccard"), "0.000", number_format=".3f"),
        Column("hausdorff95", tr("95 % [{unit}]"), tr("The 95th percentile of the distances between the boundaries."),
               agreement_of("hausdorff95"), "000.0", 1, number_format=".1f"),
        Column("missed", tr("Missed"), tr("Objects of the reference that share less than half of their area with one."),
               agreement_of("objects.missed"), "000", number_format=".0f"),
        Column("extra", tr("Extra"), tr("Closed contours that match no object of the reference."),
               agreement_of("objects.extra"), "000", number_format=".0f"),
        Column("merged", tr("Merged"), tr("Contours that contain more than half of two or more objects."),
               agreement_of("objects.merged"), "000", number_format=".0f"),
        Column("ap", "AP@0.5", tr("Found objects divided by all that are found, missed or extra."),
               agreement_of("objects.average_precision"), "0.000", number_format=".3f"),
    )  # fmt: skip


class ResultTable(ItemTable):
    """Table of the results; one of them is selected."""

    menu_name = "result"

    def __init__(self, session: Session, compared: ComparedResults) -> None:
        self._session, self._compared = session, compared
        bold = QFont()
        bold.setBold(True)
        rows = TableModel[ComparisonRow](
            _build_columns(compared),
            lambda row: row.key,
            lambda row, role, _: bold if role == Role.FontRole and row.key == compared.reference else None,
        )
        super().__init__(rows, tr("Results"))
        self.setSelectionMode(self.SelectionMode.SingleSelection)
        self.sortByColumn(-1, Qt.SortOrder.AscendingOrder)
        compared.changed.connect(self.show_items)
        compared.selection_changed.connect(self.show_selection)
        self.show_items()

    @property
    def selected_keys(self) -> set[int]:
        """Key of the selected result."""
        return {self._compared.selected}

    def select_keys(self, keys: Sequence[int]) -> None:
        """Select a result, or what is shown now."""
        self._compared.select_row(next(iter(keys), CURRENT_KEY))

    def remove_selected(self) -> None:
        """Remove the ground truth."""
        if self._compared.selected == TRUTH_KEY:
            self._compared.remove_truth()

    def update_rows(self) -> None:
        """Show the results with lengths in the unit of the image, or in px or voxels."""
        compared, image = self._compared, self._session.image
        size = PixelSize((1.0, 1.0), "px")
        if image is not None and compared.in_volume:
            known = preferred_pixel_size(image.spacing, image.unit)
            size = known if known.unit else PixelSize(known.spacing, tr("voxels"), known.factor)
        self.rows.update_items(compared.rows.values(), size)


class ComparePanel(QWidget):
    """Panel of the comparison; `load` and `export` ask for a file, `jump` shows a difference on the canvas."""

    def __init__(
        self,
        session: Session,
        compared: ComparedResults,
        load: Callback,
        export: Callback,
        jump: Callable[[Difference], object],
    ) -> None:
        super().__init__()
        self._session, self._compared, self._jump = session, compared, jump
        self._last_shown: tuple[tuple[Difference, ...], int] = ((), 0)
        self.table, self.summary = ResultTable(session, compared), create_wrapped_label(dim=True)
        self.setFocusProxy(self.table)
        self.remove = add_menu_action(
            self.table, tr("Remove"), compared.remove_truth, tr("Compare with what is shown now instead.")
        )
        self.load = create_wide_button(tr("Ground truth…"), load)
        self.load.setToolTip(tr("Read a mask or contours from a file as the reference."))
        self.export = create_wide_button(tr("Export table…"), export)
        self.holes = QCheckBox(tr("Inner contours are holes"))
        self.holes.setToolTip(tr("Otherwise everything inside a contour belongs to the object."))
        self.holes.toggled.connect(compared.set_holes)
        self._tolerance = QLabel()
        self.tolerance = MarkedSlider(0.25, 10.0, 0.25, DEFAULT_TOLERANCE)
        self.tolerance.setAccessibleName(tr("Tolerance"))
        self.tolerance.moved_to.connect(compared.set_tolerance)
        self.tolerance.moved_to.connect(self._show_comparison)
        self.tolerance.restored.connect(lambda: self.tolerance.move_to(DEFAULT_TOLERANCE))
        how = QWidget()
        fill_layout(QVBoxLayout(how), self._tolerance, self.tolerance, self.holes, spacing=6)
        files = fill_layout(QHBoxLayout(), self.load, self.export, spacing=6)
        parts = (
            self.table,
            self.summary,
            ActionButton("next_difference"),
            files,
            FoldableSection(tr("How it is compared"), how),
        )
        fill_layout(QVBoxLayout(self), *parts, margins=(12, 8, 12, 8), spacing=7, wide=self.table)
        compared.changed.connect(self._show_comparison)
        compared.selection_changed.connect(self._show_comparison)
        self._show_comparison()

    def sizeHint(self) -> QSize:
        """Return a size as wide as the other panels."""
        return QSize(320, 380)

    @property
    def result_records(self) -> list[dict[str, float | str | None]]:
        """All values of all results, by the names of the columns."""
        table = self.table.rows
        return [{column.name: column.value(row) for column in table.columns} for row in table.items]

    def jump_to_next(self) -> None:
        """Show the next difference; after the last one, the largest again."""
        found = self._session.scene.differences
        known, place = self._last_shown
        place = place if known is found else 0
        if found:
            self._jump(found[place % len(found)])
            self._last_shown = found, place + 1

    # Internal

    def _show_comparison(self) -> None:
        compared = self._compared
        self.load.setEnabled(self._session.image is not None)
        self.remove.setEnabled(compared.selected == TRUTH_KEY)
        self.export.setEnabled(bool(compared.agreements))
        tolerance = tr("Tolerance: {tolerance:g} voxels") if compared.in_volume else tr("Tolerance: {tolerance:g} px")
        self._tolerance.setText(tolerance.format(tolerance=compared.tolerance))
        self.tolerance.show_value(compared.tolerance)
        self.holes.setVisible(not compared.in_volume)
        with QSignalBlocker(self.holes):
            self.holes.setChecked(compared.holes)
        self.summary.setText(self._describe_subject())

    def _describe_subject(self) -> str:
        """Describe how the selected result differs from the reference, or what the user can do."""
        compared, different = self._compared, self._session.scene.differences
        subject = compared.rows[compared.subject]
        if subject.key == compared.reference:
            return tr("Select a run to compare it with what is shown now, or open a ground truth.")
        agreed = compared.agreements.get(subject.key)
        if agreed is None:
            return tr("Nothing found yet.") if subject.found is None else tr("Comparing…")
        if not different:
            return tr("{name} agrees with the reference within the tolerance.", name=subject.title)
        missing, farthest = sum(each.kind == "missing" for each in different), different[0].farthest
        unit = (getattr(agreed, "unit", None) or tr("voxels")) if compared.in_volume else "px"
        return tr(
            "{name}: {missing} missing and {wrong} wrong segments; the largest distance is {farthest}.",
            name=subject.title,
            missing=missing,
            wrong=len(different) - missing,
            farthest=tr("infinite") if math.isinf(farthest) else localize_number(f"{farthest:.1f} {unit}"),
        )
