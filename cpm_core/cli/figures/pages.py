"""What a page of the gallery shows, free of how it is drawn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from cpm_core.cli.figures.runs import Facts
from cpm_core.contours.contour import Contour
from cpm_core.numerics.types import Array


@dataclass(frozen=True, eq=False)
class Picture:
    """An image with what lies on it.

    Attributes
    ----------
    title : str
        What it shows.
    values : ndarray, shape (H, W)
        Gray levels.
    particles : ndarray, shape (N, 2), optional
        Particles or starting points [px].
    contours : sequence of Contour
        Contours [px].
    field : ndarray, shape (2, H, W), optional
        Vectors to draw as arrows.
    caption : sequence of str
        Lines below it.
    facts : mapping, optional
        Its measured figures.
    span : int
        Columns that it is wide.
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
    """A figure from 0 to 1 over the values of two parameters: `values` has a row for each y."""

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
    """Panels in rows.

    Attributes
    ----------
    rows : sequence of sequence of Panel or None
        From top to bottom and from left to right; None leaves a place empty.
    note : str
        What is measured besides the figures of the panels.
    alike : bool
        Whether its results are alike, so that one sentence can give their figures.
    words : mapping
        What the legend says here instead of its usual words.
    """

    rows: Sequence[Sequence[Panel | None]]
    note: str = ""
    alike: bool = True
    words: Mapping[str, str] = field(default_factory=dict)

    @property
    def panels(self) -> list[Panel]:
        """All of them, row by row."""
        return [panel for row in self.rows for panel in row if panel is not None]
