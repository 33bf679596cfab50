"""Panel of the comparison: a table of results, ways to add to it, and actions on the selected one."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from operator import attrgetter

from PySide6.QtCore import QSignalBlocker, QSize, Qt
from PySide6.QtGui import QAction, QFont
from PySide6.QtWidgets import (
    QCheckBox,
    QHBoxLayout,
    QLabel,
    QMenu,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from cpm_app.model.display.differences import Difference
from cpm_app.model.display.lengths import PixelSize, preferred_pixel_size
from cpm_app.model.text.language import localize_number, tr
from cpm_app.session.features.comparison import CURRENT_KEY, ComparedResults, ComparisonRow
from cpm_app.session.features.timeline_navigation import TimelineNavigation
from cpm_app.session.session import Session
from cpm_app.views.panels.tables import Column, ItemTable, Role, TableModel, create_menu_button, create_wide_button
from cpm_app.views.widgets.actions import add_menu_action
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
               lambda row: f"{row.title} ({row.state})" if row.state else row.title, "Run 1"),
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
    """Table of the results in the order in which they were added; one of them is selected."""

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

    def edit_name(self, row: int) -> None:
        """Use the selected result, on Enter or a double click."""
        if self._compared.rows[self._compared.selected].is_usable:
            self._compared.use_row(self._compared.selected)

    @property
    def selected_keys(self) -> set[int]:
        """Key of the selected result."""
        return {self._compared.selected}

    def select_keys(self, keys: Sequence[int]) -> None:
        """Select a result, or what is shown now."""
        self._compared.select_row(next(iter(keys), CURRENT_KEY))

    def remove_selected(self) -> None:
        """Remove the selected result."""
        self._compared.remove_row(self._compared.selected)

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
        navigation: TimelineNavigation,
        load: Callback,
        export: Callback,
        jump: Callable[[Difference], object],
    ) -> None:
        super().__init__()
        self._session, self._compared, self._navigation = session, compared, navigation
        self._load, self._jump = load, jump
        self._last_shown: tuple[tuple[Difference, ...], int] = ((), 0)
        self.table, self.summary = ResultTable(session, compared), create_wrapped_label(dim=True)
        self.setFocusProxy(self.table)
        self.acts = {
            "use": self._add_result_action(tr("Use this"), lambda: compared.use_row(compared.selected),
                             tr("Go to this run, or add these contours as objects.")),
            "refer": self._add_result_action(tr("Set as reference"), lambda: compared.set_reference(compared.selected),
                                             tr("Compare all others with this result.")),
            "next": self._add_result_action(tr("Next difference"), self.jump_to_next,
                                            tr("Show the differences one after the other, the largest first.")),
            "remove": self._add_result_action(tr("Remove"), lambda: compared.remove_row(compared.selected),
                                              tr("Remove this result.")),
        }  # fmt: skip
        self.add = create_menu_button(tr("Add…"), self._fill_add_menu)
        self.keep = create_wide_button(tr("Keep this result"), compared.keep_current)
        self.keep.setToolTip(tr("Keep what is found now, to compare later results with it."))
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
        self._lay_out_widgets()
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

    def _add_result_action(self, text: str, do: Callback, tip: str) -> QAction:
        """Add an action on the selected result to the menu of the table."""
        return add_menu_action(self.table, text, do, tip)

    def _create_action_button(self, name: str) -> QToolButton:
        button = create_wide_button("")
        button.setDefaultAction(self.acts[name])
        return button

    def _lay_out_widgets(self) -> None:
        how = QWidget()
        fill_layout(QVBoxLayout(how), self._tolerance, self.tolerance, self.holes, spacing=6)
        fill_layout(
            QVBoxLayout(self),
            fill_layout(QHBoxLayout(), self.add, self.keep, spacing=6),
            self.table,
            self.summary,
            fill_layout(
                QHBoxLayout(), self._create_action_button("use"), self._create_action_button("refer"), spacing=6
            ),
            fill_layout(QHBoxLayout(), self._create_action_button("next"), self.export, spacing=6),
            FoldableSection(tr("How it is compared"), how),
            margins=(12, 8, 12, 8),
            spacing=7,
            wide=self.table,
        )

    def _fill_add_menu(self, menu: QMenu) -> None:
        """Fill the menu with what can be added."""
        here = self._navigation.current_step[0]
        branches = [branch for branch in self._navigation.branches if branch.identity != here]
        if branches:
            inner = menu.addMenu(tr("&Run or branch"))
            for branch in branches:
                add = partial(self._compared.add_branch, branch.identity)
                add_menu_action(inner, branch.name.replace("&", "&&"), add)
        add_menu_action(
            menu, tr("&Ground truth…"), self._load, tr("Read a mask or contours from a file as the reference.")
        )

    def _show_comparison(self) -> None:
        compared, has_image = self._compared, self._session.image is not None
        row, different = compared.rows[compared.selected], self._session.scene.differences
        for widget in (self.add, self.keep):
            widget.setEnabled(has_image)
        self.acts["use"].setEnabled(row.is_usable)
        self.acts["refer"].setEnabled(row.key != compared.reference)
        self.acts["remove"].setEnabled(row.key != CURRENT_KEY)
        self.acts["next"].setEnabled(bool(different))
        self.export.setEnabled(len(compared.rows) > 1)
        tolerance = tr("Tolerance: {tolerance:g} voxels") if compared.in_volume else tr("Tolerance: {tolerance:g} px")
        self._tolerance.setText(tolerance.format(tolerance=compared.tolerance))
        self.tolerance.show_value(compared.tolerance)
        self.holes.setVisible(not compared.in_volume)
        with QSignalBlocker(self.holes):
            self.holes.setChecked(compared.holes)
        self.summary.setText(row.state or self._describe_selected_result())

    def _describe_selected_result(self) -> str:
        """Describe how the selected result differs from the reference, or what the user can do."""
        compared, different = self._compared, self._session.scene.differences
        subject = compared.rows[compared.subject]
        if len(compared.rows) == 1:
            return tr("Add a result to compare it with what is shown now.")
        if subject.key == compared.reference:
            return tr("Select a result to see it on the image.")
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
