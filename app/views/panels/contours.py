"""The panel of the contours: the table, with review buttons next to it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from PySide6.QtGui import QColor, QFont, QGuiApplication, QPalette
from PySide6.QtWidgets import QComboBox, QMenu

from app.model.display.lengths import shown_in
from app.model.text.language import tr
from app.session.features.contour_review import ContourReview
from app.session.scene import Item
from app.views.panels.tables import (
    Column,
    ItemTable,
    Role,
    Selection,
    TableModel,
    TablePanel,
    button_grid,
    menu_button,
    wide_button,
)
from app.views.theme import theme
from app.views.theme.icons import swatch
from cpm_core.contours import Reached

VERDICTS = {"kept": tr("✓ kept"), "rejected": tr("✗ rejected"), "": "–"}
_ORDER = {"kept": 0.0, "": 1.0, "rejected": 3.0}

REACHED: Mapping[Reached, str] = {
    "flight": tr("in free flight"), "weak": tr("beyond a weak edge"), "junction": tr("over a junction"),
    "launched": tr("inserted elsewhere"), "": "–",
}  # fmt: skip
"""Words for the ways in which particles come to a contour, the nearest first."""


COLUMNS: tuple[Column[Item], ...] = (
    Column("number", tr("#"), tr("Number; it stays with the contour through sliders and runs."),
           lambda item: item.measures.number, "0000", form=".0f"),
    Column("name", tr("Name"), tr("Name and color; double-click or press {key:name_contour} to rename."),
           lambda item: item.contour.name, "left ventricle"),
    Column("verdict", tr("Verdict"),
           tr("{key:keep} keeps, {key:reject} rejects. Kept contours stay through sliders and runs; rejected "
              "ones are not exported."),
           lambda item: VERDICTS[item.reviewed.verdict], "✗ rejected", key=lambda item: _ORDER[item.reviewed.verdict]),
    Column("kind", tr("Kind"), tr("Closed, or open with two ends."),
           lambda item: tr("closed") if item.contour.closed else tr("open"), "closed"),
    Column("length", tr("Length [{unit}]"), tr("Length along the contour."),
           lambda item: item.measures.length_in_units, "000,000", 1),
    Column("area", tr("Area [{unit}²]"), tr("Gross area: all that it encloses, including contours inside."),
           lambda item: item.measures.area_in_units if item.contour.closed else None, "00,000,000", 2),
    Column("strength", tr("Strength"), tr("Mean edge strength along the contour [gray levels/px]."),
           lambda item: item.measures.strength, "000.0"),
    Column("inside", tr("Inside"), tr("Number of the closed contour that encloses it."),
           lambda item: item.measures.inside or None, "0000", form=".0f"),
    Column("junctions", tr("Junctions"), tr("Number of ends at which it meets other contours."),
           lambda item: None if item.contour.closed else item.measures.junctions, "0", form=".0f"),
    Column("contrast", tr("Contrast"), tr("Contrast between both sides, 0 to 1; measured at rest."),
           lambda item: item.measures.contrast, "0.00", form=".2f"),
    Column("by_hand", tr("By hand [{unit}]"), tr("Length that was drawn by hand."),
           lambda item: item.measures.by_hand * item.measures.length_in_units
           / item.measures.length if item.contour.by_hand else None, "000.0", 1),
    Column("reached", tr("Reached"), tr("How particles came to it: in free flight from the start, beyond a weak edge, "
           "along edges over a junction, or by being inserted elsewhere."), lambda item: REACHED[item.contour.reached],
           "beyond a weak edge", key=lambda item: float(list(REACHED).index(item.contour.reached))),
)  # fmt: skip
"""All columns in the order shown."""


class ContourTable(ItemTable):
    """Shows the contours of a review, selects, names and rejects them."""

    def __init__(self, review: ContourReview) -> None:
        self._review = review
        self._verdict: str | None = None
        rows = TableModel[Item](COLUMNS, lambda item: item.key, _look, review.rename)
        selection = Selection(
            "contour",
            self._refresh,
            review.hover,
            review.select,
            lambda: review.selected,
            partial(review.judge, "rejected"),
        )
        super().__init__(rows, selection, tr("Contours"))
        review.changed.connect(self.show_items)
        review.selection_changed.connect(self.show_selection)

    def show_only(self, verdict: str | None) -> None:
        """Show the contours with a verdict (empty for the undecided ones), or all for None."""
        self._verdict = verdict
        self.show_items()

    def _refresh(self) -> None:
        items, result = self._review.items, self._review.result
        shown = (item for item in items if self._verdict in (None, item.reviewed.verdict))
        self.rows.update(shown, None if result is None else shown_in(result.spacing, result.unit))


def _look(item: Item, role: int, of_name: bool) -> Any:
    """The color of a contour next to its name; rejected ones are pale, their names struck out."""
    match role:
        case Role.DecorationRole if of_name:
            return swatch(item.contour.color or theme.CONTOUR)
        case Role.ForegroundRole if item.reviewed.rejected:
            return QColor(QGuiApplication.palette().color(QPalette.ColorRole.PlaceholderText))
        case Role.FontRole if item.reviewed.rejected:
            font = QFont()
            font.setStrikeOut(of_name)
            return font
    return None


_SHOWN: tuple[tuple[str, str | None], ...] = (
    (tr("All contours"), None),
    (tr("Kept"), "kept"),
    (tr("Rejected"), "rejected"),
    (tr("Undecided"), ""),
)
"""What the table can be limited to: texts and verdicts."""


class ContourPanel(TablePanel[ContourTable]):
    """Shows the contours and their review; `fill_colors` fills a menu with the colors on offer."""

    def __init__(self, review: ContourReview, fill_colors: Callable[[QMenu], None]) -> None:
        table = ContourTable(review)
        super().__init__(table)
        self._review = review
        self.shown = QComboBox()
        self.shown.setAccessibleName(tr("Contours in the table"))
        self.shown.setToolTip(tr("Which contours the table shows."))
        for text, verdict in _SHOWN:
            self.shown.addItem(text, verdict)
        self.shown.currentIndexChanged.connect(lambda _: table.show_only(self.shown.currentData()))
        self.buttons = {
            "keep": wide_button(tr("✓ Keep"), partial(review.judge, "kept")),
            "reject": wide_button(tr("✗ Reject"), partial(review.judge, "rejected")),
            "name": wide_button(tr("Name…"), table.name_selected),
            "colour": menu_button(tr("Color"), fill_colors),
        }
        self.add(self.shown, button_grid(self.buttons.values()))
        review.changed.connect(self._show)
        review.selection_changed.connect(self._enable)
        self._show()

    def _show(self) -> None:
        items = self._review.items
        closed = sum(item.contour.closed for item in items)
        verdicts = Counter(item.reviewed.verdict for item in items)
        summary = tr("{closed} closed, {open} open; {kept} kept, {rejected} rejected, {undecided} undecided.").format(
            closed=closed,
            open=len(items) - closed,
            kept=verdicts["kept"],
            rejected=verdicts["rejected"],
            undecided=verdicts[""],
        )
        self.summary.setText(summary if items else tr("No contours yet. Start the run."))
        self._enable()

    def _enable(self) -> None:
        for button in self.buttons.values():
            button.setEnabled(bool(self._review.selected))
