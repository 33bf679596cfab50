"""The columns of the table of objects: the text of each and its sort key."""

from __future__ import annotations

import math
from dataclasses import dataclass

from app.model.document.objects import class_title
from app.model.text.language import tr
from app.views.panels.item_table.columns import Column, number_text
from cpm_core.objects.segmented.segmented_object import SegmentedObject, SegmentedObjects


@dataclass(frozen=True, eq=False, slots=True)
class Row:
    """An object with what its row is made from: all objects, the size of a pixel, and its mean gray value."""

    item: SegmentedObject
    objects: SegmentedObjects
    spacing: tuple[float, ...]
    gray: float | None

    @property
    def area(self) -> float:
        """Net area in the square of the unit of the size of a pixel."""
        return self.item.area * self.spacing[0] * self.spacing[1]

    @property
    def state(self) -> str:
        """Whether it is frozen or hidden, in words."""
        words = ((self.item.frozen, tr("frozen")), (self.item.hidden, tr("hidden")))
        return ", ".join(word for holds, word in words if holds)


def _gray(row: Row) -> float:
    return -math.inf if row.gray is None or math.isnan(row.gray) else row.gray


OBJECT_COLUMNS: tuple[Column[Row], ...] = (
    Column("number", tr("#"), tr("Number; it stays the same."), lambda r: str(r.item.number),
           lambda r: r.item.number, "0000"),
    Column("name", tr("Name"), tr("Name and color; double-click to rename."), lambda r: r.item.name,
           lambda r: r.item.name.casefold() or "\uffff", "left ventricle", False),
    Column("class", tr("Class"), tr("Class; the digits 1 to 9 set it."),
           lambda r: f"{r.item.category}  {class_title(r.objects, r.item.category)}", lambda r: r.item.category,
           "1  nucleus", False),
    Column("area", tr("Net area [{unit}²]"), tr("Area without holes."), lambda r: number_text(r.area),
           lambda r: r.area, "00,000,000"),
    Column("perimeter", tr("Perimeter [{unit}]"), tr("Length of the boundary, that of holes included."),
           lambda r: number_text(r.item.perimeter(r.spacing)), lambda r: r.item.perimeter(r.spacing), "000,000"),
    Column("gray", tr("Mean gray"), tr("Mean gray value inside."),
           lambda r: number_text(_gray(r)) if math.isfinite(_gray(r)) else "–", _gray, "000.0"),
    Column("gaps", tr("Bridged [{unit}]"), tr("Length of the boundary that follows no contour; dashed."),
           lambda r: number_text(r.item.bridged(r.spacing)) if r.item.gaps else "–",
           lambda r: r.item.bridged(r.spacing), "0,000"),
    Column("confidence", tr("Confidence"), tr("How sure the boundary is, from 0 to 1."),
           lambda r: f"{r.item.confidence:.2f}", lambda r: r.item.confidence, "0.00"),
    Column("state", tr("State"), tr("Frozen objects hold particles back and are not found again."),
           lambda r: r.state or "–", lambda r: r.state, "frozen", False),
)  # fmt: skip
"""All columns in the order shown."""
