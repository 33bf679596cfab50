"""The field of gradient vector flow: its equation, by another way of solving it, and what is published of it."""

import numpy as np
import scipy
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.field.edge_map import edge_map, smoothed_gradient
from cpm_core.methods.snakes import even_out_field, gradient_vector_flow


def directly(edges, mu):
    """The field by a sparse matrix that is built from pairs of neighbors, and solved by elimination."""
    number = np.arange(edges.size).reshape(edges.shape)
    slope = smoothed_gradient(edges, 0.0)
    weight = (slope**2).sum(axis=0).ravel()
    pairs = np.concatenate(
        [
            np.stack([number[:-1].ravel(), number[1:].ravel()]),
            np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()]),
        ],
        axis=1,
    )
    graph = scipy.sparse.coo_array((np.ones(pairs.shape[1]), pairs), shape=(edges.size, edges.size))
    laplacian = scipy.sparse.csgraph.laplacian((graph + graph.T).tocsr())
    matrix = (scipy.sparse.diags_array(weight) + mu * laplacian).tocsc()
    solve = scipy.sparse.linalg.factorized(matrix)
    return np.stack([solve(weight * part.ravel()).reshape(edges.shape) for part in slope])


@given(
    rows=st.integers(8, 33),
    cols=st.integers(8, 33),
    mu=st.sampled_from([0.01, 0.2, 5.0]),
    seed=st.integers(0, 2**16),
)
@settings(max_examples=8, deadline=None)
def test_the_field_solves_its_equation(rows, cols, mu, seed):
    edges = np.random.default_rng(seed).random((rows, cols))
    expected = directly(edges, mu)
    assert np.allclose(gradient_vector_flow(edges, mu), expected, rtol=0.0, atol=1e-6 * np.abs(expected).max())


def test_an_image_without_edges_has_no_field():
    assert not gradient_vector_flow(np.zeros((9, 12)), 0.2).any()
    assert not even_out_field(np.zeros((2, 9, 12))).any()


def test_the_field_points_into_a_u_down_to_its_end():
    values = np.zeros((80, 80))
    values[10:70, 15:65] = 1.0
    values[10:50, 32:48] = 0.0  # the cavity: 16 px wide, 40 px deep, open at the top
    edges = edge_map(values, 1.0)
    field = gradient_vector_flow(edges / edges.max(), 0.2)
    axis = field[0, 12:48, 39:41].mean(axis=1)
    assert (axis > 0.0).all()  # down the cavity, from its mouth to its end


def test_evened_vectors_keep_their_directions():
    field = np.random.default_rng(0).normal(0.0, 1.0, (2, 12, 12))
    assert np.allclose(np.hypot(*even_out_field(field)), 1.0)
    assert np.allclose(even_out_field(field) * np.hypot(*field), field)
    assert np.allclose(even_out_field(field, 0.0) * np.hypot(*field).max(), field)
