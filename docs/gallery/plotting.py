"""Pages as PNG pictures, drawn by matplotlib, which is imported only when something is drawn."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np
import PIL.Image
import scipy
from numpy.typing import NDArray

from cpm_core.image.drawing import (
    CLOSED_CURVE_COLOR,
    HALO_COLOR,
    OPEN_CURVE_COLOR,
    PARTICLE_COLOR,
    show_curves,
    show_image,
    show_particles,
)
from cpm_core.numerics.types import Array
from docs.gallery.pages import Map, Page, Panel, Picture, Stairs

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


TEXT, DIM, PAPER = "#1b1f24", "#5a6470", "#ffffff"
_SERIES = ("#0072b2", "#d55e00", "#009e73")
_HEAT = "cividis"

JUNCTION, FIELD = "#ff7ac6", "#ff9ad5"
_ARROWS = 26
"""Arrows along the longer side of an image."""

_DPI = 100
_MARGIN, _GAP, _HEAD, _LEGEND, _TITLE, _LINE, _WIDEST, _PANEL = 18, 14, 30, 24, 24, 16, 1600, 290
"""Sizes on a page [px]; the last two are the largest widths of a page and of a panel of one column."""

_CHART, _TALLEST_CHART = 0.7, 320


def draw(page: Page, title: str) -> bytes:
    """Draw a page with a heading as a PNG file with a palette."""
    import matplotlib.style
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    columns = max(sum(panel.span if panel else 1 for panel in row) for row in page.rows)
    unit = min(_PANEL, (_WIDEST - 2 * _MARGIN - (columns - 1) * _GAP) // columns)
    heights = [max(_height(panel, unit) for panel in row if panel) for row in page.rows]
    size = (2 * _MARGIN + columns * unit + (columns - 1) * _GAP, 2 * _MARGIN + _HEAD + _LEGEND + sum(heights))
    with matplotlib.style.context("default"):
        figure = Figure(figsize=(size[0] / _DPI, size[1] / _DPI), dpi=_DPI, facecolor=PAPER)
        canvas = FigureCanvasAgg(figure)
        sheet = _Sheet(figure, size)
        sheet.text(_MARGIN, _MARGIN + 12, title, 13.0, weight="bold")
        _legend(sheet, page, _MARGIN + _HEAD + 6)
        top = _MARGIN + _HEAD + _LEGEND
        for row, height in zip(page.rows, heights, strict=True):
            left = _MARGIN
            for panel in row:
                if panel is not None:
                    _panel(sheet, panel, left, top, _width(panel, unit))
                left += (_width(panel, unit) if panel else unit) + _GAP
            top += height
        canvas.draw()
        pixels = np.asarray(canvas.buffer_rgba())[..., :3].copy()
    return _png(pixels)


class _Sheet:
    """A figure with coordinates in px from its upper left corner."""

    def __init__(self, figure: Figure, size: tuple[int, int]) -> None:
        self.figure = figure
        self._width, self._height = size

    def axes(self, left: float, top: float, width: float, height: float) -> Axes:
        down = self._height - top - height
        place = (left / self._width, down / self._height, width / self._width, height / self._height)
        return self.figure.add_axes(place)

    def text(self, left: float, middle: float, text: str, size: float, **style: Any) -> None:
        style = {"color": TEXT, "va": "center", "ha": "left", **style}
        self.figure.text(left / self._width, 1.0 - middle / self._height, text, fontsize=size, **style)

    def width_of(self, text: str, size: float) -> float:
        """Width of a text [px]."""
        made = self.figure.text(0.0, 0.0, text, fontsize=size)
        width = float(made.get_window_extent().width)
        made.remove()
        return width


def _width(panel: Panel, unit: int) -> int:
    return panel.span * unit + (panel.span - 1) * _GAP


def _height(panel: Panel, unit: int) -> int:
    """Height of a panel with its title and caption [px]."""
    width = _width(panel, unit)
    below = _LINE * len(panel.caption) + 6 if isinstance(panel, Picture) else 0
    return _TITLE + _height_of_drawing(panel, width) + below + _GAP


def _height_of_drawing(panel: Panel, width: int) -> int:
    if isinstance(panel, Picture):
        rows, cols = panel.values.shape
        return int(width * rows / cols)
    return min(_TALLEST_CHART, round(_CHART * width))


def _panel(sheet: _Sheet, panel: Panel, left: int, top: int, width: int) -> None:
    sheet.text(left, top + 0.5 * _TITLE, panel.title, 9.5, weight="bold")
    top += _TITLE
    height = _height_of_drawing(panel, width)
    if isinstance(panel, Picture):
        _picture(sheet.axes(left, top, width, height), panel)
        for number, line in enumerate(panel.caption):
            sheet.text(left, top + height + 5 + _LINE * (number + 0.5), line, 8.5, color=DIM)
    else:
        axes = sheet.axes(left + 58, top + 4, width - 70, height - 50)
        axes.tick_params(labelsize=8.5, colors=DIM, length=3)
        axes.set_xlabel(panel.x_label, fontsize=9, color=TEXT)
        axes.set_ylabel(panel.y_label, fontsize=9, color=TEXT)
        (_stairs if isinstance(panel, Stairs) else _map)(axes, panel)  # type: ignore[arg-type]


def _picture(axes: Axes, panel: Picture) -> None:
    show_image(axes, panel.values)
    axes.set_aspect("auto")
    if panel.field is not None:
        show_field(axes, panel.field)
    show_curves(axes, panel.contours)
    show_junctions(axes, _junctions(panel))
    if panel.particles is not None:
        show_particles(axes, panel.particles)


def show_junctions(ax: Axes, places: Array) -> None:
    """Junctions, shape (N, 2) [px]."""
    ax.scatter(places[:, 1], places[:, 0], s=26.0, c=JUNCTION, edgecolors=HALO_COLOR, linewidths=0.7, zorder=4)


def show_field(ax: Axes, field: Array) -> None:
    """Draw a field, shape (2, H, W), as arrows."""
    shape = field.shape[1:]
    step = max(1, round(max(shape) / _ARROWS))
    row, col = np.mgrid[step // 2 : shape[0] : step, step // 2 : shape[1] : step]
    down, right = field[:, row, col]
    ax.quiver(
        col, row, right, down, angles="xy", scale_units="xy", scale=1.0 / (0.9 * step), units="dots", width=1.6,
        color=FIELD, headwidth=4.0, headlength=4.5, headaxislength=4.0,
    )  # fmt: skip


def _junctions(panel: Picture) -> Array:
    """Return the ends of contours that are junctions, shape (N, 2)."""
    ends = [one.points[end] for one in panel.contours for end, at in zip((0, -1), one.junctions, strict=True) if at]
    return np.array(ends).reshape(-1, 2)


def _stairs(axes: Axes, panel: Stairs) -> None:
    most = max(max(series) for series in panel.series.values())
    for number, (label, series) in enumerate(panel.series.items()):
        lift = 0.05 * (number - 0.5 * (len(panel.series) - 1))  # so that coinciding lines are all visible
        color, mark = _SERIES[number % 3], "os^"[number % 3]
        style: dict[str, Any] = {"color": color, "marker": mark, "markersize": 5, "linewidth": 1.6}
        axes.plot(panel.x, np.array(series) + lift, label=label, drawstyle="steps-mid", **style)
    axes.set(ylim=(-0.2, most + 0.35), yticks=range(most + 1), xticks=panel.x)
    axes.set_xticklabels([f"{x:g}" for x in panel.x])
    axes.grid(color="#e3e6ea", linewidth=0.8)
    axes.set_axisbelow(True)
    axes.legend(fontsize=8.5, frameon=False, labelcolor=TEXT)


def _map(axes: Axes, panel: Map) -> None:
    axes.imshow(panel.values, cmap=_HEAT, vmin=0.0, vmax=1.0, aspect="auto", interpolation="nearest")
    axes.set(xticks=range(len(panel.x)), yticks=range(len(panel.y)))
    axes.set_xticklabels([f"{x:g}" for x in panel.x])
    axes.set_yticklabels([f"{y:g}" for y in panel.y])
    for (row, col), value in np.ndenumerate(panel.values):
        color = HALO_COLOR if value > 0.5 else PAPER
        axes.text(col, row, f"{value:.2f}", ha="center", va="center", fontsize=8, color=color)
    for spine in axes.spines.values():
        spine.set_visible(False)


def _legend(sheet: _Sheet, page: Page, middle: float) -> None:
    """Write a line with the meaning of the colors on this page."""
    from matplotlib.patheffects import withStroke

    pictures = [panel for panel in page.panels if isinstance(panel, Picture)]
    contours = [contour for panel in pictures for contour in panel.contours]
    entries = [
        ("●", PARTICLE_COLOR, "particle", any(panel.particles is not None for panel in pictures)),
        ("━━", CLOSED_CURVE_COLOR, "closed contour", any(contour.closed for contour in contours)),
        ("━━", OPEN_CURVE_COLOR, "open contour", any(not contour.closed for contour in contours)),
        ("●", JUNCTION, "junction", any(len(_junctions(panel)) for panel in pictures)),
        ("→", FIELD, "direction of the field", any(panel.field is not None for panel in pictures)),
    ]
    left = float(_MARGIN)
    for sign, color, usual, used in entries:
        if used:
            words = page.words.get(usual, usual)
            halo = [withStroke(linewidth=1.6, foreground=HALO_COLOR)]
            sheet.text(left, middle, sign, 11.0, color=color, path_effects=halo)
            left += sheet.width_of(sign, 11.0) + 6
            sheet.text(left, middle, words, 9.0, color=DIM)
            left += sheet.width_of(words, 9.0) + 20
    tolerances = {panel.facts["tolerance_px"] for panel in pictures if panel.facts and "tolerance_px" in panel.facts}
    if len(tolerances) == 1:
        truth = page.words.get("boundary", "boundary")
        words = f"below: recall and precision within {tolerances.pop():g} px, mean distance from the {truth}"
        sheet.text(left + 10, middle, words, 9.0, color=DIM)


def _png(pixels: NDArray[np.uint8]) -> bytes:
    """Encode a PNG file with the palette of the gallery: grays, and colors of overlays with transitions to grays."""
    palette = _palette()
    packed = (pixels.astype(np.uint32) << (16, 8, 0)).sum(axis=-1, dtype=np.uint32)
    colors, which = np.unique(packed, return_inverse=True)
    apart = colors[:, None] >> np.array((16, 8, 0), dtype=np.uint32) & 255
    nearest = np.asarray(scipy.spatial.cKDTree(palette).query(apart)[1]).astype(np.uint8)
    picture = PIL.Image.fromarray(nearest[which].reshape(packed.shape))
    picture.putpalette(palette.tobytes())
    stream = io.BytesIO()
    picture.save(stream, format="PNG", optimize=True)
    return stream.getvalue()


def _palette() -> NDArray[np.uint8]:
    """Colors, shape (256, 3); the last ones are repeated."""
    from matplotlib import colormaps
    from matplotlib.colors import to_rgb

    grays = np.repeat(np.linspace(0.0, 1.0, 56)[:, None], 3, axis=1)
    heat = colormaps[_HEAT](np.linspace(0.0, 1.0, 32))[:, :3]
    named = [TEXT, DIM, HALO_COLOR, PAPER]
    hues = np.array(
        [to_rgb(name) for name in (PARTICLE_COLOR, CLOSED_CURVE_COLOR, OPEN_CURVE_COLOR, JUNCTION, FIELD, *_SERIES)]
    )
    backgrounds = np.array([to_rgb(HALO_COLOR), (0.5, 0.5, 0.5), (1.0, 1.0, 1.0)])
    shares = (0.25, 0.5, 0.75)
    transitions = [(1.0 - share) * hues + share * background for background in backgrounds for share in shares]
    colors = np.concatenate([grays, heat, np.array([to_rgb(name) for name in named]), hues, *transitions])
    colors = np.concatenate([colors, np.repeat(colors[-1:], 256 - len(colors), axis=0)])
    return np.rint(255.0 * colors).astype(np.uint8)
