"""Placed charges in volumes: their force, which particles they wake, and what they do to a run."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cpm_core as cpm
from cpm_core.field.placed_charges import (
    CHARGE_RADIUS,
    MAX_PLACED_FORCE,
    charges_at_scale,
    placed_force,
    placed_forces,
    placed_potential,
)

VOLUME = cpm.PRESETS["volume"]
SPACING = (2.0, 1.0, 1.0)
CENTER = np.array([28.0, 28.0, 20.0]) / SPACING
START = cpm.sphere(tuple(CENTER), 4.0, 60, voxel_size=SPACING)


@cache
def engine():
    grid = np.moveaxis(np.indices((28, 56, 64)), 0, -1)
    away = np.linalg.norm((grid - CENTER) * SPACING, axis=-1)
    return cpm.Engine(cpm.Image(200.0 * np.clip(0.5 - (away - 9.0) / 2.0, 0.0, 1.0), spacing=SPACING), VOLUME)


@cache
def at_rest():
    state = engine().start(START)
    while not state.stop_reason:
        state = engine().step(state, VOLUME)
    return state


places = st.tuples(*[st.floats(-80.0, 80.0)] * 3)


@given(places, st.floats(-10.0, 10.0))
def test_in_the_plane_of_a_charge_its_force_is_that_in_an_image(place, strength):
    """The law depends on the distance alone; the plane knows it on pixels."""
    row, col = (round(x) for x in place[1:])
    charge = charges_at_scale([cpm.PlacedCharge((80.0, 80.0), strength)], 0, (200, 200))
    flat = placed_forces(charge, CHARGE_RADIUS, np.array([80.0 + row, 80.0 + col]))
    solid = placed_force(np.array([[5.0, 0.0, 0.0, strength]]), CHARGE_RADIUS, (5.0, float(row), float(col)))
    np.testing.assert_allclose(solid, (0.0, *flat), atol=1e-12)


@given(st.lists(st.tuples(places, st.floats(-3.0, 3.0)), min_size=1, max_size=4), places)
def test_the_force_is_the_slope_of_the_potential_up_to_its_largest_size(placed, place):
    charges = np.array([(*at, strength) for at, strength in placed])
    force = np.array(placed_force(charges, CHARGE_RADIUS, place))
    steps = 1e-4 * np.eye(3)
    slope = np.array(
        [
            placed_potential(charges, CHARGE_RADIUS, place + s) - placed_potential(charges, CHARGE_RADIUS, place - s)
            for s in steps
        ]
    )
    slope /= -2e-4
    assert np.linalg.norm(force) <= MAX_PLACED_FORCE + 1e-9
    wanted = slope * min(1.0, MAX_PLACED_FORCE / max(np.linalg.norm(slope), 1e-30))
    np.testing.assert_allclose(force, wanted, atol=1e-6)


def test_the_field_and_potential_of_a_volume_hold_those_of_the_charges():
    charge = cpm.PlacedCharge((10.0, 40.0, 50.0), -2.0)
    more = engine().force_field(VOLUME, 0, [charge]) - engine().force_field(VOLUME, 0)
    there = np.array([10.0, 40.0, 50.0]) * SPACING
    for voxel in ((10, 40, 40), (3, 30, 50), (14, 44, 61)):
        wanted = placed_force(np.array([[*there, -2.0]]), CHARGE_RADIUS, tuple(np.array(voxel) * SPACING))
        np.testing.assert_allclose(more[(slice(None), *voxel)], wanted, atol=2e-6)
    well = engine().potential(VOLUME, [charge]) - engine().potential(VOLUME)
    assert np.unravel_index(well.argmax(), well.shape) == (10, 40, 50)


def test_a_strong_charge_draws_particles_off_the_surface_near_it_and_leaves_those_out_of_reach():
    state, far = at_rest().resume(), cpm.PlacedCharge((14.0, 28.0, 63.0 + 32.0), 10.0)
    near = cpm.PlacedCharge((14.0, 28.0, 45.0), 10.0)
    unmoved = engine().step(state, VOLUME, [far])
    np.testing.assert_array_equal(unmoved.position, engine().step(state, VOLUME).position)
    for _ in range(12):
        state = engine().step(state, VOLUME, [near])
    side = state.position[:, 2] > CENTER[2]
    off = np.linalg.norm((state.position - CENTER) * SPACING, axis=1) - 9.0
    assert (off[side] > 1.0).sum() > 20


def test_a_repelling_charge_keeps_a_run_away_and_its_removal_lets_it_go_on():
    charge = cpm.PlacedCharge((14.0, 28.0, 45.0), -1.1)
    state = engine().start(START)
    while not state.stop_reason:
        state = engine().step(state, VOLUME, [charge])
    assert state.charges == (charge,)
    assert state.converged

    def near(of):
        return np.count_nonzero(np.linalg.norm((of.position - charge.position) * SPACING, axis=1) < 20.0)

    assert near(state) < 0.4 * near(at_rest())
    state = state.resume()
    while not state.stop_reason:
        state = engine().step(state, VOLUME)
    assert near(state) > 0.8 * near(at_rest())


def test_only_particles_within_reach_of_a_changed_charge_wake():
    state = replace(at_rest().resume(), step_of_scale=at_rest().step_of_scale + 500)
    after = engine().step(state, VOLUME, [cpm.PlacedCharge((14.0, 28.0, 80.0), 1.0)])
    woken = after.particles.reactivated_at > at_rest().step_of_scale + 400
    away = np.linalg.norm((after.position - (14.0, 28.0, 80.0)) * SPACING, axis=1)
    assert 0 < woken.sum() < after.count
    np.testing.assert_array_equal(woken, away < 64.0)


@pytest.mark.parametrize("call", ["step", "forces", "energies", "force_field", "potential"])
@settings(max_examples=5, deadline=None)
@given(st.floats(-1.0, 70.0))
def test_a_charge_of_an_image_is_refused_in_a_volume_and_the_other_way_round(call, at):
    flat = cpm.Engine(np.pad(np.ones((12, 12)), 8), cpm.Parameters(scales=1))
    solid, plane = (engine(), at_rest().resume(), VOLUME), (flat, flat.start([(9.0, 9.0)]), cpm.Parameters(scales=1))
    for (method, state, parameters), position, wanted in (
        (solid, (at, 1.0), r"\(plane, row, col\) in a volume\.$"),
        (plane, (at, 1.0, 2.0), r"\(row, col\) in an image\.$"),
    ):
        given_charges = [cpm.PlacedCharge(position, 1.0)]
        with pytest.raises(ValueError, match=wanted):
            if call in ("force_field", "potential"):
                getattr(method, call)(parameters, charges=given_charges)
            else:
                getattr(method, call)(state, parameters, given_charges)
