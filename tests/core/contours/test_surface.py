import numpy as np
import pytest

from cpm_core.image.surface import Surface
from cpm_core.numerics.grids import zero_surface

CORNERS = np.array([[0, 0, 0], [0, 0, 1], [0, 1, 0], [1, 0, 0]], float)
TETRAHEDRON = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])


def drawn_ball(radius, spacing):
    steps = [np.arange(-np.ceil(radius / s) - 2, np.ceil(radius / s) + 3) * s for s in spacing]
    places = np.stack(np.meshgrid(*steps, indexing="ij"), -1)
    return Surface(*zero_surface((radius - np.linalg.norm(places, axis=-1)).astype(np.float32)), spacing, "mm")


@pytest.mark.parametrize("spacing", [(1.0, 1.0, 1.0), (2.0, 0.5, 1.0)])
def test_area_and_volume_are_in_the_unit_of_the_spacing(spacing):
    ball = drawn_ball(12.0, spacing)
    assert ball.volume == pytest.approx(4.0 / 3.0 * np.pi * 12.0**3, rel=0.02)
    assert ball.area == pytest.approx(4.0 * np.pi * 12.0**2, rel=0.02)
    center = ball.vertices.mean(0)
    out = (ball.vertices - center) * spacing
    out /= np.linalg.norm(out, axis=1)[:, None]
    assert (ball.normals * out).sum(1).min() > 0.9


def test_topology_is_told_by_counting():
    closed = Surface(CORNERS, TETRAHEDRON)
    assert (closed.euler, closed.free_edges, closed.nonmanifold_edges, closed.components) == (2, 0, 0, 1)
    assert closed.closed
    opened = Surface(CORNERS, TETRAHEDRON[:3])
    assert (opened.euler, opened.free_edges, opened.closed) == (1, 3, False)
    fin = Surface([*CORNERS, [5, 5, 5]], [*TETRAHEDRON, [0, 1, 4]])
    assert (fin.nonmanifold_edges, fin.free_edges) == (1, 2)
    two = Surface(np.concatenate([CORNERS, CORNERS + 5.0]), np.concatenate([TETRAHEDRON, TETRAHEDRON + 4]))
    assert (two.components, two.euler) == (2, 4)


def test_an_error_on_triangles_says_that_they_are_indices() -> None:
    with pytest.raises(ValueError, match=r"the faces .* must be \(N, 3\), indices of three vertices"):
        Surface(CORNERS, [[0, 1, 2, 3]])
