"""The columns of the table of contours: what each shows and what it is sorted by."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from app.model.text.language import tr
from app.session.scene import Item

VERDICTS = {"kept": tr("✓ kept"), "rejected": tr("✗ rejected"), "": "–"}
_ORDER = {"kept": 0, "": 1, "rejected": 2}


@dataclass(frozen=True, slots=True)
class Column:
    """One column.

    Attributes
    ----------
    name : str
        What it is called in code.
    title, tip : str
        Heading, and what it means; ``{unit}`` stands for the unit of lengths.
    text : callable
        What is shown of an item.
    value : callable
        What an item is sorted by.
    sample : str
        The widest text that is usual.
    figure : bool
        Whether it is a number, which stands at the right.
    """

    name: str
    title: str
    tip: str
    text: Callable[[Item], str]
    value: Callable[[Item], float | str]
    sample: str
    figure: bool = True


def _figure(value: float) -> str:
    """A number with as many digits as a person reads."""
    return f"{value:,.0f}" if value >= 1000 else f"{value:.3g}" if value < 100 else f"{value:.0f}"


def _ends(item: Item) -> str:
    return str(item.measures.junctions) if not item.contour.closed else "–"


def _contrast(item: Item) -> str:
    contrast = item.measures.contrast
    return "–" if contrast is None else f"{contrast:.2f}"


COLUMNS: tuple[Column, ...] = (
    Column("number", tr("#"), tr("Number, longest first."), lambda i: str(i.measures.number),
           lambda i: i.measures.number, "0000"),
    Column("name", tr("Name"), tr("Name and color; double click or F2 to write one."), lambda i: i.contour.name,
           lambda i: i.contour.name.casefold() or "\uffff", "left ventricle", False),
    Column("verdict", tr("Verdict"), tr("K keeps, X rejects; rejected contours are not exported."),
           lambda i: VERDICTS[i.reviewed.verdict], lambda i: _ORDER[i.reviewed.verdict], "✗ rejected ", False),
    Column("kind", tr("Kind"), tr("Closed, or open with two ends."),
           lambda i: tr("closed") if i.contour.closed else tr("open"), lambda i: float(not i.contour.closed), "closed",
           False),
    Column("length", tr("Length [{unit}]"), tr("Length along the contour."),
           lambda i: _figure(i.measures.length_in_units), lambda i: i.measures.length_in_units, "000,000"),
    Column("area", tr("Area [{unit}²]"), tr("Area enclosed, that of contours inside included."),
           lambda i: _figure(i.measures.area_in_units) if i.contour.closed else "–",
           lambda i: i.measures.area_in_units, "00,000,000"),
    Column("strength", tr("Strength"), tr("Mean edge strength along it, in gray levels per px."),
           lambda i: _figure(i.measures.strength), lambda i: i.measures.strength, "000.0"),
    Column("inside", tr("Inside"), tr("Number of the closed contour that it lies in."),
           lambda i: str(i.measures.inside) if i.measures.inside else "–", lambda i: i.measures.inside, "0000"),
    Column("junctions", tr("Junctions"), tr("Ends that lie where contours meet."), _ends,
           lambda i: i.measures.junctions, "0"),
    Column("contrast", tr("Contrast"), tr("Contrast of the regions on both sides, 0 to 1; measured at rest."),
           _contrast, lambda i: -1.0 if i.measures.contrast is None else i.measures.contrast, "0.00"),
)  # fmt: skip
"""All columns in the order shown."""

NAME = next(index for index, column in enumerate(COLUMNS) if column.name == "name")
"""Where names stand."""
