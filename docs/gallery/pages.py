"""Content of a page of the gallery, without its layout."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from cpm_core.contours.contour import Contour
from cpm_core.numerics.types import Array
from docs.gallery.runs import Facts


@dataclass(frozen=True, eq=False)
class Picture:
    """An image with overlays: particles or seeds (N, 2) and contours, all in px, and arrows of a field (2, H, W).

    `caption` are the lines below it, `facts` its measured values, `span` its width in columns of the page.
    """

    title: str
    values: Array
    particles: Array | None = None
    contours: Sequence[Contour] = ()
    field: Array | None = None
    caption: Sequence[str] = ()
    facts: Facts | None = None
    span: int = 1


@dataclass(frozen=True, eq=False)
class Stairs:
    """Whole numbers over the values of a parameter, one line for each series."""

    title: str
    x: Sequence[float]
    series: Mapping[str, Sequence[int]]
    x_label: str
    y_label: str
    facts: Facts | None = None
    span: int = 1


@dataclass(frozen=True, eq=False)
class Map:
    """A quantity from 0 to 1 over the values of two parameters: `values` has a row for each y."""

    title: str
    values: Array
    x: Sequence[float]
    y: Sequence[float]
    x_label: str
    y_label: str
    facts: Facts | None = None
    span: int = 1


Panel = Picture | Stairs | Map


@dataclass(frozen=True, eq=False)
class Page:
    """Rows of panels from top to bottom; None leaves a place empty.

    `note` is a result in addition to those of the panels. `alike` is whether one sentence can summarize the results of
    all panels. `words` replaces the usual words of the legend.
    """

    rows: Sequence[Sequence[Panel | None]]
    note: str = ""
    alike: bool = True
    words: Mapping[str, str] = field(default_factory=dict)

    @property
    def panels(self) -> list[Panel]:
        """All of them, row by row."""
        return [panel for row in self.rows for panel in row if panel is not None]
