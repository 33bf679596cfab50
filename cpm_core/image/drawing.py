"""Drawing on axes of matplotlib, which is imported only when something is drawn: images, contours, scale bars."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np

from cpm_core.numerics.packages import has_package, require_package
from cpm_core.numerics.types import Array, Extent, Pixels, frozen
from cpm_core.parameters.formatting import quote_value

if TYPE_CHECKING:
    from matplotlib.axes import Axes as Axes  # noqa: PLC0414 - for the annotations of other modules
    from matplotlib.figure import Figure

PARTICLE_COLOR = "#f0e442"
"""Color of particles, as in the window: a hue of Okabe and Ito that color-blind people can tell from the others."""

CLOSED_CURVE_COLOR = "#56b4e9"
"""Color of closed curves."""

OPEN_CURVE_COLOR = "#ff9d1e"
"""Color of open curves."""

HALO_COLOR = "#101216"
"""Color around lines and dots, so that they can be seen on any gray."""

DARKEST_SHOWN = 0.1
"""Brightness at which the lowest gray levels are shown, so that lines and their halos are visible on them."""

BRIGHTEST_SHOWN = 0.86
"""Brightness at which the highest gray levels are shown."""

EXTREME_PERCENTILES = (0.2, 99.8)
"""Percentiles of the gray levels that count as their extremes."""

_DOT_SIZES = ((700, 5.0), (2500, 2.5), (np.inf, 0.5))
"""Largest number of particles on a picture, and area of their dots [pt²]; the smallest dots have no halo."""

_MAX_BAR_SHARE = 0.3
"""Largest length of a scale bar, as a share of the width of the image."""

TEXT_BOX_STYLE = {"facecolor": HALO_COLOR, "edgecolor": "none", "alpha": 0.6, "pad": 1.5}
"""Style of the box behind texts, so that they are readable on any gray; outlined texts would be no texts in SVG."""

_FIGURE_DPI = 200
"""Resolution of the figure of a file [dots per inch]."""

_NOTEBOOK_DPI = 80
"""Resolution of the figure in a notebook [dots per inch]."""

_FIGURE_SIDE = 6.0
"""Longer side of the figure of a file [inches]."""

FIGURE_FORMATS = {".svg": "svg", ".png": "png", ".pdf": "pdf"}
"""Suffix of a figure -> name of its format in matplotlib."""


class DrawableCurve(Protocol):
    """Line that can be drawn."""

    @property
    def path(self) -> Array:
        """Vertices, shape (K, 2), the first repeated at the end where the line is closed [px]."""

    @property
    def closed(self) -> bool:
        """Whether the line is closed."""

    @property
    def color(self) -> str:
        """Color, ``"#rrggbb"``; empty for the default one."""


def curve_color(curve: DrawableCurve) -> str:
    """Return the color in which a curve is drawn."""
    return curve.color or (CLOSED_CURVE_COLOR if curve.closed else OPEN_CURVE_COLOR)


def axes_for(ax: Axes | None, *, space: bool = False) -> Axes:
    """Return the given axes, or those of a new figure; with `space` they have three dimensions."""
    if ax is not None:
        if not hasattr(ax, "plot_trisurf" if space else "imshow"):
            wanted = 'axes of matplotlib in space (projection="3d")' if space else "axes of matplotlib"
            raise ValueError(f"ax is {quote_value(ax)} but must be {wanted}, or None for a new figure.")
        return ax
    require_package("matplotlib", "A figure")
    from matplotlib import pyplot

    return pyplot.subplots(subplot_kw={"projection": "3d"} if space else {})[1]


def show_image(ax: Axes, values: Array, spacing: Sequence[float] = (1.0, 1.0), colors: Pixels | None = None) -> None:
    """Show gray levels, shape (H, W), or colors, shape (H, W, 3), in px: row 0 on top, pixels in their proportions."""
    rows, cols = values.shape[:2]
    if colors is not None:
        ax.imshow(colors, interpolation="nearest")
    else:
        darkest, brightest = gray_limits(values)
        ax.imshow(values, cmap="gray", vmin=darkest, vmax=brightest, interpolation="nearest")
    frame_axes(ax, (rows, cols), spacing)


def gray_limits(values: Array) -> tuple[float, float]:
    """Return the gray levels, of values of any shape, that are shown as black and as white."""
    low, high = np.percentile(values, EXTREME_PERCENTILES)
    unit = max(high - low, 1e-300) / (BRIGHTEST_SHOWN - DARKEST_SHOWN)
    return low - DARKEST_SHOWN * unit, high + (1.0 - BRIGHTEST_SHOWN) * unit


def frame_axes(ax: Axes, shape: Extent, spacing: Sequence[float] = (1.0, 1.0)) -> None:
    """Set the limits of axes to an image of this shape, without ticks and a box."""
    ax.set(xlim=(-0.5, shape[1] - 0.5), ylim=(shape[0] - 0.5, -0.5), xticks=[], yticks=[])
    ax.set_aspect(float(spacing[0]) / float(spacing[1]))
    for spine in ax.spines.values():
        spine.set_visible(False)


def show_curves(ax: Axes, curves: Sequence[DrawableCurve]) -> None:
    """Show lines with a dark halo: closed ones in blue, open ones in orange, or in a color of their own."""
    from matplotlib.collections import LineCollection

    paths = [curve.path[:, ::-1] for curve in curves]
    for colors, thickness in ((HALO_COLOR, 2.6), ([curve_color(curve) for curve in curves], 1.5)):
        style = {"colors": colors, "linewidths": thickness, "capstyle": "projecting", "joinstyle": "round"}
        ax.add_collection(LineCollection(paths, zorder=2, **style))


def draw_curves_on_image(
    ax: Axes | None, values: Array, curves: Sequence[DrawableCurve], spacing: Sequence[float] = (1.0, 1.0)
) -> Axes:
    """Draw lines on an image, shape (H, W), in the given axes, or in those of a new figure, and return these."""
    ax = axes_for(ax)
    show_image(ax, values, spacing)
    show_curves(ax, curves)
    return ax


def show_particles(ax: Axes, places: Array) -> None:
    """Show particles, shape (N, 2) [px]."""
    row, col = places.T
    size = next(size for most, size in _DOT_SIZES if len(places) <= most)
    if size > _DOT_SIZES[-1][1]:
        ax.scatter(col, row, s=2.4 * size, c=HALO_COLOR, linewidths=0.0, zorder=5)
    ax.scatter(col, row, s=size, c=PARTICLE_COLOR, linewidths=0.0, zorder=6)


def show_scale_bar(ax: Axes, shape: Extent, spacing: Sequence[float], unit: str | None) -> None:
    """Show a bar of round length with its length in a readable unit, in px where the pixel size is not known."""
    from matplotlib.patheffects import withStroke

    rows, cols = shape
    bar = fit_scale_bar(_MAX_BAR_SHARE * cols, float(spacing[1]), unit)
    left, down = 0.04 * cols, rows - 0.06 * rows
    halo = [withStroke(linewidth=5.0, foreground=HALO_COLOR)]
    ax.plot(
        [left, left + bar.pixels], [down, down], color="#ffffff", linewidth=3.0, solid_capstyle="butt",
        path_effects=halo, zorder=8,
    )  # fmt: skip
    middle = left + 0.5 * bar.pixels
    ax.annotate(
        bar.label, (middle, down), (0.0, 5.0), textcoords="offset points", color="#ffffff", ha="center", va="bottom",
        fontsize=9, bbox=TEXT_BOX_STYLE, zorder=8,
    )  # fmt: skip


def new_figure(shape: Extent | None, spacing: Sequence[float] = (1.0, 1.0)) -> tuple[Figure, Axes]:
    """Create a figure that one image fills, with its axes; for None with axes in space."""
    require_package("matplotlib", "A figure")
    from matplotlib.figure import Figure

    if shape is None:
        figure = Figure(figsize=(_FIGURE_SIDE, _FIGURE_SIDE))
        return figure, figure.add_subplot(projection="3d")
    tall, wide = shape[0] * float(spacing[0]), shape[1] * float(spacing[1])
    longer = max(tall, wide)
    figure = Figure(figsize=(max(_FIGURE_SIDE * wide / longer, 0.5), max(_FIGURE_SIDE * tall / longer, 0.5)))
    return figure, figure.add_axes((0.0, 0.0, 1.0, 1.0))


def render_figure(figure: Figure, suffix: str, about: str, dpi: int = _FIGURE_DPI) -> bytes:
    """Encode a figure as the bytes of a file with a description and without a time: equal figures are equal files."""
    import matplotlib as mpl

    stream = io.BytesIO()
    metadata = {
        ".svg": {"Date": None, "Description": about},
        ".png": {"Description": about},
        ".pdf": {"CreationDate": None, "Subject": about},
    }
    with mpl.rc_context({"svg.hashsalt": "cpm", "svg.fonttype": "none"}):
        figure.savefig(stream, format=FIGURE_FORMATS[suffix], dpi=dpi, metadata=metadata[suffix])
    return stream.getvalue()


METRIC_UNITS = {"nm": 1e-9, "µm": 1e-6, "mm": 1e-3, "m": 1.0}
"""Unit of length -> its size [m]."""

KNOWN_UNITS = {**METRIC_UNITS, "um": 1e-6, "cm": 1e-2}
"""Unit of the spacing of images -> its size [m]."""


@frozen
class ScaleBar:
    """A scale bar of round length, `pixels` of the image long."""

    pixels: float
    label: str


def fit_scale_bar(most: float, spacing: float, unit: str | None, *, keep_unit: bool = False) -> ScaleBar:
    """Fit the longest scale bar of round length, 1, 2 or 5 times a power of ten, in a readable unit.

    `most` is its maximum length [px of the image], `spacing` the size of a pixel [unit], px without a unit. With
    `keep_unit` the length is given in this very unit.
    """
    size, name = (most * spacing, unit) if unit else (most, "px")
    if not keep_unit:
        size, name = _to_readable_unit(size, name)
    power = 10.0 ** math.floor(math.log10(size))
    length = next((factor * power for factor in (5.0, 2.0, 1.0) if factor * power <= size), power / 2.0)
    return ScaleBar(most * (length / size), f"{length:g} {name}" if length < 1e6 else f"{length:,.0f} {name}")


def _to_readable_unit(size: float, unit: str) -> tuple[float, str]:
    """Convert a size to the metric unit in which it has one to three digits; keep any other unit."""
    if unit not in KNOWN_UNITS:
        return size, unit
    meters = size * KNOWN_UNITS[unit]
    fitting = [name for name, worth in METRIC_UNITS.items() if meters >= 0.999999 * worth]
    name = fitting[-1] if fitting else "nm"
    return meters / METRIC_UNITS[name], name


class Pictured:
    """An object that notebooks show by its plot, with the line that `repr` gives as its title."""

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the object."""
        raise NotImplementedError

    def _repr_png_(self) -> bytes | None:
        if not has_package("matplotlib"):
            return None  # the notebook shows the line
        from matplotlib import pyplot

        figure = pyplot.figure(dpi=_NOTEBOOK_DPI)
        in_space = getattr(self, "surface", None) is not None
        self.plot(figure.add_subplot(projection="3d" if in_space else None)).set_title(repr(self).strip("<>"))
        png = render_figure(figure, ".png", repr(self), _NOTEBOOK_DPI)
        pyplot.close(figure)
        return png
