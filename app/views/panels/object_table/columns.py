"""The columns of the table of objects: the text of each and its sort key."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from app.model.document.objects import class_title
from app.model.text.language import tr, written
from app.session.features.object_list import Figures
from app.views.panels.item_table.columns import NONE, Column, number_text
from cpm_core.objects.segmented.segmented_object import SegmentedObject, SegmentedObjects


@dataclass(frozen=True, eq=False, slots=True)
class Row:
    """An object with what its row is made from: all objects, the size of a pixel, and figures once they are known.

    `factor` is how many of the unit that is shown one of the image is.
    """

    item: SegmentedObject
    objects: SegmentedObjects
    spacing: tuple[float, ...]
    figures: Figures | None
    factor: float = 1.0

    @property
    def area(self) -> float:
        """Net area in the square of the unit of the size of a pixel."""
        return self.item.area * self.spacing[0] * self.spacing[1]

    @property
    def gray(self) -> float | None:
        """Mean gray value; None while it is not known."""
        return None if self.figures is None else self.figures.gray

    def figure(self, of: Callable[[Figures], float]) -> float:
        """A figure; less than any other while it is not known."""
        return -math.inf if self.figures is None else of(self.figures)

    @property
    def state(self) -> str:
        """Whether it is frozen or hidden, in words."""
        words = ((self.item.frozen, tr("frozen")), (self.item.hidden, tr("hidden")))
        return ", ".join(word for holds, word in words if holds)


def _gray(row: Row) -> float:
    return -math.inf if row.gray is None or math.isnan(row.gray) else row.gray


def _figure(name: str, title: str, tip: str, of: Callable[[Figures], float], sample: str, power: int) -> Column[Row]:
    """A column of a figure, which is shown once it is known."""

    def value(row: Row) -> float:
        return row.figure(of) * row.factor**power

    def text(row: Row) -> str:
        return NONE if row.figures is None else number_text(value(row)) if power else str(of(row.figures))

    return Column(name, title, tip, text, value, sample)


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
           lambda r: written(f"{r.item.confidence:.2f}"), lambda r: r.item.confidence, "0.00"),
    Column("state", tr("State"), tr("Frozen objects hold particles back and are not found again."),
           lambda r: r.state or "–", lambda r: r.state, "frozen", False),
)  # fmt: skip
"""All columns in the order shown."""

_OF_BODIES: Mapping[str, Column[Row]] = {
    column.name: column
    for column in (
        _figure("area", tr("Volume [{unit}³]"), tr("Volume without hollows."), lambda f: f.volume, "00,000,000", 3),
        _figure("perimeter", tr("Area [{unit}²]"), tr("Area of the surface, that of hollows included."),
                lambda f: f.area, "000,000", 2),
        _figure("gaps", tr("Surfaces"), tr("Number of closed surfaces that bound it: one more for each hollow."),
                lambda f: f.parts, "0,000", 0),
        _figure("confidence", tr("Euler char."),
                tr("Euler characteristic of its surface: 2 for each ball, less by 2 for each handle."),
                lambda f: f.euler, "0.00", 0),
    )
}  # fmt: skip

BODY_COLUMNS: tuple[Column[Row], ...] = tuple(_OF_BODIES.get(column.name, column) for column in OBJECT_COLUMNS)
"""The same columns for objects in a volume."""
