"""The columns of the table of all pages: the text of each and its sort key."""

from __future__ import annotations

from collections.abc import Callable

from app.model.display.page_rows import PageRow
from app.model.text.language import tr, written
from app.views.panels.item_table.columns import NONE, Column, number_text, place
from cpm_core.contours.measurements import Measures


def _measured(of: Callable[[Measures], float | None]) -> tuple[Callable[[PageRow], str], Callable[[PageRow], float]]:
    """Text and sort key of a measure, which a row without a contour has not."""

    def value(row: PageRow) -> float:
        found = None if row.measures is None else of(row.measures)
        return -1.0 if found is None else found

    def text(row: PageRow) -> str:
        return NONE if value(row) < 0.0 else number_text(value(row))

    return text, value


def _kind(row: PageRow) -> str:
    if row.measures is None:
        return NONE
    return tr("closed") if row.measures.closed else tr("open")


_area = _measured(lambda measures: measures.area_in_units if measures.closed else None)
_net = _measured(lambda measures: measures.net_area_in_units if measures.closed else None)
_length = _measured(lambda measures: measures.length_in_units)
_strength = _measured(lambda measures: measures.strength)
_contrast = _measured(lambda measures: measures.contrast)


def _center(of: Callable[[PageRow], float]) -> Callable[[PageRow], str]:
    return lambda row: NONE if row.measures is None else written(f"{of(row):.1f}")


COLUMNS: tuple[Column[PageRow], ...] = (
    Column("page", tr("Page"), tr("Page of the stack; a double click goes to it."), lambda r: str(r.page),
           lambda r: r.page, "0000"),
    Column("track", tr("Track"), tr("Number of the object, which it keeps from page to page."),
           lambda r: str(r.track) if r.track else NONE, lambda r: r.track, "0000"),
    Column("happens", tr("What happens"), tr("What happens to the object here, or why the page could not be used."),
           lambda r: r.happens, lambda r: r.happens.casefold() or "\uffff", "splits off track 12", False),
    Column("kind", tr("Kind"), tr("Closed, or open with two ends."), _kind, _kind, "closed", False),
    Column("area", tr("Area [{unit}²]"), tr("Gross area: all that it encloses, including contours inside."), *_area,
           "00,000,000", power=2),
    Column("length", tr("Length [{unit}]"), tr("Length along the contour: the perimeter of a closed one."), *_length,
           "000,000", power=1),
    Column("row", tr("Row [px]"), tr("Row of the center of its area, of an open contour of its length."),
           _center(lambda r: r.row), lambda r: r.row, "0000.0"),
    Column("col", tr("Column [px]"), tr("Column of the center of its area, of an open contour of its length."),
           _center(lambda r: r.col), lambda r: r.col, "0000.0"),
    Column("net", tr("Net area [{unit}²]"), tr("Area without the closed contours in it, as in label stacks."), *_net,
           "00,000,000", power=2),
    Column("strength", tr("Strength"), tr("Mean edge strength along the contour [gray levels/px]."), *_strength,
           "000.0"),
    Column("contrast", tr("Contrast"), tr("Contrast between both sides, 0 to 1."), *_contrast, "0.00"),
)  # fmt: skip
"""All columns in the order shown."""

HAPPENS = place(COLUMNS, "happens")
"""Index of the column that takes the remaining width."""
