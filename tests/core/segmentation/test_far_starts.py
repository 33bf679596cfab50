"""A start far from every edge: a coarser scale waits until its particles have arrived."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from cpm_core import Engine, circle
from cpm_core.parameters import PRESETS

from ..scenes import disk

SHAPE, CENTER, RADIUS = (800, 800), (399.5, 399.5), 120.0


@pytest.fixture(scope="module")
def far_run():
    """A run from a circle 240 px beyond a disk, under noise that stops particles on their way at full size."""
    scene = disk(SHAPE, CENTER, RADIUS)
    noise = np.random.default_rng(1).normal(0.0, 8.0, SHAPE)
    values = gaussian_filter(40.0 + 0.5625 * scene.values, 1.0) + noise
    parameters = PRESETS["shape"]
    engine = Engine(np.rint(values), parameters)
    states = [engine.start(circle(CENTER, 3.0 * RADIUS))]
    while not states[-1].stop_reason:
        states.append(engine.step(states[-1], parameters))
    return scene, engine, parameters, states


def test_a_scale_does_not_end_before_particles_have_arrived_at_the_edge(far_run):
    scene, _, parameters, states = far_run
    ends = [before for before, after in pairwise(states) if after.scale != before.scale]
    assert len(ends) == parameters.scales - 1
    for state in ends:
        assert (scene.distance(state.position) < 0.1 * RADIUS).mean() > 0.25


def test_a_circle_far_around_a_disk_finds_the_disk(far_run):
    scene, engine, parameters, states = far_run
    (contour,) = engine.result(states[-1], parameters).contours
    assert contour.closed
    assert scene.distance(contour.points).max() < 1.0
    assert contour.area == pytest.approx(np.pi * RADIUS**2, rel=0.01)
