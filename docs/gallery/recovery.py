"""Shape recovery from seeds: the experiments of Fig. 5 to 13."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from cpm_core.contours.agreement import compare_boundaries
from cpm_core.parameters import Parameters
from cpm_core.published.crust import reconstruct_curve
from cpm_core.segmentation.engine import Engine
from docs.gallery import silhouettes
from docs.gallery.pages import Page, Panel, Picture, Stairs
from docs.gallery.runs import Moment, Run, recovered, run
from docs.gallery.scenes import Scene

BETAS = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 2.0, 3.0, 4.0)
"""Dampings of the series under Fig. 10."""

_SHOWN = (0.6, 1.0, 1.2)
"""The dampings of the publication: three objects, the circle across a weak part of the border, border and ellipse."""

_CONTRASTS = (10.0, 20.0, 40.0)
_SNAPSHOTS = (10, 20, 40)
"""Steps after which the figures from Fig. 7 on show a snapshot."""

_FOUND = 0.9
"""Share of an object's boundary that must be recovered for the object to count as found."""


def convergence() -> Page:
    """Fig. 5: start, field, and a snapshot every ten steps."""
    scene = silhouettes.letter_u().under(Parameters(scales=1))
    engine = Engine(scene.values, scene.parameters)
    done = run(scene, at=range(10, 61, 10), engine=engine)
    field = Picture("electric field (direction)", scene.values, field=engine.force_field(scene.parameters))
    snapshots = [_snapshot(scene, moment) for moment in done.moments]
    panels = [start(scene), field, *snapshots, outcome("result", done)]
    return Page([panels[k : k + 3] for k in range(0, len(panels), 3)])


def population() -> Page:
    """Fig. 6: without insertion, with it, and from five particles."""
    scene = silhouettes.flower()
    alone = _without_insertion(scene)
    both, five = run(scene), run(replace(scene, seeds=scene.seeds[:: len(scene.seeds) // 5][:5]))
    runs = {"without insertion": alone, "with insertion": both, "from five particles": five}
    panels = [outcome(title, done, particles=True) for title, done in runs.items()]
    recalls = [done.end.agreement.recall for done in runs.values()]
    note = "recall {:.3f} without insertion, {:.3f} with it, {:.3f} from five particles"
    row = [start(scene, f"start: {len(scene.seeds)} particles"), *panels]
    return Page([row], note=note.format(*recalls), alike=False)


def _without_insertion(scene: Scene) -> Run:
    """Run without insertion, and reconstruct from the particles alone."""
    done = run(scene.under(Parameters(scales=1, d_max=0.0)))
    contours = reconstruct_curve(done.end.particles)
    seen = compare_boundaries(contours, scene.truth, done.end.agreement.tolerance)
    closed = recovered(contours, scene.truth, seen.tolerance)
    return replace(done, end=replace(done.end, contours=contours, agreement=seen, closed=closed))


def damping() -> Page:
    """Fig. 10: damping determines how many objects are found."""
    scene = silhouettes.across()
    shown = []
    for beta in _SHOWN:
        done = run(scene.under(replace(scene.parameters, beta=beta)))
        count = objects_found(done)
        panel = outcome(f"β = {beta:g}", done)
        objects = f"{count} of {len(silhouettes.ACROSS)} objects · {done.end.step} steps"
        measured = {"beta": beta, "objects": count, **(panel.facts or {})}
        shown.append(replace(panel, caption=[panel.caption[0], objects], facts=measured))
    series = {f"border of {contrast:g} grey levels": count_over_damping(contrast) for contrast in _CONTRASTS}
    title = "objects found over damping, for three contrasts of the border"
    facts = {"betas": list(BETAS), **series}
    chart = Stairs(title, BETAS, series, "damping β", "objects found", facts, span=4)
    counts = ", ".join(f"{panel.facts['objects']} at β = {panel.facts['beta']:g}" for panel in shown if panel.facts)
    drawn = list(series.values())[-1]  # the border of the scene that is shown
    ends = f"{drawn[0]} at β = {BETAS[0]:g}, {drawn[-1]} at β = {BETAS[-1]:g}"
    return Page([[start(scene), *shown], [chart]], note=f"objects found: {counts}; {ends}", alike=False)


def count_over_damping(contrast: float, betas: Sequence[float] = BETAS) -> list[int]:
    """Count the objects of the damping scene that are found at each damping."""
    scene = silhouettes.across(contrast)
    engine = Engine(scene.values, scene.parameters)
    runs = (run(scene.under(replace(scene.parameters, beta=beta)), engine=engine) for beta in betas)
    return [objects_found(done) for done in runs]


def objects_found(done: Run) -> int:
    """Count the true contours of which at least the share `_FOUND` was recovered."""
    return sum(
        compare_boundaries(done.end.contours, [one], done.end.agreement.tolerance).recall >= _FOUND
        for one in done.scene.truth
    )


def start(scene: Scene, title: str = "image and start") -> Picture:
    """Show a scene before its run."""
    return Picture(title, scene.values, particles=scene.seeds)


def outcome(title: str, done: Run, particles: bool = False) -> Picture:
    """Show a scene after its run, with its measured values below."""
    end = done.end
    shown = end.particles if particles else None
    return Picture(title, done.scene.values, shown, end.contours, caption=caption(end), facts=end.facts)


def caption(moment: Moment) -> list[str]:
    """Two lines of measured values."""
    closed = f"{moment.closed} of {moment.closed_true} closed · " if moment.closed_true else ""
    rest = "" if moment.converged else " (not at rest)"
    return [_agreement(moment), f"{closed}{moment.step} steps{rest} · {len(moment.particles)} particles"]


def _agreement(moment: Moment) -> str:
    seen = moment.agreement
    distance = f" · {seen.mean_boundary_distance:.3f} px" if np.isfinite(seen.mean_boundary_distance) else ""
    return f"recall {seen.recall:.3f} · precision {seen.precision:.3f}{distance}"


def _snapshot(scene: Scene, moment: Moment) -> Picture:
    scale = f", scale 1/{2**moment.scale}" if moment.scale else ""
    lines = [_agreement(moment), f"{len(moment.particles)} particles"]
    facts = {"snapshot": True, **moment.facts}
    return Picture(f"t = {moment.step}{scale}", scene.values, moment.particles, caption=lines, facts=facts)


def from_start_to_result(scenes: Callable[[], Mapping[str, Scene]], tolerance: float = 1.0) -> Page:
    """Show a row for each named scene: start, snapshots, result."""
    rows: list[list[Panel]] = []
    for name, scene in scenes().items():
        done = run(scene, at=_SNAPSHOTS, tolerance=tolerance)
        snapshots = [_snapshot(scene, moment) for moment in done.moments]
        rows.append([start(scene, name), *snapshots, outcome("result", done)])
    return Page(rows)
