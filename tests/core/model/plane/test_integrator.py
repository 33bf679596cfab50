"""One compiled step of all particles, against eq. (12)-(15) in double precision on hand-made scale fields."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import Parameters
from cpm_core.field.scale_field import ON_EDGE_FORCE
from cpm_core.model.equations import MAX_TRAVEL, damped_series, damping_coefficient, is_stuck, repulsion_left
from cpm_core.model.plane.motion import move_in_plane
from cpm_core.model.plane.repulsion import NO_MESH, mesh_force
from cpm_core.model.state import HISTORY_STEPS, Particles
from cpm_core.numerics import parallel

from ..moving import even_scale_field, repulsion, spacing

SHAPE = (70, 90)
LORENTZ = (0.6, -0.8)
"""Of unit size: no particle is on an edge, and there is no friction."""

DEFAULT = Parameters()
SINGLE = 2e-4
"""Error that single precision leaves in a force of unit size, of particles no nearer than a tenth of a pixel."""


def moved(points, parameters=DEFAULT, mesh=NO_MESH, shape=SHAPE, scale_field=None, idle=0):
    """Particles, or those at some positions, after a step; `idle` steps after cells around each were newly covered."""
    particles = points if isinstance(points, Particles) else Particles.at_rest(points)
    scale_field = scale_field or even_scale_field(shape, LORENTZ)
    return move_in_plane(particles, np.full(len(particles), idle), mesh, scale_field, parameters)


def force_truth(points, parameters=DEFAULT, left=1.0, lorentz=LORENTZ):
    """Eq. (12) without the damping."""
    fraction = np.broadcast_to(left, len(points))[:, None]
    return parameters.w1 * fraction * repulsion(points, parameters) + parameters.w2 * np.array(lorentz)


def cloud(count, seed=0, shape=SHAPE):
    return np.random.default_rng(seed).uniform(-0.5, np.array(shape) - 0.5, (count, len(shape)))


def aged(points, seed=0, speed=0.5):
    """Particles that have been there for long, with motion and history."""
    rng = np.random.default_rng(seed)
    count, dimension = np.shape(points)
    return Particles(
        np.array(points, dtype=float),
        speed * rng.normal(size=(count, dimension)),
        rng.normal(size=(count, 2, dimension)),
        rng.uniform(20.0, 50.0, (count, HISTORY_STEPS)),
        np.arange(count),
        np.zeros(count),
    )


coordinate = st.integers(-4, 69 * 8 + 4).map(lambda n: n / 8.0)
places = st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=40)
heap = st.tuples(st.tuples(coordinate, coordinate), st.lists(st.tuples(st.integers(0, 8), st.integers(0, 8)))).map(
    lambda h: [(min(h[0][0] + y / 8.0, 69.5), h[0][1] + x / 8.0) for y, x in h[1]]
)
crowds = st.tuples(places, heap).map(lambda c: np.array(c[0] + c[1], dtype=float))


@settings(max_examples=24, deadline=None)
@given(crowds, st.sampled_from([0.5, 2.0, 6.0]), st.sampled_from([0.0, 1.0, 3.0]), st.sampled_from([0.4, 1.6]))
def test_force_is_the_normalized_coulomb_force_and_the_lorentz_force(points, d_min, d_max, w1):
    """With any number of particles on the same spot, and of equal distances."""
    parameters = Parameters(d_min=d_min, d_max=d_max, w1=w1, w2=1.75)
    after, _ = moved(points, parameters)
    np.testing.assert_allclose(after.force[:, 0], force_truth(points, parameters), rtol=0, atol=SINGLE)


def test_force_on_a_curve_by_way_of_a_mesh_is_as_good_as_the_mesh():
    """0.006 at particles 2 px apart, twice as much when normalized, which is far below what friction holds."""
    angle = np.linspace(0.0, 2.0 * np.pi, 88, endpoint=False)
    points = np.stack([34.3 + 28.0 * np.sin(angle), 44.8 + 28.0 * np.cos(angle)], axis=1)
    after, _ = moved(points, mesh=mesh_force(points, SHAPE, 10.0))
    error = np.hypot(*(after.force[:, 0] - force_truth(points)).T)
    assert error.max() < 2.0 * DEFAULT.w1 * 0.006
    assert error.max() < 0.1 * 0.25 * DEFAULT.w1


@pytest.mark.parametrize("reach", [6.0, 10.0, 25.0])
def test_force_on_a_cloud_by_way_of_a_mesh_is_as_good_as_the_mesh(reach):
    """The error is one of the sum, of the order of 1 / reach^2, and is scaled by the spacing with it."""
    points = cloud(400, seed=5)
    after, _ = moved(points, mesh=mesh_force(points, SHAPE, reach))
    scale = 0.5 * spacing(points, DEFAULT) ** 2 * np.minimum(1.0, spacing(points, DEFAULT) / DEFAULT.d_min)
    error = np.hypot(*(after.force[:, 0] - force_truth(points)).T)
    within = 400 * np.pi * reach**2 / (SHAPE[0] * SHAPE[1])
    assert np.all(error < DEFAULT.w1 * scale * 0.2 * (1.0 + 0.3 * within) / reach**2 + SINGLE)


def test_nearest_particles_beyond_the_reach_of_a_mesh_are_found():
    """Spacings of up to forty px, the reach being ten: the search goes farther than the cells around a particle."""
    points = np.array([(10.0, 10.0), (10.0, 38.0), (44.0, 10.0), (66.0, 86.0), (66.0, 80.0)])
    after, _ = moved(points, mesh=mesh_force(points, SHAPE, 10.0))
    near, _ = moved(points)
    scale = 0.5 * spacing(points, DEFAULT) ** 2
    error = np.hypot(*(after.force[:, 0] - near.force[:, 0]).T)
    assert np.all(error < DEFAULT.w1 * scale * 0.003 + SINGLE)


def awkward_places(size):
    """Coordinates that two ways of taking off a multiple of `size` round to neighbouring single-precision numbers."""
    out = []
    for cell in range(1, 7):
        product = cell * size
        rest = Fraction(cell) * Fraction(size) - Fraction(product)
        if rest:
            low = np.float32(0.3 * size)
            high = np.nextafter(low, np.float32(np.inf))
            tie = 0.5 * (float(low) + float(high))
            out += [product + tie, np.nextafter(product + tie, 0.0), np.nextafter(product + tie, 1e9)]
    return out


@pytest.mark.parametrize("d_min", [1.9, 2.1, 2.3, 2.7])
def test_no_particle_pushes_itself_however_its_place_is_rounded(d_min):
    """One whose rounded place differs from its own would have itself at a distance of 1e-6 px."""
    parameters = Parameters(d_min=d_min)
    reach = 2.0 * (d_min + parameters.d_max)
    some = awkward_places(reach)
    for y in some:
        points = np.array([(y, 30.0), (y, 60.0), (y + 20.0, 44.0)])
        served = mesh_force(points, (120, 90), reach)
        after, _ = moved(points, parameters, mesh=served, shape=(120, 90))
        scale = 0.5 * spacing(points, parameters) ** 2
        error = np.hypot(*(after.force[:, 0] - force_truth(points, parameters)).T)
        assert np.all(error < parameters.w1 * scale * 0.003 + SINGLE)


@pytest.mark.parametrize("count", [2, 3, 17, 40])
def test_particles_on_one_spot_do_not_act_on_each_other(count):
    after, _ = moved(np.full((count, 2), 33.7))
    np.testing.assert_allclose(after.force[:, 0], np.tile(1.75 * np.array(LORENTZ), (count, 1)), atol=1e-6)


@pytest.mark.parametrize("mesh", [False, True])
def test_all_particles_of_a_crowd_act(mesh):
    """Three hundred within four pixels."""
    points = np.concatenate([np.random.default_rng(3).uniform(20.0, 24.0, (300, 2)), cloud(20, 4)])
    served = mesh_force(points, SHAPE, 10.0) if mesh else NO_MESH
    after, _ = moved(points, mesh=served)
    crowd = after.force[:300, 0] - force_truth(points)[:300]
    assert np.hypot(*crowd.T).max() < (0.01 if mesh else 5 * SINGLE)


@pytest.mark.parametrize("beta", [0.0, 0.8, 4.0])
@pytest.mark.parametrize("idle", [0, 30, 80, 400])
def test_step_is_eq_14_and_15_damped_by_the_idle_steps(beta, idle):
    """Force history, repulsion left and damping as they are after so many idle steps."""
    parameters = Parameters(beta=beta, time_step=0.3)
    before = aged(cloud(40, 7), seed=8)
    after, motion = moved(before, parameters, idle=idle)
    force = force_truth(before.position, parameters, repulsion_left(idle))
    np.testing.assert_allclose(after.force[:, 0], force, rtol=0, atol=SINGLE)
    np.testing.assert_array_equal(after.force[:, 1], before.force[:, 0])
    last, older = before.force[:, 0], before.force[:, 1]
    dt, slope = 0.3, (3.0 * after.force[:, 0] - 4.0 * last + older) / 0.6
    keep, one, two, three = damped_series(damping_coefficient(beta, idle) * dt)
    v = before.velocity
    position = before.position + dt * one * v + dt**2 * two * after.force[:, 0] + dt**3 * three * slope
    np.testing.assert_allclose(after.position, position, atol=1e-12)
    velocity = keep * v + dt * one * after.force[:, 0] + dt**2 * two * slope
    np.testing.assert_allclose(after.velocity, velocity, atol=1e-12)
    np.testing.assert_allclose(motion, np.hypot(*(after.position - before.position).T), atol=1e-12)


def on_edge(before, angle, size, idle):
    """Particles after a step on a field of parallel edges, the force of eq. (12) on them, and the normal."""
    normal = np.array([np.sin(angle), np.cos(angle)])
    lorentz = size * normal
    parameters = Parameters(beta=0.0, time_step=0.3)
    scale_field = even_scale_field(SHAPE, tuple(lorentz), tuple(7.0 * normal))
    after, _ = moved(before, parameters, scale_field=scale_field, idle=idle)
    left = repulsion_left(idle)
    whole = force_truth(before.position, parameters, left, scale_field.packed[0, 0, :2].astype(float))
    return after, whole, normal


@settings(max_examples=16, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.1, 30.0), st.sampled_from([0.7, 2.0]), st.floats(0.0, 2.0))
def test_no_particle_moves_farther_in_a_step_than_half_of_d_min(seed, speed, d_min, beta):
    """Nor is it faster than that afterwards."""
    parameters = Parameters(beta=beta, time_step=0.5, d_min=d_min)
    before = aged(cloud(40, seed), seed, speed)
    after, motion = moved(before, parameters)
    farthest = MAX_TRAVEL * d_min
    assert motion.max() <= farthest * (1.0 + 1e-12)
    assert (0.5 * np.hypot(*after.velocity.T)).max() <= farthest * (1.0 + 1e-12)


def creeping(places, normal, area, before=0.0, floor=0.0):
    """Particles after a step on edges of one normal everywhere, with a way crept `before`, and their motion."""
    particles = aged(places, seed=3, speed=2.0)
    particles.crept[:] = before
    scale_field = even_scale_field(SHAPE, (0.0, 0.0), normal)
    return particles, moved(particles, scale_field=replace(scale_field, area=area, floor=floor))[0]


def test_what_a_particle_creeps_along_an_edge_outside_the_area_is_added_up_and_inside_it_is_none():
    area = np.zeros(SHAPE, bool)
    area[:, :45] = True
    before, after = creeping(cloud(60, 4), (1.0, 0.0), area, before=7.0)
    inside = after.position[:, 1] + 0.5 < 45.0
    assert 10 < inside.sum() < 50
    assert not after.crept[inside].any()
    along = np.abs(after.position[:, 1] - before.position[:, 1])  # the normal points down
    np.testing.assert_allclose(after.crept[~inside], 7.0 + along[~inside], rtol=1e-9)
    weak = creeping(cloud(60, 4), (1.0, 0.0), area, before=7.0, floor=1e9)[1]  # such as around a charge
    assert (weak.crept[~inside] == 7.0).all()


def test_flight_off_the_edges_is_no_creeping():
    particles = aged(cloud(60, 4), seed=3)
    after, motion = moved(particles, scale_field=replace(even_scale_field(SHAPE, LORENTZ), area=np.zeros(SHAPE, bool)))
    assert motion.min() > 0.0
    assert not after.crept.any()


@settings(max_examples=16, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.0, 3.0), st.floats(-1.0, 1.0), st.sampled_from([0, 10, 20]))
def test_friction_takes_what_goes_along_the_edge_or_nothing(seed, angle, size, idle):
    """Of force, velocity and history; for particles on an edge that are slow along it, under a small force along it."""
    before = aged(8.0 * cloud(30, seed, (8, 8)) + 4.0, seed)
    after, whole, normal = on_edge(before, angle, size, idle)
    tangent = np.array([-normal[1], normal[0]])
    pull, speed = np.abs(whole @ tangent), np.abs(before.velocity @ tangent)
    held = np.array([is_stuck(p, s, 1.6, idle) for p, s in zip(pull, speed, strict=True)]) & (abs(size) < ON_EDGE_FORCE)
    for moving, one in ((~held, np.eye(2)), (held, np.outer(normal, normal))):
        force, v = whole[moving] @ one, before.velocity[moving] @ one
        last, older = before.force[moving, 0] @ one, before.force[moving, 1] @ one
        slope = (3.0 * force - 4.0 * last + older) / 0.6
        np.testing.assert_allclose(after.force[moving, 0], force, rtol=0, atol=2 * SINGLE)
        np.testing.assert_allclose(after.force[moving, 1], last, atol=1e-6)
        np.testing.assert_allclose(after.velocity[moving], v + 0.3 * force + 0.045 * slope, atol=2 * SINGLE)
        position = before.position[moving] + 0.3 * v + 0.045 * force + 0.0045 * slope
        np.testing.assert_allclose(after.position[moving], position, atol=2 * SINGLE)


def partly_at_rest(speed=0.0):
    """Particles, and their idle steps: those in the lower half may be at rest."""
    points = np.stack(np.meshgrid(np.arange(6.0, 64.0, 3.0), np.arange(6.0, 84.0, 3.0), indexing="ij"), axis=-1)
    points = points.reshape(-1, 2) + np.random.default_rng(2).normal(0.0, 0.4, (points.size // 2, 2))
    return aged(points, speed=speed), np.where(points[:, 0] > 40.0, 100, 20)


def test_particles_at_rest_do_not_move():
    before, idle = partly_at_rest()
    after, motion = moved(before, idle=idle)
    at_rest = idle == 100
    np.testing.assert_array_equal(motion == 0.0, at_rest)
    np.testing.assert_array_equal(after.position[at_rest], before.position[at_rest])
    assert not after.velocity[at_rest].any()
    np.testing.assert_allclose(after.distance[at_rest, 0], np.hypot(*before.position[at_rest].T), rtol=1e-14)
    np.testing.assert_array_equal(after.distance[at_rest, 1:], before.distance[at_rest, :-1])


@pytest.mark.parametrize("idle", [0, 49, 50, 1000])
@pytest.mark.parametrize("speed", [0.0, 0.01])
@pytest.mark.parametrize("young", [False, True])
def test_only_slow_old_particles_without_repulsion_are_skipped(idle, speed, young):
    before, _ = partly_at_rest()
    before.velocity[:, 0] = speed
    if young:
        before.distance[:, -1] = np.nan
    _, motion = moved(before, idle=idle)
    skipped = repulsion_left(idle) == 0.0 and speed == 0.0 and not young
    assert np.all((motion == 0.0) == skipped)


@pytest.mark.parametrize("mesh", [False, True])
def test_same_bits_on_any_number_of_cores(monkeypatch, mesh):
    before = aged(cloud(1700, 9))
    served = mesh_force(before.position, SHAPE, 10.0) if mesh else NO_MESH
    bits = []
    for cores in (1, 2, 3):
        monkeypatch.setattr(parallel, "count_cores", lambda cores=cores: cores)
        after, motion = moved(before, mesh=served)
        quantities = (after.position, after.velocity, after.force, after.distance, motion)
        bits.append([quantity.tobytes() for quantity in quantities])
    assert bits[0] == bits[1] == bits[2]
