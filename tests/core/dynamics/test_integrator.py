"""One compiled step of all particles, against eq. (12)-(15) in double precision on hand-made scale fields."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cpm_core import Parameters
from cpm_core.field.scale_field import GATE, build_scale_field
from cpm_core.model.equations import Moved, damped_series, damping, is_stuck, repulsion_left
from cpm_core.model.plane import motion as plane
from cpm_core.model.plane.motion import contact_at, is_at_rest, mesh_force_for, move
from cpm_core.model.plane.repulsion import NO_MESH, mesh_force
from cpm_core.model.state import MEMORY, Particles
from cpm_core.numerics import parallel

from .moving import coulomb, edge_contact, even_scale_field, repulsion, spacing
from .moving import crowds as crowded

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
    after = move(particles, np.full(len(particles), idle), mesh, scale_field, parameters)
    return after.particles, after.motion


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
        rng.uniform(20.0, 50.0, (count, MEMORY)),
        np.arange(count),
    )


@pytest.mark.parametrize(("kernels", "shape"), [pytest.param(plane, (35, 45), id="plane")])
class TestIntegrator:
    """What holds for a step in any dimension."""

    def stepped(self, kernels, shape, before, idle, parameters, lorentz, mesh=None):
        scale_field = even_scale_field(shape, tuple(lorentz))
        mesh = kernels.mesh_force_for(before, idle, scale_field, parameters) if mesh is None else mesh
        return kernels.move(before, idle, mesh, scale_field, parameters)

    @settings(max_examples=40, deadline=None)
    @example(seed=871, beta=0.0, w1=0.4)
    @given(seed=st.integers(0, 10**6), beta=st.sampled_from([0.0, 0.8]), w1=st.sampled_from([0.4, 1.6]))
    def test_a_step_is_eq_12_14_and_15_under_the_force_of_all_pairs(self, kernels, shape, seed, beta, w1):
        """Where the Lorentz force is of unit size, and there is no friction; each with its own idle steps."""
        rng, parameters = np.random.default_rng(seed), Parameters(beta=beta, w1=w1, time_step=0.3)
        before = aged(crowded(shape, seed), seed)
        idle, lorentz = rng.integers(0, 90, len(before)), rng.normal(size=len(shape))
        lorentz /= np.linalg.norm(lorentz)
        after = self.stepped(kernels, shape, before, idle, parameters, lorentz)
        left = np.array([repulsion_left(steps) for steps in idle])
        force = force_truth(before.position, parameters, left, lorentz)
        np.testing.assert_allclose(after.particles.force[:, 0], force, rtol=0, atol=SINGLE)
        np.testing.assert_array_equal(after.particles.force[:, 1], before.force[:, 0])
        series = np.array([damped_series(damping(beta, steps) * 0.3) for steps in idle]).reshape(-1, 4)  # also of none
        keep, one, two, three = series.T[..., None]
        force, (last, older), v = after.particles.force[:, 0], before.force.swapaxes(0, 1), before.velocity
        slope = (3.0 * force - 4.0 * last + older) / 0.6
        position = before.position + 0.3 * one * v + 0.09 * two * force + 0.027 * three * slope
        np.testing.assert_allclose(after.particles.position, position, atol=1e-12)
        np.testing.assert_allclose(
            after.particles.velocity, keep * v + 0.3 * one * force + 0.09 * two * slope, atol=1e-12
        )
        np.testing.assert_allclose(after.motion, np.linalg.norm(position - before.position, axis=1), atol=1e-12)

    def test_particles_at_rest_stay_and_no_others(self, kernels, shape):
        before, idle = aged(cloud(80, 1, shape), speed=0.0), np.repeat([20, 100], 40)
        before.velocity[::3] = 0.01
        before.distance[::5, -1] = np.nan
        at_rest = is_at_rest(before, idle)
        np.testing.assert_array_equal(at_rest, (idle == 100) & (np.arange(80) % 3 > 0) & (np.arange(80) % 5 > 0))
        after = self.stepped(kernels, shape, before, idle, DEFAULT, np.eye(len(shape))[0])
        np.testing.assert_array_equal(after.motion == 0.0, at_rest)


coordinate = st.integers(-4, 69 * 8 + 4).map(lambda n: n / 8.0)
places = st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=40)
heap = st.tuples(st.tuples(coordinate, coordinate), st.lists(st.tuples(st.integers(0, 8), st.integers(0, 8)))).map(
    lambda h: [(min(h[0][0] + y / 8.0, 69.5), h[0][1] + x / 8.0) for y, x in h[1]]
)
crowds = st.tuples(places, heap).map(lambda c: np.array(c[0] + c[1], dtype=float))


@settings(max_examples=80, deadline=None)
@given(crowds, st.sampled_from([0.5, 2.0, 6.0]), st.sampled_from([0.0, 1.0, 3.0]), st.sampled_from([0.4, 1.6]))
def test_force_is_the_normalized_coulomb_force_and_the_lorentz_force(points, d_min, d_max, w1):
    """With any number of particles on the same spot, and of equal distances."""
    parameters = Parameters(d_min=d_min, d_max=d_max, w1=w1, w2=1.75)
    after, _ = moved(points, parameters)
    np.testing.assert_allclose(after.force[:, 0], force_truth(points, parameters), rtol=0, atol=SINGLE)


@pytest.mark.parametrize("count", [2, 30, 300, 1500])
def test_force_on_a_cloud_is_the_sum_over_all_pairs(count):
    points = cloud(count, seed=count, shape=(300, 280))
    after, _ = moved(points, shape=(300, 280))
    np.testing.assert_allclose(after.force[:, 0], force_truth(points), rtol=0, atol=SINGLE)


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


def test_a_mesh_is_made_where_there_are_many_particles_only():
    few, many = Particles.at_rest(cloud(20)), Particles.at_rest(cloud(2000))
    scale_field = even_scale_field(SHAPE, LORENTZ)
    assert mesh_force_for(few, np.zeros(20, int), scale_field, DEFAULT) is NO_MESH
    served = mesh_force_for(many, np.zeros(2000, int), scale_field, DEFAULT)
    assert len(served.force)
    assert served.reach == 2.0 * (DEFAULT.d_min + DEFAULT.d_max)
    assert mesh_force_for(many, np.full(2000, 1000), scale_field, DEFAULT) is NO_MESH  # the repulsion has faded for all


def test_nearest_particles_beyond_the_reach_of_a_mesh_are_found():
    """Spacings of up to forty px, the reach being ten: the search goes farther than the cells around a particle."""
    points = np.array([(10.0, 10.0), (10.0, 38.0), (44.0, 10.0), (66.0, 86.0), (66.0, 80.0)])
    after, _ = moved(points, mesh=mesh_force(points, SHAPE, 10.0))
    near, _ = moved(points)
    scale = 0.5 * spacing(points, DEFAULT) ** 2
    error = np.hypot(*(after.force[:, 0] - near.force[:, 0]).T)
    assert np.all(error < DEFAULT.w1 * scale * 0.003 + SINGLE)


def test_only_the_lorentz_force_acts_on_a_single_particle():
    after, motion = moved(np.array([(30.0, 40.0)]))
    np.testing.assert_allclose(after.force[0, 0], 1.75 * np.array(LORENTZ), atol=1e-6)
    assert motion[0] > 0.0


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


def test_equal_distances_count_as_often_as_they_occur():
    """On a grid the two nearest are at one pitch both, at the end of a row of three at one and two."""
    grid = np.stack(np.meshgrid(np.arange(10.0, 60.0, 3.0), np.arange(10.0, 60.0, 3.0)), axis=-1).reshape(-1, 2)
    after, _ = moved(grid)
    np.testing.assert_allclose(after.force[:, 0], force_truth(grid), rtol=0, atol=SINGLE)
    row = np.array([(10.0, 10.0), (10.0, 12.0), (10.0, 14.0)])
    assert spacing(row, DEFAULT).tolist() == [3.0, 2.0, 3.0]
    after, _ = moved(row)
    np.testing.assert_allclose(after.force[:, 0], force_truth(row), rtol=0, atol=SINGLE)


@pytest.mark.parametrize("count", [2, 3, 17, 40])
def test_particles_on_one_spot_do_not_act_on_each_other(count):
    after, _ = moved(np.full((count, 2), 33.7))
    np.testing.assert_allclose(after.force[:, 0], np.tile(1.75 * np.array(LORENTZ), (count, 1)), atol=1e-6)


def test_nor_do_they_on_one_spot_beside_others():
    points = np.concatenate([cloud(50, 1), np.full((5, 2), 20.0), np.tile(cloud(50, 1)[:4], (3, 1))])
    after, _ = moved(points)
    np.testing.assert_allclose(after.force[:, 0], force_truth(points), rtol=0, atol=SINGLE)


@pytest.mark.parametrize("mesh", [False, True])
def test_all_particles_of_a_crowd_act(mesh):
    """Three hundred within four pixels."""
    points = np.concatenate([np.random.default_rng(3).uniform(20.0, 24.0, (300, 2)), cloud(20, 4)])
    served = mesh_force(points, SHAPE, 10.0) if mesh else NO_MESH
    after, _ = moved(points, mesh=served)
    crowd = after.force[:300, 0] - force_truth(points)[:300]
    assert np.hypot(*crowd.T).max() < (0.01 if mesh else 5 * SINGLE)


def test_coordinates_far_from_the_origin_cost_digits_and_no_more():
    """At 2000 px a place is known to 1e-4 px in single precision, so that of pairs 0.3 px apart to 1e-3."""
    points = np.array([1980.0, 1480.0]) + 9.0 * cloud(60, 2, (1, 1))
    after, _ = moved(points, shape=(2000, 1500))
    np.testing.assert_allclose(after.force[:, 0], force_truth(points), rtol=0, atol=0.02)


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
    keep, one, two, three = damped_series(damping(beta, idle) * dt)
    v = before.velocity
    position = before.position + dt * one * v + dt**2 * two * after.force[:, 0] + dt**3 * three * slope
    np.testing.assert_allclose(after.position, position, atol=1e-12)
    velocity = keep * v + dt * one * after.force[:, 0] + dt**2 * two * slope
    np.testing.assert_allclose(after.velocity, velocity, atol=1e-12)
    np.testing.assert_allclose(motion, np.hypot(*(after.position - before.position).T), atol=1e-12)


def test_history_of_distances_is_shifted_by_one():
    before = aged(cloud(30, 1))
    after, _ = moved(before)
    np.testing.assert_array_equal(after.distance[:, 1:], before.distance[:, :-1])
    np.testing.assert_allclose(after.distance[:, 0], np.hypot(*after.position.T), rtol=1e-14)
    np.testing.assert_array_equal(after.identity, before.identity)


def test_each_particle_follows_its_own_idle_steps():
    """The repulsion that is left, the damping and the friction are those of each particle, not of its neighbors."""
    before = aged(cloud(60, 12), seed=13)
    idle = np.random.default_rng(14).integers(0, 300, 60)
    after, _ = moved(before, idle=idle)
    left = np.array([repulsion_left(steps) for steps in idle])
    np.testing.assert_allclose(after.force[:, 0], force_truth(before.position, left=left), rtol=0, atol=SINGLE)
    for i in range(60):
        alike, _ = moved(before, idle=int(idle[i]))
        for name in ("position", "velocity", "force"):
            np.testing.assert_array_equal(getattr(after, name)[i], getattr(alike, name)[i])


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


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.0, 3.0), st.floats(-1.0, 1.0), st.sampled_from([0, 10, 20]))
def test_friction_takes_what_goes_along_the_edge_or_nothing(seed, angle, size, idle):
    """Of force, velocity and history; for particles on an edge that are slow along it, under a small force along it."""
    before = aged(8.0 * cloud(30, seed, (8, 8)) + 4.0, seed)
    after, whole, normal = on_edge(before, angle, size, idle)
    tangent = np.array([-normal[1], normal[0]])
    pull, speed = np.abs(whole @ tangent), np.abs(before.velocity @ tangent)
    held = np.array([is_stuck(p, s, 1.6, idle) for p, s in zip(pull, speed, strict=True)]) & (abs(size) < GATE)
    for moving, one in ((~held, np.eye(2)), (held, np.outer(normal, normal))):
        force, v = whole[moving] @ one, before.velocity[moving] @ one
        last, older = before.force[moving, 0] @ one, before.force[moving, 1] @ one
        slope = (3.0 * force - 4.0 * last + older) / 0.6
        np.testing.assert_allclose(after.force[moving, 0], force, rtol=0, atol=2 * SINGLE)
        np.testing.assert_allclose(after.force[moving, 1], last, atol=1e-6)
        np.testing.assert_allclose(after.velocity[moving], v + 0.3 * force + 0.045 * slope, atol=2 * SINGLE)
        position = before.position[moving] + 0.3 * v + 0.045 * force + 0.0045 * slope
        np.testing.assert_allclose(after.position[moving], position, atol=2 * SINGLE)


@pytest.mark.parametrize(
    ("size", "speed", "held"),
    [(0.2, 0.01, True), (-0.2, 0.01, True), (0.99, 0.01, False), (0.2, 2.0, False)],
    ids=["on an edge", "on its other side", "free", "fast"],
)
def test_friction_holds_the_slow_on_an_edge_alone(size, speed, held):
    """No particle is near enough to push the one on the edge along it."""
    before = Particles.at_rest(np.array([(30.0, 40.0)]))
    before.velocity[:, 1] = speed
    after, _ = moved(before, scale_field=even_scale_field(SHAPE, (size, 0.0), (5.0, 0.0)))
    assert (after.position[0, 1] == 40.0) == (after.velocity[0, 1] == 0.0) == held
    assert (after.position[0, 0] - 30.0) * size > 0.0


def test_friction_without_a_normal_holds_the_slow_under_a_small_force_and_no_others():
    """Where there is no gradient, as between two attractions that balance, all directions are alike."""
    grid = 4.0 + 3.0 * np.argwhere(np.ones((20, 20), bool))
    points = grid + np.random.default_rng(1).uniform(0.0, 1.2, grid.shape)
    scale_field = even_scale_field(SHAPE, (0.0, 0.0))
    pull = np.hypot(*force_truth(points, lorentz=(0.0, 0.0)).T)
    weak, strong = pull < 0.24 * DEFAULT.w1, pull > 0.26 * DEFAULT.w1
    assert weak.sum() > 10
    assert strong.sum() > 10
    _, motion = moved(points, scale_field=scale_field)
    assert not motion[weak].any()
    assert motion[strong].all()
    flying = Particles.at_rest(points)
    flying.velocity[:] = 1.0
    after, motion = moved(flying, scale_field=scale_field)
    assert np.all(motion > 0.1)
    np.testing.assert_allclose(after.force[:, 0], force_truth(points, lorentz=(0.0, 0.0)), rtol=0, atol=SINGLE)


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


def test_particles_at_rest_do_not_change_the_motion_of_others():
    before, idle = partly_at_rest()
    after, _ = moved(before, idle=idle)
    young = Particles(
        before.position, before.velocity, before.force, np.full_like(before.distance, np.nan), before.identity
    )
    every, motion = moved(young, idle=idle)  # the young are not at rest
    assert np.all(motion > 0.0)
    others = idle == 20
    for name in ("position", "velocity", "force"):
        assert getattr(after, name)[others].tobytes() == getattr(every, name)[others].tobytes()


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
        monkeypatch.setattr(parallel, "cores", lambda cores=cores: cores)
        after, motion = moved(before, mesh=served)
        quantities = (after.position, after.velocity, after.force, after.distance, motion)
        bits.append([quantity.tobytes() for quantity in quantities])
    assert bits[0] == bits[1] == bits[2]


@pytest.mark.parametrize("mesh", [False, True])
def test_the_order_of_particles_does_not_matter_but_for_rounding(mesh):
    before = aged(cloud(500, 10))
    order = np.random.default_rng(11).permutation(500)
    served = mesh_force(before.position, SHAPE, 10.0) if mesh else NO_MESH
    one, _ = moved(before, mesh=served)
    other, _ = moved(before.taken(order), mesh=served)
    np.testing.assert_array_equal(other.identity, one.identity[order])
    np.testing.assert_allclose(other.force, one.force[order], rtol=0, atol=1e-4)
    np.testing.assert_allclose(other.position, one.position[order], rtol=0, atol=1e-4)


def test_a_step_leaves_the_particles_that_it_starts_from_alone():
    before = aged(cloud(50))
    kept = [getattr(before, name).copy() for name in ("position", "velocity", "force", "distance")]
    moved(before)
    for name, quantity in zip(("position", "velocity", "force", "distance"), kept, strict=True):
        np.testing.assert_array_equal(getattr(before, name), quantity)


def test_a_step_of_no_particles_is_possible():
    after, motion = moved(np.zeros((0, 2)))
    assert len(after) == len(motion) == 0


def test_far_particles_push_with_the_inverse_square_through_a_mesh():
    """Two heaps at opposite ends, each of which pushes on the others alone."""
    points = np.concatenate([np.array([8.0, 8.0]) + cloud(3, 0, (2, 2)), np.array([60.0, 80.0]) + cloud(3, 1, (2, 2))])
    after, _ = moved(points, mesh=mesh_force(points, SHAPE, 10.0))
    assert np.hypot(*coulomb(points).T).max() > 0.1
    np.testing.assert_allclose(after.force[:, 0], force_truth(points), rtol=0, atol=0.01)


def test_a_step_returns_the_edge_contact_after_it():
    """The same as of the same positions, at rest or not; also behind a barrier, and of some of them."""
    image = np.zeros((40, 48))
    image[:, 22:] = 100.0
    scale_field = build_scale_field(image, 1.0, 0.0)
    points = cloud(60, 3, (39, 47))
    resting = replace(Particles.at_rest(points), distance=np.ones((60, 4)))
    for idle in (0, 500):
        after = move(resting, np.full(60, idle), NO_MESH, scale_field, DEFAULT)
        contact = edge_contact(after.particles.position, scale_field, 5.0)
        np.testing.assert_array_equal(after.strength, contact.strength)
        np.testing.assert_array_equal(after.on_edge, contact.on_edge)
        held = Moved.held_at(Particles.at_rest(points), points, contact_at(points, scale_field))
        np.testing.assert_array_equal(held.on_edge, edge_contact(points, scale_field, 5.0).on_edge)
        assert not held.motion.any()
        some = points[:, 0] > 20.0
        np.testing.assert_array_equal(after.where(some).strength, after.strength[some])
        np.testing.assert_array_equal(after.where(some).particles.position, after.particles.position[some])
