"""Plots of a run over its steps, and their axes."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any, Literal

import numpy as np

from cpm_app.model.display.page_rows import PageRow
from cpm_app.model.text.language import tr
from cpm_core.model import EPSILON_BOUND
from cpm_core.numerics import Array
from cpm_core.numerics.types import Integers, frozen, record


@record
class RunMetrics:
    """Metrics of the run so far: arrays of equal length, one entry a step, NaN for what a method does not measure.

    Attributes
    ----------
    step : ndarray, shape (K,)
        Step.
    epsilon : ndarray, shape (K,)
        Eq. (23) [px of the scale]; NaN while it is not known.
    count, born, deleted : ndarray, shape (K,)
        Particles, and numbers of particles inserted and deleted in the step.
    kinetic : ndarray, shape (K,)
        Kinetic energy of all particles [px^2 / unit of time^2].
    scale : ndarray, shape (K,)
        Scale; 0 is the image itself.
    numbered : ndarray, shape (K,)
        Identity of the next particle.
    """

    step: Array
    epsilon: Array
    count: Array
    born: Array
    deleted: Array
    kinetic: Array
    scale: Array
    numbered: Array

    @property
    def marks(self) -> Array:
        """The steps at which a finer scale has begun."""
        return self.step[1:][np.diff(self.scale) != 0]


@record
class PageMetrics:
    """Objects over the pages of a stack: area and mean gray value by track; `marks` is the page that is open."""

    step: Array
    marks: Array
    areas: Mapping[int, Array]
    grays: Mapping[int, Array]

    @classmethod
    def from_rows(
        cls, rows: Sequence[PageRow], count: int, open_page: int, factor: float, interval: float | None
    ) -> PageMetrics:
        """Collect the metrics of a table of `count` pages; `factor` converts lengths from the unit of the image.

        Where the `interval` of the pages [s] is known, they are over the time.
        """
        areas: dict[int, Array] = defaultdict(lambda: np.full(count, np.nan))
        grays: dict[int, Array] = defaultdict(lambda: np.full(count, np.nan))
        for row in rows:
            if row.measures is not None and row.measures.closed:
                areas[row.track][row.page - 1] = row.measures.net_area_in_units * factor**2
                grays[row.track][row.page - 1] = np.nan if row.gray is None else row.gray
        first, step = (1.0, 1.0) if interval is None else (0.0, interval)
        places: Array = first + step * np.arange(count, dtype=np.float64)
        return cls(places, places[open_page - 1 : open_page], areas, grays)


Metrics = RunMetrics | PageMetrics
"""Values plotted over the steps, or over the pages; vertical lines are drawn at the marks."""


@frozen
class PlotCurve:
    """One curve: its title, its values, and its colors on a light background and on a dark one."""

    title: str
    get_values: Callable[[Any], Array]
    colors: tuple[str, str]


@frozen
class Plot:
    """Curves over one `axis`, what they mean, and a value where a line is drawn; values of `points` are marked."""

    tip: str
    curves: tuple[PlotCurve, ...]
    kind: Literal["logarithmic", "from zero", "free"] = "from zero"
    line: float | None = None
    points: bool = False
    axis: str = ""


# Hues after Okabe and Ito, each darkened for a light background and lightened for a dark one.
_CURVE_BLUE = ("#0072b2", "#56b4e9")
_CURVE_ORANGE = ("#c2410c", "#ff9d1e")
_CURVE_GREEN = ("#00785a", "#2bd4a4")
_CURVE_PURPLE = ("#7c4fd6", "#b48cff")
_CURVE_PINK = ("#b5307f", "#ff7ac6")

PLOTS = (
    Plot(
        tr("How much the particles still move (ε of eq. (23)); below the dashed line the run may come to rest."),
        (PlotCurve(tr("ε"), lambda metrics: metrics.epsilon, _CURVE_ORANGE),),
        "logarithmic",
        EPSILON_BOUND,
    ),
    Plot(
        tr("Kinetic energy of all particles."),
        (PlotCurve(tr("kinetic energy"), lambda metrics: metrics.kinetic, _CURVE_GREEN),),
        "logarithmic",
    ),
    Plot(
        tr("Number of particles."),
        (PlotCurve(tr("particles"), lambda metrics: metrics.count, _CURVE_BLUE),),
    ),
    Plot(
        tr("Particles inserted and deleted in each step."),
        (
            PlotCurve(tr("inserted"), lambda metrics: metrics.born, _CURVE_BLUE),
            PlotCurve(tr("deleted"), lambda metrics: metrics.deleted, _CURVE_PINK),
        ),
    ),
)
"""All plots, from top to bottom."""

_TRACK_COLORS = (
    *(_CURVE_ORANGE, _CURVE_BLUE, _CURVE_GREEN, _CURVE_PURPLE, _CURVE_PINK),
    *(("#8a6d00", "#e6d34a"), ("#475569", "#cbd5e1"), ("#7c2d12", "#d6a37c"), ("#0f766e", "#7dd3d8")),
    ("#4d7c0f", "#a3e635"),
)
"""Colors of the objects that are plotted, none twice."""

_MAX_CURVES = len(_TRACK_COLORS)
"""Largest number of objects that are plotted; the user selects them in the table."""


def select_plotted_tracks(rows: Sequence[PageRow], selected: Collection[int]) -> Integers:
    """Return the tracks that are plotted: the selected ones, or else the first."""
    return tuple(sorted(selected or {row.track for row in rows if row.track})[:_MAX_CURVES])


def build_page_plots(tracks: Sequence[int], area: str, axis: str) -> tuple[Plot, ...]:
    """Build the plots of area, with this title, and mean gray value of tracks over the pages, or times, of a stack."""

    def build_curve(title: str, name: Literal["areas", "grays"], track: int) -> PlotCurve:
        words = f"{title} {track}" if track == tracks[0] else str(track)
        return PlotCurve(words, lambda metrics: getattr(metrics, name)[track], _TRACK_COLORS[tracks.index(track)])

    gray = tr("Mean gray")
    return (
        Plot("", tuple(build_curve(area, "areas", track) for track in tracks), points=True),
        Plot("", tuple(build_curve(gray, "grays", track) for track in tracks), "free", points=True, axis=axis),
    )
