"""Drawing on axes of matplotlib, which is imported only when something is drawn."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from cpm_core.image.drawing.palette import BRIGHTEST, DARKEST, EXTREMES, FIELD, HALO, JUNCTION, PARTICLE
from cpm_core.image.drawing.raster import Bytes, Curve, color_of
from cpm_core.image.drawing.scale_bar import longest_bar
from cpm_core.numerics.types import Array, Index
from cpm_core.parameters.quotation import shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes as Axes  # noqa: PLC0414 - for the annotations of other modules
    from matplotlib.figure import Figure

_ARROWS = 26
"""Arrows along the longer side of an image."""

_DOTS = ((700, 5.0), (2500, 2.5), (np.inf, 0.5))
"""Largest number of particles on a picture, and area of their dots [pt²]; the smallest dots have no halo."""

_LONGEST_BAR = 0.3
"""Largest length of a scale bar, as a share of the width of the image."""

_BOX: Mapping[str, Any] = MappingProxyType({"facecolor": HALO, "edgecolor": "none", "alpha": 0.6, "pad": 1.5})
"""What lies behind texts, so that they can be read on any gray; with outlines they would be no texts in SVG."""

_DPI = 200
_LARGEST = 6.0
"""Longer side of the figure of a file [inches]."""

FIGURES: Mapping[str, str] = {".svg": "svg", ".png": "png", ".pdf": "pdf"}
"""Suffix of a figure -> what matplotlib calls its format."""


def require_matplotlib() -> None:
    """Raise ValueError, with what to install, unless matplotlib is installed; it is not imported yet."""
    if not has_matplotlib():
        raise ValueError("Figures are drawn by matplotlib, which is not installed: get it with pip install matplotlib.")


def has_matplotlib() -> bool:
    """Whether matplotlib is installed."""
    return find_spec("matplotlib") is not None


def axes_for(ax: Axes | None, *, space: bool = False) -> Axes:
    """The axes that are given, or those of a new figure; with `space` they have three dimensions."""
    if ax is not None:
        if not hasattr(ax, "plot_trisurf" if space else "imshow"):
            wanted = 'axes of matplotlib in space (projection="3d")' if space else "axes of matplotlib"
            raise ValueError(f"ax is {shown(ax)} but must be {wanted}, or None for a new figure.")
        return ax
    require_matplotlib()
    from matplotlib import pyplot

    made: Axes = pyplot.subplots(subplot_kw={"projection": "3d"} if space else {})[1]
    return made


def show_image(ax: Axes, values: Array, spacing: Sequence[float] = (1.0, 1.0), colors: Bytes | None = None) -> None:
    """An image, or its colors, in px: row 0 is on top, and pixels that are not square are drawn as wide as they are."""
    rows, cols = values.shape[:2]
    if colors is not None:
        ax.imshow(colors, interpolation="nearest")
    else:
        low, high = np.percentile(values, EXTREMES)
        unit = max(high - low, 1e-300) / (BRIGHTEST - DARKEST)
        darkest, brightest = low - DARKEST * unit, high + (1.0 - BRIGHTEST) * unit
        ax.imshow(values, cmap="gray", vmin=darkest, vmax=brightest, interpolation="nearest")
    frame(ax, (rows, cols), spacing)


def frame(ax: Axes, shape: tuple[int, ...], spacing: Sequence[float] = (1.0, 1.0)) -> None:
    """The limits of an image of this shape, without ticks and a box."""
    ax.set(xlim=(-0.5, shape[1] - 0.5), ylim=(shape[0] - 0.5, -0.5), xticks=[], yticks=[])
    ax.set_aspect(float(spacing[0]) / float(spacing[1]))
    for spine in ax.spines.values():
        spine.set_visible(False)


def show_curves(ax: Axes, curves: Sequence[Curve], width: float = 1.5) -> None:
    """Lines with a dark halo, closed ones in blue and open ones in orange, but for those with a color of their own."""
    for halo in (True, False):
        for curve in curves:
            row, col = curve.path.T
            color, thickness = (HALO, width + 1.1) if halo else (color_of(curve), width)
            ax.plot(col, row, color=color, linewidth=thickness, solid_joinstyle="round")


def show_junctions(ax: Axes, places: Array) -> None:
    """Junctions, shape (N, 2) [px]."""
    ax.scatter(places[:, 1], places[:, 0], s=26.0, c=JUNCTION, edgecolors=HALO, linewidths=0.7, zorder=4)


def show_particles(ax: Axes, places: Array) -> None:
    """Particles, shape (N, 2) [px]."""
    row, col = places.T
    size = next(size for most, size in _DOTS if len(places) <= most)
    if size > _DOTS[-1][1]:
        ax.scatter(col, row, s=2.4 * size, c=HALO, linewidths=0.0, zorder=5)
    ax.scatter(col, row, s=size, c=PARTICLE, linewidths=0.0, zorder=6)


def show_field(ax: Axes, field: Array) -> None:
    """A field, shape (2, H, W), as arrows."""
    shape = field.shape[1:]
    step = max(1, round(max(shape) / _ARROWS))
    row, col = np.mgrid[step // 2 : shape[0] : step, step // 2 : shape[1] : step]
    down, right = field[:, row, col]
    ax.quiver(
        col, row, right, down, angles="xy", scale_units="xy", scale=1.0 / (0.9 * step), units="dots", width=1.6,
        color=FIELD, headwidth=4.0, headlength=4.5, headaxislength=4.0,
    )  # fmt: skip


def show_names(ax: Axes, names: Sequence[str], places: Sequence[Sequence[float]]) -> None:
    """Names at places (row, col)."""
    for name, (row, col) in zip(names, places, strict=True):
        ax.text(col, row, name, color="#ffffff", ha="center", va="center", fontsize=8, bbox=_BOX, zorder=7)


def show_scale_bar(ax: Axes, shape: tuple[int, ...], spacing: Sequence[float], unit: str | None) -> None:
    """A bar of round length with its length in a readable unit, in px where the size of a pixel is not known."""
    from matplotlib.patheffects import withStroke

    rows, cols = shape
    bar = longest_bar(_LONGEST_BAR * cols, float(spacing[1]), unit)
    left, down = 0.04 * cols, rows - 0.06 * rows
    halo = [withStroke(linewidth=5.0, foreground=HALO)]
    ax.plot(
        [left, left + bar.pixels], [down, down], color="#ffffff", linewidth=3.0, solid_capstyle="butt",
        path_effects=halo, zorder=8,
    )  # fmt: skip
    middle = left + 0.5 * bar.pixels
    ax.annotate(
        bar.label, (middle, down), (0.0, 5.0), textcoords="offset points", color="#ffffff", ha="center", va="bottom",
        fontsize=9, bbox=_BOX, zorder=8,
    )  # fmt: skip


def show_triangles(ax: Any, places: Array, faces: Index, unit: str | None) -> None:
    """Triangles, shape (F, 3), between places (plane, row, col) in units of length, shape (N, 3)."""
    plane, row, col = places.T
    ax.plot_trisurf(col, row, plane, triangles=faces, color="#7fb8dc", linewidth=0.0, antialiased=False, shade=True)
    ax.set_box_aspect(np.maximum(np.ptp(places[:, ::-1], axis=0), 1e-9))
    name = unit or "voxels"
    ax.set(xlabel=f"column [{name}]", ylabel=f"row [{name}]", zlabel=f"plane [{name}]")
    ax.invert_yaxis()


def new_figure(shape: tuple[int, ...] | None, spacing: Sequence[float] = (1.0, 1.0)) -> tuple[Figure, Axes]:
    """A figure that one image fills, with its axes; for None axes in space."""
    require_matplotlib()
    from matplotlib.figure import Figure

    if shape is None:
        figure = Figure(figsize=(_LARGEST, _LARGEST))
        return figure, figure.add_subplot(projection="3d")
    tall, wide = shape[0] * float(spacing[0]), shape[1] * float(spacing[1])
    longer = max(tall, wide)
    figure = Figure(figsize=(max(_LARGEST * wide / longer, 0.5), max(_LARGEST * tall / longer, 0.5)))
    return figure, figure.add_axes((0.0, 0.0, 1.0, 1.0))


def encoded_figure(figure: Figure, suffix: str, about: str) -> bytes:
    """A figure as the bytes of a file that tell what it shows and no time, so that equal figures are equal files."""
    import matplotlib as mpl

    stream = io.BytesIO()
    told: dict[str, dict[str, Any]] = {
        ".svg": {"Date": None, "Description": about},
        ".png": {"Description": about},
        ".pdf": {"CreationDate": None, "Subject": about},
    }
    with mpl.rc_context({"svg.hashsalt": "cpm", "svg.fonttype": "none"}):
        figure.savefig(stream, format=FIGURES[suffix], dpi=_DPI, metadata=told[suffix])
    return stream.getvalue()
