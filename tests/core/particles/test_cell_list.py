"""Particles sorted into cells, against looking at every one of them."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.model.coverage import cell_of
from cpm_core.model.plane import repulsion as plane
from cpm_core.model.volume import motion as space

from ..dynamics.moving import crowds

seeds, sizes = st.integers(0, 10**6), st.sampled_from([0.7, 1.0, 2.0, 5.0, 13.0, 200.0])


def own_cell(point, size):
    """Cells begin at the outer rim of the first pixels."""
    return tuple(int(np.floor((p + 0.5) / size)) for p in point)


def grid(shape, size):
    return tuple(int(n / size) + 1 for n in shape)


def in_cell(cells, *cell):
    """Where the sorted particles of a cell begin and end."""
    if len(cell) == 2:
        return plane.row_of_cells(cells, *cell, cell[-1])
    first, last = cells.start[cell[0] * cells.rows + cell[1] :][:2]
    return first + np.searchsorted(cells.col[first:last], [cell[2], cell[2] + 1])


@pytest.mark.parametrize(
    ("kernels", "shape"), [pytest.param(plane, (60, 45), id="plane"), pytest.param(space, (20, 24, 15), id="space")]
)
class TestCellList:
    """What holds for cells in any dimension; rows of cells run along the last axis."""

    def found_near(self, kernels, cells, place, radius):
        """Particles in the rows of cells that reach as far as a radius from a place."""
        if kernels is space:
            return cells.order[space.near(cells, tuple(place), radius)].tolist()
        *before, last = np.reshape(kernels.cells_around(cells, *place, radius), (len(place), 2)).tolist()
        found = []
        for row in product(*(range(first, end + 1) for first, end in before)):
            start, end = kernels.row_of_cells(cells, *row, *last)
            found.extend(cells.order[start:end].tolist())
        return found

    @settings(max_examples=60, deadline=None)
    @given(seed=seeds, size=sizes)
    def test_every_particle_is_sorted_in_once_and_into_its_own_cell(self, kernels, shape, seed, size):
        points = crowds(shape, seed)
        cells = kernels.build_cells(points, shape, size)
        assert sorted(cells.order.tolist()) == list(range(len(points)))
        np.testing.assert_array_equal(np.stack([cells.y, cells.x], axis=1), points[cells.order][:, -2:])
        end = 0
        for *row, col in np.ndindex(grid(shape, size)):
            before, cell = end, (*row, col)
            start, end = in_cell(cells, *cell)
            assert start == before
            mine = cells.order[start:end].tolist()
            assert all(own_cell(points[i], size) == cell for i in mine)
            assert mine == sorted(set(mine))  # in their order
        assert end == len(points)

    @settings(max_examples=60, deadline=None)
    @given(seed=seeds, size=sizes, radius=st.floats(0.0, 30.0))
    def test_all_within_a_radius_lie_in_the_rows_found_and_none_twice(self, kernels, shape, seed, size, radius):
        points = crowds(shape, seed)
        place = np.random.default_rng(seed).uniform(-9.0, np.array(shape) + 9.0)
        found = self.found_near(kernels, kernels.build_cells(points, shape, size), place, radius)
        assert len(set(found)) == len(found)
        near = np.flatnonzero(np.linalg.norm(points - place, axis=1) <= radius)
        assert set(near.tolist()) <= set(found)
        for i in found:  # and none from cells that the radius does not reach
            assert np.abs(points[i] - place).max() < radius + size + 10.0

    @settings(max_examples=40, deadline=None)
    @given(seed=seeds, size=st.sampled_from([1.0, 2.0, 6.0]))
    def test_all_nearer_than_the_side_of_a_cell_lie_in_the_cells_around(self, kernels, shape, seed, size):
        points = crowds(shape, seed)
        cells = kernels.build_cells(points, shape, size)
        cell = np.empty(points.shape, np.int64)
        for one in np.ndindex(grid(shape, size)):
            start, end = in_cell(cells, *one)
            cell[cells.order[start:end]] = one
        near = np.linalg.norm(points[:, None] - points, axis=2) < size
        assert np.abs(cell[:, None] - cell).max(axis=2)[near].max(initial=0) <= 1

    def test_an_empty_image_has_empty_cells(self, kernels, shape):
        cells = kernels.build_cells(np.zeros((0, len(shape))), shape, 4.0)
        assert not cells.start.any()
        assert len(cells.order) == 0
        assert self.found_near(kernels, cells, np.array(shape) / 2, 15.0) == []


@pytest.mark.parametrize("size", [0.5, 1.0, 3.7, 60.0, 1e3])
def test_the_rim_of_the_image_has_cells_and_beyond_it_are_the_outermost(size):
    (most,) = grid((60,), size)
    assert [cell_of(place, size, most) for place in (-1e6, -0.5, 59.5, 1e6)] == [0, 0, most - 1, most - 1]
