"""The columns of the contour table: the text of each and its sort key."""

from __future__ import annotations

from collections.abc import Mapping

from app.model.text.language import tr, written
from app.session.scene import Item
from app.views.panels.item_table.columns import Column, number_text, place
from cpm_core.contours.contour import Reached

VERDICTS = {"kept": tr("✓ kept"), "rejected": tr("✗ rejected"), "": "–"}
REACHED: Mapping[Reached, str] = {
    "flight": tr("in free flight"), "weak": tr("beyond a weak edge"), "junction": tr("over a junction"),
    "launched": tr("inserted elsewhere"), "": "–",
}  # fmt: skip
"""Words for the ways in which particles come to a contour, the nearest first."""

_ORDER = {"kept": 0, "": 1, "rejected": 3}


def _verdict(item: Item) -> str:
    return VERDICTS[item.reviewed.verdict]


def _ends(item: Item) -> str:
    return str(item.measures.junctions) if not item.contour.closed else "–"


def _contrast(item: Item) -> str:
    contrast = item.measures.contrast
    return "–" if contrast is None else written(f"{contrast:.2f}")


def _by_hand(item: Item) -> float:
    """Length drawn by hand, in the unit of the image."""
    measures = item.measures
    return measures.by_hand * (measures.length_in_units / measures.length if measures.length else 1.0)


COLUMNS: tuple[Column[Item], ...] = (
    Column("number", tr("#"), tr("Number; it stays with the contour through sliders and runs."),
           lambda i: str(i.measures.number), lambda i: i.measures.number, "0000"),
    Column("name", tr("Name"), tr("Name and color; double-click or press {key:name_contour} to rename."),
           lambda i: i.contour.name, lambda i: i.contour.name.casefold() or "\uffff", "left ventricle", False),
    Column("verdict", tr("Verdict"),
           tr("{key:keep} keeps, {key:reject} rejects. Kept contours stay through sliders and runs; rejected "
              "ones are not exported."),
           _verdict, lambda i: _ORDER[i.reviewed.verdict], "✗ rejected", False),
    Column("kind", tr("Kind"), tr("Closed, or open with two ends."),
           lambda i: tr("closed") if i.contour.closed else tr("open"), lambda i: float(not i.contour.closed), "closed",
           False),
    Column("length", tr("Length [{unit}]"), tr("Length along the contour."),
           lambda i: number_text(i.measures.length_in_units), lambda i: i.measures.length_in_units, "000,000",
           power=1),
    Column("area", tr("Area [{unit}²]"), tr("Gross area: all that it encloses, including contours inside."),
           lambda i: number_text(i.measures.area_in_units) if i.contour.closed else "–",
           lambda i: i.measures.area_in_units, "00,000,000", power=2),
    Column("strength", tr("Strength"), tr("Mean edge strength along the contour [gray levels/px]."),
           lambda i: number_text(i.measures.strength), lambda i: i.measures.strength, "000.0"),
    Column("inside", tr("Inside"), tr("Number of the closed contour that encloses it."),
           lambda i: str(i.measures.inside) if i.measures.inside else "–", lambda i: i.measures.inside, "0000"),
    Column("junctions", tr("Junctions"), tr("Number of ends at which it meets other contours."), _ends,
           lambda i: i.measures.junctions, "0"),
    Column("contrast", tr("Contrast"), tr("Contrast between both sides, 0 to 1; measured at rest."),
           _contrast, lambda i: -1.0 if i.measures.contrast is None else i.measures.contrast, "0.00"),
    Column("by_hand", tr("By hand [{unit}]"), tr("Length that was drawn by hand."),
           lambda i: number_text(_by_hand(i)) if i.contour.by_hand else "–", _by_hand, "000.0", power=1),
    Column("reached", tr("Reached"), tr("How particles came to it: in free flight from the start, beyond a weak edge, "
           "along edges over a junction, or by being inserted elsewhere."), lambda i: REACHED[i.contour.reached],
           lambda i: float(list(REACHED).index(i.contour.reached)), "beyond a weak edge", False),
)  # fmt: skip
"""All columns in the order shown."""

NAME = place(COLUMNS, "name")
"""Index of the column of names."""
