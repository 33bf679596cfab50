"""Edge contact, against the rule evaluated on fields that SciPy interpolates."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import map_coordinates

from cpm_core.field.scale_field import GATE
from cpm_core.model.plane import motion as plane
from cpm_core.model.plane.motion import is_on_edge

from .moving import cloud, even_scale_field

FLOOR = 2.0


def uneven_scale_field(shape, seed):
    """Lorentz force of up to unit size, some normal, and an edge strength on both sides of the floor."""
    rng, dimension = np.random.default_rng(seed), len(shape)
    even = even_scale_field(shape, dimension * (0.0,), floor=FLOOR)
    packed = rng.uniform(-1.0, 1.0, (*shape, 2 * dimension + 1)) / np.sqrt(dimension)
    packed[..., -1] = rng.uniform(0.0, 2.0 * FLOOR, shape)
    return replace(even, force=lambda: packed.astype(np.float32))


def between_pixels(values, points):
    return map_coordinates(values.astype(float), points.T, order=1, mode="nearest")


@pytest.mark.parametrize(("kernels", "shape"), [pytest.param(plane, (23, 31), id="plane")])
class TestEdgeContact:
    """What holds for edge contact in any dimension."""

    @settings(max_examples=25, deadline=None)
    @given(seed=st.integers(0, 10**6))
    def test_contact_is_the_rule_on_interpolated_force_and_strength(self, kernels, shape, seed):
        """On the image and half a pixel around it."""
        scale_field, points = uneven_scale_field(shape, seed), cloud(shape, 80, seed)
        strength, on_edge = kernels.contact_at(points, scale_field)
        force = [between_pixels(scale_field.packed[..., axis], points) for axis in range(len(shape))]
        size, there = np.linalg.norm(force, axis=0), between_pixels(scale_field.packed[..., -1], points)
        np.testing.assert_allclose(strength, there, atol=1e-5)
        clear = (np.abs(size - GATE) > 1e-5) & (np.abs(there - FLOOR) > 1e-5)
        np.testing.assert_array_equal(on_edge[clear], ((size < GATE) & (there >= FLOOR))[clear])

    def test_without_particles_there_is_no_contact(self, kernels, shape):
        strength, on_edge = kernels.contact_at(np.zeros((0, len(shape))), uneven_scale_field(shape, 0))
        assert len(strength) == len(on_edge) == 0


@pytest.mark.parametrize(
    ("force", "strength", "there"),
    [(0.0, FLOOR, True), (0.99 * GATE, FLOOR, True), (GATE, FLOOR, False), (0.0, 0.99 * FLOOR, False)],
)
def test_a_particle_is_on_an_edge_below_the_gate_where_the_edge_is_strong_enough(force, strength, there):
    assert is_on_edge(force**2, strength, FLOOR) == there
