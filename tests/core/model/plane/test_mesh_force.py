"""The Coulomb force by way of a mesh, against eq. (9) pair by pair."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.model.plane.repulsion import mesh_force, mesh_force_at, spline_weights

from ..moving import coulomb, offsets

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


@pytest.mark.parametrize(
    "points",
    [*map(on_circle, (8.0, 25.0, 58.0)), *map(on_line, (0.0, 0.3, np.pi / 4, 1.3, np.pi / 2))],
    ids=["small", "middle", "large", "level", "slanting", "diagonal", "steep", "upright"],
)
def test_force_on_curves_is_the_sum_over_all_pairs(points):
    assert error(points) < CURVES


@settings(max_examples=24, deadline=None)
@given(st.floats(1.0, 1e3))
def test_spline_spreads_a_whole_charge_about_its_own_place(place):
    node, *weights = spline_weights(place)
    nodes_at = np.arange(node, node + 3)
    assert sum(weights) == pytest.approx(1.0, abs=1e-12)
    assert np.dot(weights, nodes_at) == pytest.approx(place, abs=1e-9)
    # the second moment of a quadratic spline is a quarter, wherever it stands
    assert np.dot(weights, (nodes_at - place) ** 2) == pytest.approx(0.25, abs=1e-9)
    assert min(weights) >= 0.0


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
