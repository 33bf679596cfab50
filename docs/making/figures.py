"""The figures of the page on the model, computed by the program itself."""

from __future__ import annotations

import itertools
from pathlib import Path

import matplotlib as mpl
import numpy as np

mpl.use("agg")

from matplotlib import pyplot

import cpm_core as cpm
from cpm_core.image.drawing import show_curves, show_particles
from docs.gallery.plotting import show_field

_DPI = 110
ROOT = Path(__file__).parents[2]


def draw(folder: Path) -> None:
    """Draw all of them into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    drawn = {"fields": _fields(), "run": _run(), "scales": _scales(), "gap": _gap(), "methods": _methods()}
    for name, figure in drawn.items():
        figure.savefig(folder / f"{name}.png", dpi=_DPI, bbox_inches="tight")
        pyplot.close(figure)


def _axes(count: int, wide: float = 3.0) -> tuple[mpl.figure.Figure, list[mpl.axes.Axes]]:
    figure, axes = pyplot.subplots(1, count, figsize=(wide * count, wide + 0.35), layout="constrained")
    return figure, list(np.atleast_1d(axes))


def _u() -> cpm.Image:
    return cpm.load_image(ROOT / "assets" / "samples" / "u_shape.png")


def _fields() -> mpl.figure.Figure:
    """Image, edge map and field."""
    image = _u()
    engine = cpm.Engine(image)
    figure, (left, middle, right) = _axes(3)
    image.plot(left, scale_bar=False).set_title("image")
    middle.imshow(engine.edge_map(cpm.Parameters()), cmap="magma")
    middle.set(title="edge map f", xticks=[], yticks=[])
    image.plot(right, scale_bar=False).set_title("direction of the field")
    show_field(right, engine.force_field(cpm.Parameters()))
    return figure


def _run() -> mpl.figure.Figure:
    """Moments of a run, and its contours."""
    image = _u()
    figure, axes = _axes(4, 2.6)
    run = cpm.evolve(image, cpm.circle((100, 73), 38))
    moments = list(run)
    chosen = [moments[0], moments[len(moments) // 6], moments[len(moments) // 2]]
    for ax, moment in zip(axes, chosen, strict=False):
        moment.plot(ax, scale_bar=False).set_title(f"step {moment.step}, {moment.count} particles")
    run.result.plot(axes[3], scale_bar=False).set_title(f"contours at rest, step {moments[-1].step}")
    return figure


def _scales() -> mpl.figure.Figure:
    """Particles over the steps of the three scales."""
    moments = list(cpm.evolve(_u(), cpm.circle((100, 73), 38)))
    figure, (ax,) = _axes(1, 5.0)
    figure.set_size_inches(7.0, 2.8)
    steps, counts = [m.step for m in moments], [m.count for m in moments]
    ax.plot(steps, counts, color="#0072b2")
    for before, after in itertools.pairwise(moments):
        if after.scale != before.scale:
            ax.axvline(after.step, color="#d55e00", linestyle=":")
            ax.text(after.step + 2, 0.05, f"scale {after.scale}", transform=ax.get_xaxis_transform())
    ax.set(xlabel="step", ylabel="particles")
    return figure


def _gap() -> mpl.figure.Figure:
    """Draw a gap that is left open, and bridged."""
    image = cpm.example("gap")
    figure, axes = _axes(2)
    for ax, gap in zip(axes, (0, 30), strict=True):
        result = cpm.segment(image, cpm.circle((32, 32), 8), cpm.Parameters(max_gap=gap, edge_floor=0.25))
        result.plot(ax, scale_bar=False).set_title(f"max_gap={gap}")
        for bridge in result.bridges:
            row, col = bridge.points.T
            ax.plot(col, row, color="#ff7ac6", linewidth=2.5)
    return figure


def _methods() -> mpl.figure.Figure:
    """Draw the particles next to classical methods, from the same start."""
    image = _u()
    start = cpm.Start((cpm.circle((100, 73), 24),))
    names = ("cpm", "snake", "geodesic", "morph_chan_vese")
    figure, axes = _axes(len(names), 2.6)
    for ax, name in zip(axes, names, strict=True):
        method = cpm.CONTOUR_METHODS[name]
        moment = cpm.run_method(method, image, start)
        image.plot(ax, scale_bar=False).set_title(method.title, fontsize=9)
        show_curves(ax, moment.state.contours)
        if len(moment.state.points):
            show_particles(ax, moment.state.points)
    return figure
