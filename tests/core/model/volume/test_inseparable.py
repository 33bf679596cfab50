"""From one start to all boundaries that cannot be moved apart from the one it finds, and to no others."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial import KDTree

import cpm_core as cpm
from cpm_core.field.volume_field import build_volume_field
from cpm_core.model.volume.inseparable import find_inseparable

from ...reconstruction.surface.solids import ball, brick, grid, ring, union, without

SIDE = 46.0
M = np.full(3, 22.5)
LEFT, RIGHT, BACK = np.array([0.0, -6.0, 0.0]), np.array([0.0, 6.0, 0.0]), np.array([0.0, 0.0, 13.0])
VOLUME = cpm.PRESETS["volume"]

SOLIDS = {
    "links": union(ring(12.0, 2.0, 0, M + LEFT), ring(12.0, 2.0, 2, M + RIGHT)),
    "shell": without(ball(17.0, M), ball(7.0, M)),
    "nested": union(without(brick(20, 20, 20, center=M), brick(14, 14, 14, center=M)), ball(4.0, M)),
    "apart": union(ball(6.0, M - BACK), ball(6.0, M + BACK)),
    "cup": union(without(ring(12.0, 3.0, 0, M), brick(9, 6, 9, center=M + BACK)), ball(4.0, M)),
    "cut": without(ball(17.0, M - 2.0 * BACK), ball(7.0, M - 2.0 * BACK)),
}


@cache
def volume(name, noise=2.0):
    gray = 200.0 * np.clip(0.5 + SOLIDS[name](grid(side=SIDE)), 0.0, 1.0)
    return gray + np.random.default_rng(0).normal(0.0, noise, gray.shape)


def covered(name, result):
    """Fraction of the voxels on the surface that have a particle near them."""
    places = grid(side=SIDE)
    surface = places[np.abs(SOLIDS[name](places)) < 0.5]
    return float((KDTree(result.particles).query(surface)[0] < 2.5).mean())


@pytest.mark.parametrize(
    ("name", "center", "radius", "noise"),
    [
        pytest.param("links", M + LEFT - (0.0, 12.0, 0.0), 1.5, 25.0, id="links from one ring"),
        pytest.param("links", M + RIGHT + (0.0, 12.0, 0.0), 1.5, 2.0, id="links from the other"),
        pytest.param("shell", M, 3.0, 2.0, id="shell from its hollow"),
        pytest.param("shell", M, 20.0, 25.0, id="shell from outside"),
        pytest.param("nested", M, 2.0, 2.0, id="nested from the innermost"),
    ],
)
def test_one_start_leads_to_all_that_cannot_be_moved_apart(name, center, radius, noise):
    result = cpm.segment(volume(name, noise), cpm.sphere(center, radius, 80), VOLUME)
    assert result.converged
    assert covered(name, result) > 0.98
    assert np.quantile(np.abs(SOLIDS[name](result.particles)), 0.98) < 1.5


@pytest.mark.parametrize(
    ("name", "center", "whole"),
    [
        pytest.param("apart", M - BACK, 0.5, id="beside each other"),
        pytest.param("cup", M - (0.0, 0.0, 12.0), 0.87, id="a ball in a bay"),
        pytest.param("cut", (22.5, 22.5, 10.5), None, id="a region at the border"),
    ],
)
def test_what_can_be_moved_apart_depends_on_the_start(name, center, whole):
    engine = cpm.Engine(volume(name), VOLUME)
    state = engine.start(cpm.sphere(center, 2.0, 80))
    while not state.stop_reason:
        state = engine.step(state, VOLUME)
    assert state.reseedings == 0
    if whole is not None:
        assert covered(name, engine.result(state, VOLUME)) == pytest.approx(whole, abs=0.04)


def test_a_region_that_particles_cannot_enter_encloses_nothing():
    gray = volume("nested", 0.0)
    closed = np.zeros(gray.shape, bool)
    closed[:, 22, 31] = True
    for shut, expected in ((None, True), (cpm.VolumeRegions(barriers=[closed]), False)):
        field = build_volume_field(gray, (1.0, 1.0, 1.0), 0.7, 0.1)
        field = replace(field, walls=shut and shut.build_walls(gray.shape))
        wall = np.linalg.norm(field.ridges.place - M, axis=1) > 8.0
        reached = np.zeros(field.ridges.component.max() + 1, bool)
        reached[field.ridges.component[wall]] = True
        assert find_inseparable(field, field.ridges, reached, wall).any() == expected
