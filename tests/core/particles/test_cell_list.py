"""Particles sorted into cells, against looking at every one of them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.particles.cell_list import cell_of
from cpm_core.particles.cell_list.plane import build_cells, cells_around, row_of_cells

HEIGHT, WIDTH = 60, 45

inside = st.tuples(st.integers(-4, 59 * 8 + 4), st.integers(-4, 44 * 8 + 4)).map(lambda p: (p[0] / 8.0, p[1] / 8.0))
spread = st.lists(inside, max_size=40)
clustered = st.tuples(inside, st.lists(st.tuples(st.floats(0, 1), st.floats(0, 1)), min_size=1, max_size=12)).map(
    lambda c: [(min(c[0][0] + y, 59.5), min(c[0][1] + x, 44.5)) for y, x in c[1]]
)
clouds = st.one_of(spread, clustered, st.tuples(spread, clustered).map(lambda c: c[0] + c[1])).map(
    lambda points: np.array(points, dtype=float).reshape(-1, 2)
)
sizes = st.sampled_from([0.7, 1.0, 2.0, 5.0, 13.0, 200.0])


def own_cell(point, size):
    """Cells begin at the outer rim of the first pixels."""
    return tuple(int(np.floor((p + 0.5) / size)) for p in point)


def found_near(cells, y, x, radius):
    """Particles in the rows of cells that reach as far as a radius from a place."""
    found = []
    top, bottom, left, right = cells_around(cells, y, x, radius)
    for row in range(top, bottom + 1):
        first, last = row_of_cells(cells, row, left, right)
        found.extend(cells.order[first:last].tolist())
    return found


@settings(max_examples=80, deadline=None)
@given(clouds, sizes)
def test_every_particle_is_sorted_in_once_and_into_its_own_cell(points, size):
    cells = build_cells(points, (HEIGHT, WIDTH), size)
    assert sorted(cells.order.tolist()) == list(range(len(points)))
    np.testing.assert_array_equal(np.stack([cells.y, cells.x], axis=1), points[cells.order])
    assert (cells.start[0], cells.start[-1]) == (0, len(points))
    for cell in range(cells.rows * cells.cols):
        for i in cells.order[cells.start[cell] : cells.start[cell + 1]]:
            assert own_cell(points[i], size) == divmod(cell, cells.cols)


@settings(max_examples=80, deadline=None)
@given(clouds, sizes)
def test_particles_of_one_cell_keep_their_order(points, size):
    cells = build_cells(points, (HEIGHT, WIDTH), size)
    for first, last in zip(cells.start[:-1], cells.start[1:], strict=True):
        assert np.all(np.diff(cells.order[first:last]) > 0)


@settings(max_examples=100, deadline=None)
@given(clouds, sizes, st.tuples(st.floats(-9.0, 70.0), st.floats(-9.0, 55.0)), st.floats(0.0, 30.0))
def test_all_within_a_radius_lie_in_the_rows_found_and_nobody_twice(points, size, place, radius):
    cells = build_cells(points, (HEIGHT, WIDTH), size)
    found = found_near(cells, *place, radius)
    assert len(set(found)) == len(found)
    near = np.flatnonzero(np.hypot(*(points - place).T) <= radius)
    assert set(near.tolist()) <= set(found)
    for i in found:  # and nobody from cells that the radius does not reach
        assert np.abs(points[i] - place).max() < radius + size + 10.0


@settings(max_examples=60, deadline=None)
@given(clouds, st.sampled_from([1.0, 2.0, 6.0]), st.integers(0, 60))
def test_all_nearer_than_the_side_of_a_cell_lie_in_the_cells_around(points, size, which):
    if not len(points):
        return
    place = points[which % len(points)]
    cells = build_cells(points, (HEIGHT, WIDTH), size)
    row, col = cell_of(place[0], size, cells.rows), cell_of(place[1], size, cells.cols)
    for i in np.flatnonzero(np.hypot(*(points - place).T) < size):
        assert abs(cell_of(points[i, 0], size, cells.rows) - row) <= 1
        assert abs(cell_of(points[i, 1], size, cells.cols) - col) <= 1


@pytest.mark.parametrize("size", [0.5, 1.0, 3.7, 60.0, 1e3])
def test_the_rim_of_the_image_has_cells_and_beyond_it_are_the_outermost(size):
    corners = np.array([(-0.5, -0.5), (HEIGHT - 0.5, WIDTH - 0.5)])
    cells = build_cells(corners, (HEIGHT, WIDTH), size)
    assert [own_cell(corner, size) for corner in corners] == [(0, 0), (cells.rows - 1, cells.cols - 1)]
    for along in (cells.rows, cells.cols):
        assert cell_of(-1e6, size, along) == 0
        assert cell_of(1e6, size, along) == along - 1
    np.testing.assert_array_equal(
        row_of_cells(cells, 0, *cells_around(cells, 0.0, 0.0, 1e6)[2:]), [0, cells.start[cells.cols]]
    )


def test_an_empty_image_has_empty_cells():
    cells = build_cells(np.zeros((0, 2)), (HEIGHT, WIDTH), 4.0)
    assert (cells.rows, cells.cols) == (16, 12)
    assert not cells.start.any()
    assert len(cells.order) == len(cells.y) == len(cells.x) == 0
    assert found_near(cells, 20.0, 20.0, 15.0) == []
