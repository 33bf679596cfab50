"""Averages along edges are quiet, and leave edges where they are."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.image.denoising import average_along_edges, edge_directions

ROW, COL = np.indices((80, 84)).astype(float)
INSIDE = slice(24, -24)


def straight(angle, width=3.0):
    """A soft step along a line through the middle."""
    across = (ROW - 40.0) * np.cos(angle) + (COL - 42.0) * np.sin(angle)
    return 100.0 * np.tanh(across / width)


@settings(max_examples=10, deadline=None)
@given(st.floats(-1.5, 1.5))
def test_directions_run_along_a_straight_edge_and_are_sure_of_it(angle):
    way = edge_directions(straight(angle), 1.0, 3.0)
    beside = np.zeros(ROW.shape, np.bool_)
    beside[INSIDE, INSIDE] = np.abs(straight(angle))[INSIDE, INSIDE] < 60.0
    off = way.row * np.cos(angle) + way.col * np.sin(angle)
    assert np.abs(off[beside]).max() < 0.03
    assert way.coherence[beside].min() > 0.98
    np.testing.assert_allclose(way.row**2 + way.col**2, 1.0, atol=1e-12)


@settings(max_examples=15, deadline=None)
@given(st.floats(-1.5, 1.5))
def test_average_along_a_straight_edge_is_the_edge(angle):
    image = straight(angle)
    found = average_along_edges(image, edge_directions(image, 1.0, 3.0), 6.0)
    np.testing.assert_allclose(found[INSIDE, INSIDE], image[INSIDE, INSIDE], atol=3.0)


def test_average_along_a_circle_is_the_circle():
    distance = np.hypot(ROW - 40.0, COL - 42.0)
    image = 100.0 * np.tanh((distance - 20.0) / 3.0)
    found = average_along_edges(image, edge_directions(image, 1.0, 2.0), 8.0)
    near = np.abs(distance - 20.0) < 4.0
    assert np.abs(found - image)[near].max() < 6.0


@pytest.mark.parametrize("length", [3.0, 8.0])
def test_white_noise_falls_as_the_length_of_a_gaussian_says(length):
    """The weights' norm: 1 / sqrt(2 sqrt(pi) L)."""
    noise = np.random.default_rng(1).normal(size=(200, 200))
    way = edge_directions(np.indices(noise.shape)[0].astype(float), 1.0, 3.0)
    found = average_along_edges(noise, way, length)[:, 30:-30]
    assert found.std() == pytest.approx(1.0 / np.sqrt(2.0 * np.sqrt(np.pi) * length), rel=0.1)
