"""How a finer scale begins after a start everywhere: the same is found with few of its seeds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cpm_core.contours.agreement import distances_to_contours
from cpm_core.model.starts import circle, uniform_grid
from cpm_core.model.state import Particles
from cpm_core.parameters import PRESETS
from cpm_core.segmentation import engine, finer_scale
from cpm_core.segmentation.engine import Engine
from cpm_core.segmentation.finer_scale import drop_explained_seeds

from ..scenes import disk

SIDE = 320
RADII = (30.0, 4.5, 12.0, 6.0)


def scene():
    """Disks of several sizes in rows, those of the third row 5 px wide bars, with noise."""
    values = sum(
        disk((SIDE, SIDE), (40.0 + 80.0 * row, 40.0 + 80.0 * col), RADII[(row + col) % 4]).values
        for row in range(4)
        for col in range(4)
        if row != 2
    )
    values[190:210] = np.where(np.arange(SIDE) % 40 < 5, values.max(), values.min())
    return values + np.random.default_rng(1).normal(0.0, 0.08 * np.ptp(values), values.shape)


def ended(run, seeds, parameters):
    state, most = run.start(seeds), []
    while not state.stop_reason:
        before, state = state, run.step(state, parameters)
        if state.scale < before.scale:
            most.append(state.count)
    return run.result(state, parameters), most


def test_the_same_contours_are_found_with_few_of_the_seeds(monkeypatch):
    values, parameters, seeds = scene(), PRESETS["automatic"], uniform_grid((SIDE, SIDE))
    monkeypatch.setattr(finer_scale, "_MIN_THINNED_PIXELS", 0)  # so that the coarsest scale has fewer, too
    found, few = ended(Engine(values, parameters), seeds, parameters)
    for name in ("drop_explained_seeds", "thin_seeds"):
        monkeypatch.setattr(engine, name, lambda state, field=None: state)
    whole, many = ended(Engine(values, parameters), seeds, parameters)
    assert len(found.contours) == len(whole.contours) >= 20
    for some, others in ((found, whole), (whole, found)):
        assert (
            distances_to_contours(np.concatenate([one.points for one in some.contours]), others.contours).max() < 0.05
        )
    assert few[-1] < many[-1] - 0.6 * len(seeds)


def began(coarse, seeds):
    """The finest scale of a thin bar, begun with particles of the coarser one and with seeds."""
    values, parameters = np.zeros((96, 96)), PRESETS["automatic"]
    values[:, 45:51] = 1.0
    run = Engine(values, parameters)
    state = run.start(seeds)
    while state.scale:
        state = run.step(state, parameters)
    first = Particles.at_rest(np.concatenate([coarse, state.to_particle_places(seeds)]))
    return drop_explained_seeds(replace(state, particles=first), run.scale_field(parameters))


def test_one_side_of_a_thin_object_does_not_explain_the_other():
    seeds = uniform_grid((96, 96))
    rows = np.arange(0.0, 96.0, 2.0)
    left, right = (np.stack([rows, np.full_like(rows, col)], axis=1) for col in (44.5, 50.5))
    assert began(np.concatenate([left, right]), seeds).count == 2 * len(rows)
    kept = began(left, seeds).particles.position[len(rows) :]
    assert len(kept) and np.abs(kept[:, 1] - 50.5).max() < 24.0


def test_seeds_that_are_not_everywhere_stay():
    seeds = circle((48.0, 80.0), 4.0)
    assert began(np.array([(48.0, 44.5)]), seeds).count == 1 + len(seeds)
