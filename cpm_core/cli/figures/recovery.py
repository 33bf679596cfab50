"""Shape recovery from a start that was drawn: the experiments of Fig. 5 to 11."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cpm_core.cli.figures import pictures, silhouettes
from cpm_core.cli.figures.pages import Page, Panel, Picture, Stairs
from cpm_core.cli.figures.runs import Moment, Run, run
from cpm_core.cli.figures.scenes import Scene
from cpm_core.contours.agreement import agreement, recovered
from cpm_core.parameters import Parameters
from cpm_core.particles.state import State
from cpm_core.reconstruction import reconstruct_curve
from cpm_core.segmentation.engine import Engine

BETAS = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.4, 2.0, 3.0, 4.0)
"""Dampings of the series under Fig. 10."""

_SHOWN = (0.4, 1.0, 4.0)
_CONTRASTS = (10.0, 20.0, 40.0)
_LOOKED_AT = (10, 20, 40)
"""Steps at which the figures below Fig. 5 show what has been found so far."""

_FOUND = 0.9
"""Share of an object's boundary that must be recovered for the object to count as found."""


def convergence() -> Page:
    """Fig. 5: start, field, and what has been found every ten steps."""
    scene = silhouettes.letter_u().under(Parameters(scales=1))
    engine = Engine(scene.values, scene.parameters)
    done = run(scene, at=range(10, 61, 10), engine=engine)
    field = Picture("electric field (direction)", scene.values, field=engine.field(scene.parameters))
    snapshots = [_snapshot(scene, moment) for moment in done.moments]
    return Page(_in_rows([start(scene), field, *snapshots, outcome("result", done)], 3))


