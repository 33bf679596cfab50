"""Placed charges: their law, and what particles do under them."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import Engine, Parameters, PlacedCharge, circle
from cpm_core.field.placed_charges import (
    CHARGE_RADIUS,
    CHARGE_REACH,
    MAX_PLACED_FORCE,
    changed_charges,
    charge_radius_at,
    charges_at_scale,
    placed_forces,
    placed_potential,
    sort_charges,
)
from cpm_core.image.pyramid import to_image
from cpm_core.model.coverage import idle_steps_at

from ..scenes import antialiased, disk

SHAPE = (160, 160)
PARAMETERS = Parameters(scales=1)
TWO = antialiased(
    (128, 256), lambda row, col: (np.hypot(row - 63.4, col - 50.3) < 30) | (np.hypot(row - 63.4, col - 205.3) < 30)
)
STARTS = np.concatenate([circle((63.4, 50.3), 20.0), circle((63.4, 205.3), 20.0)])
strengths = st.floats(-10.0, 10.0)
charges = st.builds(PlacedCharge, st.tuples(st.floats(-20.0, 60.0), st.floats(-20.0, 60.0)), strengths)


def law(charge, points):
    """Force of one charge: minus the slope of its potential, by central differences in double precision."""
    h = 1e-4
    steps = h * np.eye(2)
    one = charges_at_scale([charge], 0, SHAPE)
    slope = [
        placed_potential(one, CHARGE_RADIUS, points + d) - placed_potential(one, CHARGE_RADIUS, points - d)
        for d in steps
    ]
    return -np.stack(slope, axis=-1) / (2.0 * h)


def grid(*shape):
    """Places of the pixels of an image."""
    return np.moveaxis(np.indices(shape), 0, -1)


def cut(force):
    size = np.linalg.norm(force, axis=-1, keepdims=True)
    return force * np.minimum(1.0, MAX_PLACED_FORCE / np.maximum(size, 1e-300))


def run(engine, state, parameters, placed=(), most=3000):
    for _ in range(most):
        if state.stop_reason:
            break
        state = engine.step(state, parameters, placed)
    return state


@pytest.fixture(scope="module")
def engine():
    return Engine(TWO, PARAMETERS)


@pytest.fixture(scope="module")
def resting(engine):
    state = run(engine, engine.start(STARTS), PARAMETERS)
    assert state.converged
    return state


def test_a_charge_of_one_pulls_at_its_radius_with_one_and_hardly_more_anywhere():
    charge = charges_at_scale([PlacedCharge((0.0, 0.0), 1.0)], 0, SHAPE)
    force = placed_forces(charge, CHARGE_RADIUS, grid(1, 80))[0]
    assert force[int(CHARGE_RADIUS), 1] == pytest.approx(-1.0, abs=1e-12)
    assert np.abs(force[:, 1]).max() < 1.1
    assert (force[:, 0] == 0.0).all()
    assert (force[int(CHARGE_REACH) :] == 0.0).all()
    assert -force[32, 1] == pytest.approx(0.7, abs=0.05)
    assert -force[48, 1] == pytest.approx(0.3, abs=0.05)


@settings(max_examples=10, deadline=None)
@given(st.lists(charges, min_size=1, max_size=5))
def test_forces_are_the_slopes_of_the_potentials_added_up_and_cut(placed):
    points = np.array([*product((0, 7, 19), (0, 3, 22))], dtype=float)
    want = cut(sum(law(charge, points) for charge in placed))
    force = placed_forces(charges_at_scale(placed, 0, SHAPE), CHARGE_RADIUS, grid(20, 23))
    np.testing.assert_allclose(force[tuple(points.astype(int).T)], want, atol=1e-5)
    apart = sum(placed_potential(charges_at_scale([charge], 0, SHAPE), CHARGE_RADIUS, points) for charge in placed)
    np.testing.assert_allclose(
        placed_potential(charges_at_scale(placed, 0, SHAPE), CHARGE_RADIUS, points), apart, atol=1e-9
    )


@pytest.mark.parametrize("scale", [1, 2, 3])
def test_the_force_at_a_place_of_the_image_is_the_same_at_all_scales(scale):
    placed = [PlacedCharge((70.3, 61.8), 2.5), PlacedCharge((20.0, 90.0), -4.0)]
    pixels = np.array([(10, 8), (4, 5), (0, 11), (7, 3)])
    places = to_image(pixels.astype(float), scale, SHAPE)
    force = placed_forces(charges_at_scale(placed, scale, SHAPE), charge_radius_at(scale), grid(20, 20))
    np.testing.assert_allclose(force[tuple(pixels.T)], cut(sum(law(charge, places) for charge in placed)), atol=1e-5)
    potential = placed_potential(charges_at_scale(placed, scale, SHAPE), charge_radius_at(scale), pixels.astype(float))
    there = placed_potential(charges_at_scale(placed, 0, SHAPE), CHARGE_RADIUS, places)
    np.testing.assert_allclose(potential * 2.0**scale, there, atol=1e-9)


def test_a_scale_field_with_charges_does_not_depend_on_their_history(engine):
    generator = np.random.default_rng(4)
    placed = [PlacedCharge(tuple(generator.uniform(-10, 200, 2)), q) for q in generator.uniform(-9, 9, 12)]
    scale_field = engine.scale_field(PARAMETERS)
    want = scale_field.lorentz + np.moveaxis(
        placed_forces(charges_at_scale(placed, 0, TWO.shape), CHARGE_RADIUS, grid(128, 256)), -1, 0
    )
    for some in (placed[:3], placed[2:9], placed[::-1], placed[5:6], placed):
        got = engine._field_with(scale_field, 0, sort_charges(some)).lorentz.copy()
    np.testing.assert_allclose(got, want, atol=1e-6)
    np.testing.assert_allclose(engine.force_field(PARAMETERS, 0, placed), want, atol=1e-6)
    assert engine._field_with(scale_field, 0, ()) is scale_field


@pytest.mark.parametrize("strength", [2.0, 6.0, 10.0])
def test_a_particle_far_from_all_edges_comes_to_rest_at_an_attracting_charge(strength):
    scene = disk((160, 160), (79.5, 79.5), 75.0)
    engine = Engine(scene.values, PARAMETERS)
    charge = PlacedCharge((79.5, 79.5), strength)
    for angle in (0.0, 1.1, 2.9, 4.4):
        start = np.array([(79.5 + 24.0 * np.sin(angle), 79.5 + 24.0 * np.cos(angle))])
        last = run(engine, engine.start(start), PARAMETERS, [charge])
        assert last.converged
        assert np.hypot(*(last.position[0] - charge.position)) < 0.7 * CHARGE_RADIUS
        free = run(engine, engine.start(start), PARAMETERS)
        assert np.hypot(*(free.position - 79.5).T).min() > 70.0
        assert not engine.result(last, PARAMETERS).contours


def test_many_particles_gather_around_a_charge_and_keep_their_distance():
    engine = Engine(disk((160, 160), (79.5, 79.5), 75.0).values, PARAMETERS)
    last = run(engine, engine.start(circle((79.5, 79.5), 12.0)), PARAMETERS, [PlacedCharge((79.5, 79.5), 5.0)])
    assert last.converged
    assert last.count >= 10
    away = np.hypot(*(last.position[:, None] - last.position).transpose(2, 0, 1))
    assert away[away > 0.0].min() > 0.5 * PARAMETERS.d_min
    assert np.hypot(*(last.position - 79.5).T).max() < CHARGE_REACH
    assert not engine.result(last, PARAMETERS).contours


@pytest.mark.parametrize("strength", [-10.0, -3.0, 4.0, 10.0])
def test_a_strong_charge_clears_the_edge_near_it_and_the_run_comes_to_rest(engine, resting, strength):
    at = (63.4, 80.3 + CHARGE_RADIUS)  # its radius away from the left disk's boundary
    last = run(engine, resting.resume(), PARAMETERS, [PlacedCharge(at, strength)])
    assert last.converged
    on_edge = np.abs(np.hypot(*(last.position - (63.4, 50.3)).T) - 30.0) < 1.5
    assert np.hypot(*(last.position[on_edge] - at).T).min() > 1.1 * CHARGE_RADIUS
    assert np.hypot(*(resting.position - at).T).min() < 1.1 * CHARGE_RADIUS
    assert on_edge.sum() > 40
    closed = [contour.closed for contour in engine.result(last, PARAMETERS).contours]
    assert abs(strength) < 10.0 or closed.count(True) == 1  # a narrow gap is walked across


def test_a_charge_that_changes_reactivates_the_particles_in_reach_and_no_others(engine, resting):
    before = (PlacedCharge((63.4, 60.0), 0.5),)
    calm = run(engine, resting.resume(), PARAMETERS, before)
    assert calm.converged
    for state, after in ((resting, before), (calm, (PlacedCharge((63.4, 66.0), 0.5),)), (calm, ())):
        step = state.resume()
        places = [charge.position for charge in changed_charges(state.charges, after)]
        far = np.min([np.hypot(*(state.position - place).T) for place in places], axis=0)
        idle = idle_steps_at(engine.step(step, PARAMETERS, after).coverage, state.position, step.step_of_scale, -1)
        was = idle_steps_at(step.coverage, state.position, step.step_of_scale, -1)
        assert (idle[far < CHARGE_REACH] <= 0).all()
        assert (idle[far > CHARGE_REACH + 6.0] == was[far > CHARGE_REACH + 6.0]).all()
        assert (was > 25).all()
        others = np.flatnonzero(far > CHARGE_REACH + 6.0)
        assert len(others) > 50
        moved = engine.step(step, PARAMETERS, after)
        both = moved.particles.position[np.isin(moved.particles.identity, state.particles.identity[others])]
        assert sorted(map(tuple, both)) == sorted(map(tuple, state.particles.position[others]))


@pytest.mark.parametrize(
    ("position", "strength", "words"),
    [
        ((1.0, 2.0), 10.5, "the strength of a placed charge is 10.5 but must be a number from -10 to 10."),
        ((1.0, 2.0), float("nan"), "the strength of a placed charge is nan but"),
        ((1.0, 2.0), "much", 'the strength of a placed charge is "much" but'),
        ((1.0, float("inf")), 1.0, r"the position of a placed charge is \(1, inf\) but must be finite."),
        ((1.0,), 1.0, r"the position of a placed charge is \(1.0,\) but must be a row and a column."),
    ],
)
def test_charges_out_of_range_are_refused(position, strength, words):
    with pytest.raises(ValueError, match=words):
        PlacedCharge(position, strength)
