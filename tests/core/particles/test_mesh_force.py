"""The Coulomb force by way of a mesh, against eq. (9) pair by pair."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.model.plane import repulsion as plane
from cpm_core.model.plane.repulsion import NO_MESH, mesh_force, mesh_force_at, nodes, spline

from ..dynamics.moving import coulomb, offsets

REACH = 10.0
SHAPE = (121, 150)

CURVES, CROWDS = 0.008, 0.03
"""Largest error at a reach of 10 px: of particles 2 px apart on curves, whose neighbors push with 0.25 each (seen:
0.007 on a circle of 8 px, 0.004 on larger ones, 0.003 on lines), and of clouds of a particle to every 4 px squared,
many of which are nearer than that (seen: 0.021)."""


def left_out(mesh, points):
    """What the mesh leaves out of the force of pairs within the reach."""
    apart, distance = offsets(points)
    near = np.where(distance < mesh.reach, distance, 1.0)
    a, b, c = mesh.softening.astype(float)
    weight = np.where(distance < mesh.reach, near**-3.0 - (a + b * near**2 + c * near**4), 0.0)
    return (weight[..., None] * apart).sum(axis=1)


def whole_force(points, shape=SHAPE, reach=REACH):
    mesh = mesh_force(points, shape, reach)
    return left_out(mesh, points) + smooth_force(mesh, points)


def smooth_force(mesh, points):
    places = (points - np.array(mesh.first)) / mesh.pitch
    return np.array([mesh_force_at(mesh.force, down, right) for down, right in places])


def error(points, shape=SHAPE, reach=REACH):
    return np.hypot(*(whole_force(points, shape, reach) - coulomb(points)).T).max()


def on_circle(radius):
    angle = np.linspace(0.0, 2.0 * np.pi, int(np.pi * radius), endpoint=False)
    return np.stack([60.2 + radius * np.sin(angle), 74.7 + radius * np.cos(angle)], axis=1)


def on_line(angle):
    along = np.arange(-55.0, 55.1, 2.0)[:, None]
    return np.array([60.0, 74.5]) + along * [np.sin(angle), np.cos(angle)]


def cloud(count, seed, shape=SHAPE):
    return np.random.default_rng(seed).uniform(-0.5, np.array(shape) - 0.5, (count, len(shape)))


@pytest.mark.parametrize(("kernels", "shape"), [pytest.param(plane, (63, 64), id="plane")])
class TestMeshForce:
    """What holds for the force by way of a mesh in any dimension."""

    def smooth(self, kernels, mesh, points):
        places = (points - np.array(mesh.first)) / mesh.pitch
        return np.array([kernels.mesh_force_at(mesh.force, *place) for place in places])

    @settings(max_examples=20, deadline=None)
    @given(seed=st.integers(0, 10**6), reach=st.floats(3.0, 40.0))
    def test_with_the_near_pairs_it_is_the_sum_over_all_pairs(self, kernels, shape, seed, reach):
        """Also in the corners: what each particle adds to the error is at most 0.2 / reach^2."""
        corners = np.stack(np.meshgrid(*[(-0.5, n - 0.5) for n in shape]), axis=-1).reshape(-1, len(shape))
        points = np.concatenate([cloud(30, seed, shape), corners])
        mesh = kernels.mesh_force(points, shape, reach)
        force = left_out(mesh, points) + self.smooth(kernels, mesh, points)
        assert np.linalg.norm(force - coulomb(points), axis=1).max() < 0.2 * len(points) / reach**2

    def test_forces_add_up_particle_by_particle(self, kernels, shape):
        points, places = cloud(12, 3, shape), cloud(30, 4, shape)
        meshes = [kernels.mesh_force(some, shape, REACH) for some in (points, *points[:, None])]
        together, *alone = (self.smooth(kernels, mesh, places) for mesh in meshes)
        np.testing.assert_allclose(together, sum(alone), rtol=0, atol=1e-5)

    def test_momentum_is_conserved_to_single_precision(self, kernels, shape):
        """What one particle does to the others they do to it: the smooth forces add up to nothing."""
        points = cloud(300, 5, shape)
        force = self.smooth(kernels, kernels.mesh_force(points, shape, REACH), points)
        assert np.abs(force.sum(axis=0)).max() < 1e-4 * np.abs(force).sum()

    @pytest.mark.parametrize("axis", [0, -1])
    def test_mirrored_particles_have_mirrored_forces(self, kernels, shape, axis):
        points = cloud(80, 1, shape)
        mirrored = points.copy()
        mirrored[:, axis] = shape[axis] - 1.0 - points[:, axis]
        force, other = (self.smooth(kernels, kernels.mesh_force(p, shape, REACH), p) for p in (points, mirrored))
        force[:, axis] *= -1.0
        np.testing.assert_allclose(other, force, rtol=0, atol=3e-6 * len(points))


@pytest.mark.parametrize(
    "points",
    [*map(on_circle, (8.0, 25.0, 58.0)), *map(on_line, (0.0, 0.3, np.pi / 4, 1.3, np.pi / 2))],
    ids=["small", "middle", "large", "level", "slanting", "diagonal", "steep", "upright"],
)
def test_force_on_curves_is_the_sum_over_all_pairs(points):
    assert error(points) < CURVES


@pytest.mark.parametrize("seed", range(3))
def test_force_on_clouds_is_the_sum_over_all_pairs(seed):
    assert error(cloud(1000, seed, (63, 64)), (63, 64)) < CROWDS


@pytest.mark.parametrize("factor", [0.5, 2.0, 8.0])
def test_error_falls_with_the_square_of_the_scale(factor):
    """All lengths alike: image, positions and reach; so that the bound holds in units of 1 / reach^2."""
    pixels = round(63 * factor)
    points = (cloud(500, 0, (63, 63)) + 0.5) * factor - 0.5
    assert error(points, (pixels, pixels), factor * REACH) < CROWDS / factor**2


def test_one_particle_hardly_pushes_itself():
    """Wherever it stands between the nodes."""
    for place in np.random.default_rng(0).uniform(30.0, 90.0, (50, 2)):
        assert error(place[None]) < 0.5 * CURVES


def test_transposed_particles_have_transposed_forces():
    points = cloud(80, 2)
    force = smooth_force(mesh_force(points, SHAPE, REACH), points)
    other = smooth_force(mesh_force(points[:, ::-1].copy(), SHAPE[::-1], REACH), points[:, ::-1])
    np.testing.assert_allclose(other[:, ::-1], force, rtol=0, atol=3e-6 * len(points))


@settings(max_examples=100, deadline=None)
@given(st.floats(1.0, 1e3))
def test_spline_spreads_a_whole_charge_about_its_own_place(place):
    node, *weights = spline(place)
    nodes_at = np.arange(node, node + 3)
    assert sum(weights) == pytest.approx(1.0, abs=1e-12)
    assert np.dot(weights, nodes_at) == pytest.approx(place, abs=1e-9)
    # the second moment of a quadratic spline is a quarter, wherever it stands
    assert np.dot(weights, (nodes_at - place) ** 2) == pytest.approx(0.25, abs=1e-9)
    assert min(weights) >= 0.0


def test_all_charge_is_seen_from_far_away():
    """A group of particles at one end pushes at the other like one particle of their whole charge, to the digits that
    single precision leaves beside the forces inside the group."""
    heap = np.array([10.0, 10.0]) + np.random.default_rng(6).uniform(-0.5, 0.5, (200, 2))
    (force,) = smooth_force(mesh_force(heap, SHAPE, REACH), np.array([(110.0, 140.0)]))
    truth = coulomb(np.concatenate([heap, [(110.0, 140.0)]]))[-1]
    np.testing.assert_allclose(force, truth, rtol=0, atol=1e-6 * len(heap))
    assert np.hypot(*truth) > 30.0 * 1e-6 * len(heap)


@pytest.mark.parametrize("reach", [3.0, 10.0, 70.0])
def test_softening_meets_the_inverse_square_with_two_derivatives_at_the_reach(reach):
    a, b, c = mesh_force(cloud(1, 0), SHAPE, reach).softening.astype(float)
    soft = np.polynomial.Polynomial([0.0, a, 0.0, b, 0.0, c])
    inverse_square = [reach**-2.0, -2.0 * reach**-3.0, 6.0 * reach**-4.0]
    found = [soft(reach), soft.deriv()(reach), soft.deriv(2)(reach)]
    np.testing.assert_allclose(found, inverse_square, rtol=1e-5)
    inside = np.linspace(0.0, reach, 50)[1:-1]
    assert np.all(soft(inside) < inside**-2.0)
    assert np.all(soft(inside) >= 0.0)


def test_without_a_mesh_nothing_is_softened_or_left_out():
    assert not NO_MESH.softening.any()
    assert NO_MESH.reach == np.inf
    assert len(NO_MESH.force) == 0


def test_same_particles_same_bits():
    points = cloud(200, 7)
    assert mesh_force(points, SHAPE, REACH).force.tobytes() == mesh_force(points, SHAPE, REACH).force.tobytes()


def test_no_particle_exerts_no_force():
    assert not mesh_force(np.zeros((0, 2)), SHAPE, REACH).force.any()


def test_more_pixels_or_a_smaller_reach_need_more_nodes():
    """The nodes are those of twice the mesh along both axes, so that no particle sees another one around the rim."""
    mesh = mesh_force(cloud(1, 0), SHAPE, REACH).force.shape
    assert nodes(SHAPE, REACH) == 4 * mesh[0] * mesh[1]
    assert nodes((242, 300), REACH) > 3 * nodes(SHAPE, REACH)
    assert nodes(SHAPE, 0.5 * REACH) > 3 * nodes(SHAPE, REACH)
