"""``python -m docs.gallery.published``: the publication as published and as this program, figure by figure.

It runs both methods on scenes like those of the publication and writes the table of `docs/published.md` anew.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from cpm_core import Parameters, gradient_threshold, segment, skeleton, sphere, uniform_grid
from cpm_core.contours.agreement import compare_boundaries
from cpm_core.numerics.polyline import points_at_lengths
from cpm_core.published import Published
from cpm_core.results.result import Result
from docs.gallery import silhouettes, skeletons
from docs.gallery.pictures import cells
from docs.gallery.scenes import Scene
from docs.gallery.studies import gaussian

PAGE = Path(__file__).parents[1] / "published.md"
"""The page with the table."""

_TOLERANCE = 1.5
"""Distance up to which contours and the truth agree [px]."""

_MOST_STEPS = 3000
"""Steps after which a run is stopped, as one as published may go on."""

_MOST_STEPS_IN_SPACE = 240
"""Steps after which a run in the volume is stopped: the publication shows 180."""

_CALM = Parameters(w1=0.6, w2=0.7, beta=0.4)
"""The parameters of sections 5.2 and 5.4."""

_FOUND = 0.9
"""Share of a boundary that counts as found."""


def _run(scene: Scene, method: Any, most: int = _MOST_STEPS) -> Result:
    return segment(scene.values, scene.seeds, scene.parameters, max_steps=most, method=method)


def _agreement(scene: Scene, method: Any, most: int = _MOST_STEPS) -> str:
    """Run a scene and return recall and precision of its contours."""
    seen = compare_boundaries(_run(scene, method, most).contours, scene.truth, _TOLERANCE)
    return f"{seen.recall:.2f} / {seen.precision:.2f}"


def _mean(scenes: Mapping[str, Scene], method: Any) -> str:
    """Return the means of recall and precision over several scenes."""
    seen = [compare_boundaries(_run(one, method).contours, one.truth, _TOLERANCE) for one in scenes.values()]
    return f"{np.mean([one.recall for one in seen]):.2f} / {np.mean([one.precision for one in seen]):.2f}"


def _objects(scene: Scene, method: Any) -> str:
    """Return how many of the true boundaries are found."""
    contours = _run(scene, method).contours
    found = [compare_boundaries(contours, [one], _TOLERANCE).recall >= _FOUND for one in scene.truth]
    return f"{sum(found)} of {len(found)} boundaries"


def _skeleton(method: Any) -> str:
    """Return the share of the medial axis of an ellipse within 2 px of a skeleton, of particles from both starts."""
    shape, one = skeletons.shapes()["ellipse"], Parameters(scales=1)
    (line,) = shape.axis
    axis = points_at_lengths(line.points, np.linspace(0.0, line.length, 200))
    if method == "cpm":
        found = [np.concatenate([branch.points for branch in skeleton(shape.values).contours])]
    else:
        starts = uniform_grid(shape.values.shape), gradient_threshold(shape.values)
        run = partial(Published, skeleton=True)
        found = [segment(shape.values, seeds, one, max_steps=400, method=run).particles for seeds in starts]
    shares = [float((cKDTree(points).query(axis)[0] <= 2.0).mean()) for points in found]
    return " and ".join(f"{share:.2f}" for share in shares) + " of the axis"


def _torus(method: Any) -> str:
    """Return the share of a torus that lies near the particles from four spheres."""
    place = np.indices((64, 64, 64), float) - 31.5
    values = 255.0 / (1.0 + np.exp(2.0 * (np.hypot(np.hypot(place[1], place[2]) - 18.0, place[0]) - 7.0)))
    around = 0.5 * np.pi * np.arange(4)
    centers = 31.5 + 18.0 * np.stack([0.0 * around, np.sin(around), np.cos(around)], axis=1)
    seeds = np.concatenate([sphere(tuple(center), 4.0, 60) for center in centers])
    found = segment(values, seeds, replace(_CALM, scales=1), max_steps=_MOST_STEPS_IN_SPACE, method=method).particles
    turn, tube = np.meshgrid(*[np.linspace(0.0, 2.0 * np.pi, n, endpoint=False) for n in (120, 48)])
    out = 18.0 + 7.0 * np.cos(tube)
    truth = 31.5 + np.stack([7.0 * np.sin(tube), out * np.sin(turn), out * np.cos(turn)], axis=-1).reshape(-1, 3)
    recall = (cKDTree(found).query(truth)[0] <= 2.0).mean() if len(found) else 0.0
    precision = (cKDTree(truth).query(found)[0] <= 2.0).mean() if len(found) else 0.0
    return f"{recall:.2f} / {precision:.2f}"


def _experiments() -> Iterator[tuple[str, str, Callable[[Any], str]]]:
    """Yield the number of each figure, what the publication says, and what measures it by a method."""
    u, flower, tested = silhouettes.letter_u(), silhouettes.flower(), silhouettes.for_sensitivity()

    def under(scene: Scene, **changes: Any) -> Scene:
        return scene.under(replace(scene.parameters, **changes))

    single = under(u, scales=1)
    yield "5", "U, at one scale, recovered by step 60", lambda method: _agreement(single, method, 60)
    yield "5", "U, with the pyramid", lambda method: _agreement(u, method)
    yield "6", "no births (d_max = 0): wrong shape", lambda method: _agreement(under(flower, d_max=0.0), method)
    yield "6", "births: right shape", lambda method: _agreement(flower, method)
    five = replace(flower, seeds=flower.seeds[:: len(flower.seeds) // 5][:5])
    yield "6", "from five particles: right shape", lambda method: _agreement(five, method)
    yield "7", "starts across boundaries: all recovered", partial(_mean, silhouettes.silhouettes())
    for name, scene in silhouettes.concavities().items():
        yield "8", f"{name}: recovered", partial(_agreement, scene)
    yield "9", "embedded objects: recovered", partial(_mean, silhouettes.embedded())
    for beta, claim in ((0.6, "all three"), (1.0, "border, ellipse, circle in part"), (1.2, "border and ellipse")):
        yield "10", f"β = {beta}: {claim}", partial(_objects, under(silhouettes.across(), beta=beta))
    noisy = cells()
    everywhere = replace(noisy, seeds=uniform_grid(noisy.values.shape, 16.0), parameters=_CALM)
    yield "12", "from everywhere: most structures", partial(_agreement, everywhere)
    yield "14", "skeleton of an ellipse, from a grid and from edges", _skeleton
    yield "15", "torus from four spheres, recovered by step 180", _torus
    for ratio in (0.05, 0.9, 0.99):
        scene = under(tested, w1=ratio * tested.parameters.w2)
        yield "17", f"w₁/w₂ = {ratio}" + (": fails" if ratio < 0.1 else ""), partial(_agreement, scene)
    for a in (0.5, 0.99, 1.0):
        claim = ": fails" if a < 0.9 else ""
        yield "17", f"a = {a}{claim}", partial(_agreement, under(tested, annealing=a))
    for spread in (20, 100):
        base = silhouettes.for_noise()
        scene = replace(base, values=gaussian(base.values, spread, 0))
        yield "18", f"Gaussian noise of {spread}: recovered", partial(_agreement, scene)


def main() -> None:
    """Measure, and write the table into the page; rows appear there as they are done."""
    rows = ["| figure | the publication | as published | ours |", "|---|---|---|---|"]
    for figure, claim, measure in _experiments():
        rows.append(f"| {figure} | {claim} | {measure('published')} | {measure('cpm')} |")
        text = re.sub(r"\| figure .*?\n\n", lambda _: "\n".join(rows) + "\n\n", PAGE.read_text("utf-8"), flags=re.S)
        PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