def population() -> Page:
    """Fig. 6: without insertion and deletion, with them, and from five particles."""
    scene = silhouettes.flower()
    alone = _without_population(scene.under(Parameters(scales=1)))
    both, five = run(scene), run(scene.started(scene.seeds[:: len(scene.seeds) // 5][:5]))
    recalls = [done.end.agreement.recall for done in (alone, both, five)]
    return Page(
        [
            [
                start(scene, f"start: {len(scene.seeds)} particles"),
                outcome("without insertion and deletion", alone, particles=True),
                outcome("with insertion and deletion", both, particles=True),
                outcome("from five particles", five, particles=True),
            ]
        ],
        note="recall {:.3f} without insertion and deletion, {:.3f} with them, {:.3f} from five particles".format(
            *recalls
        ),
        alike=False,
    )


class _Constant(Engine):
    """The model without insertion and deletion."""

    def _populate(self, state: State, *rest: Any) -> State:
        after = super()._populate(state, *rest)
        return replace(after, particles=state.particles, born=0, deleted=state.deleted)


def _without_population(scene: Scene) -> Run:
    """A run of constant particles, joined by nothing but the crust, as particles alone would be."""
    done = run(scene, engine=_Constant(scene.values, scene.parameters))
    contours = reconstruct_curve(done.end.particles)
    seen = agreement(contours, scene.truth, done.end.agreement.tolerance)
    closed = recovered(contours, scene.truth, seen.tolerance)
    end = replace(done.end, contours=contours, agreement=seen, closed=closed)
    return replace(done, end=end)


def initialization() -> Page:
    """Fig. 7: starts inside, outside, across and beside."""
    return from_start_to_result(silhouettes.silhouettes())


def concavities() -> Page:
    """Fig. 8: a spiral corridor and a comb."""
    return from_start_to_result({"a spiral": silhouettes.spiral(), "a comb": silhouettes.comb()})


def topology() -> Page:
    """Fig. 9: junctions, objects in objects, several starts."""
    return from_start_to_result(silhouettes.embedded())


def damping() -> Page:
    """Fig. 10: damping decides how many objects are found."""
    scene = silhouettes.across()
    shown = []
    for beta in _SHOWN:
        done = run(scene.under(replace(scene.parameters, beta=beta)))
        count = objects_found(done)
        panel = outcome(f"β = {beta:g}", done)
        objects = f"{count} of {len(silhouettes.ACROSS)} objects · {done.end.step} steps"
        facts = {"beta": beta, "objects": count, **(panel.facts or {})}
        shown.append(replace(panel, caption=[panel.caption[0], objects], facts=facts))
    series = {f"border of {contrast:g} grey levels": count_over_damping(contrast) for contrast in _CONTRASTS}
    chart = Stairs(
        "objects found over damping, for three contrasts of the border",
        BETAS,
        series,
        "damping β",
        "objects found",
        facts={"betas": list(BETAS), **series},
        span=4,
    )
    counts = ", ".join(f"{panel.facts['objects']} at β = {panel.facts['beta']:g}" for panel in shown if panel.facts)
    return Page([[start(scene), *shown], [chart]], note=f"objects found: {counts}", alike=False)


def count_over_damping(contrast: float, betas: Sequence[float] = BETAS) -> list[int]:
    """Objects of the damping scene that are found at each damping."""
    scene = silhouettes.across(contrast)
    engine = Engine(scene.values, scene.parameters)
    runs = (run(scene.under(replace(scene.parameters, beta=beta)), engine=engine) for beta in betas)
    return [objects_found(done) for done in runs]


def objects_found(done: Run) -> int:
    """Objects of a scene, one for each of its true contours, of whose boundary nearly all was found."""
    return sum(
        agreement(done.end.contours, [one], done.end.agreement.tolerance).recall >= _FOUND for one in done.scene.truth
    )


def textures() -> Page:
    """Fig. 11: a vessel tree, and texture in the background or on the object."""
    scenes = {
        "vessel tree": pictures.angiogram(),
        "cell in a cloudy medium": pictures.cell_in_haze(),
        "leaf on gravel": pictures.leaf_on_gravel(),
        "spotted fish": pictures.spotted_fish(),
    }
    return from_start_to_result(scenes, tolerance=1.5)


def start(scene: Scene, title: str = "image and start") -> Picture:
    """A scene before its run."""
    return Picture(title, scene.values, particles=scene.seeds)


def outcome(title: str, done: Run, particles: bool = False) -> Picture:
    """A scene after its run, with its figures below."""
    return Picture(
        title,
        done.scene.values,
        particles=done.end.particles if particles else None,
        contours=done.end.contours,
        caption=caption(done.end),
        facts=done.end.facts,
    )


def caption(moment: Moment) -> list[str]:
    """Two lines of figures."""
    closed = f"{moment.closed} of {moment.closed_true} closed · " if moment.closed_true else ""
    rest = "" if moment.converged else " (not at rest)"
    return [_agreement(moment), f"{closed}{moment.step} steps{rest} · {len(moment.particles)} particles"]


def _agreement(moment: Moment) -> str:
    seen = moment.agreement
    distance = f" · {seen.mean_boundary_distance:.3f} px" if np.isfinite(seen.mean_boundary_distance) else ""
    return f"recall {seen.recall:.3f} · precision {seen.precision:.3f}{distance}"


def _snapshot(scene: Scene, moment: Moment) -> Picture:
    scale = f", scale 1/{2**moment.scale}" if moment.scale else ""
    return Picture(
        f"t = {moment.step}{scale}",
        scene.values,
        particles=moment.particles,
        caption=[_agreement(moment), f"{len(moment.particles)} particles"],
        facts={"snapshot": True, **moment.facts},
    )


def from_start_to_result(scenes: Mapping[str, Scene], tolerance: float = 1.0) -> Page:
    """A row for each named scene: start, snapshots, result."""
    rows: list[list[Panel]] = []
    for name, scene in scenes.items():
        done = run(scene, at=_LOOKED_AT, tolerance=tolerance)
        snapshots = [_snapshot(scene, moment) for moment in done.moments]
        rows.append([start(scene, name), *snapshots, outcome("result", done)])
    return Page(rows)


def _in_rows(panels: Sequence[Panel], columns: int) -> list[Sequence[Panel]]:
    return [panels[k : k + columns] for k in range(0, len(panels), columns)]
