"""Loops in what a boundary encloses, and whether they are linked, against the integral of Gauss."""

import numpy as np
import pytest

from cpm_core.numerics.voxel_graph import find_loops

from ..reconstruction.surface.solids import MIDDLE, ball, brick, grid, ring, union, without

ASIDE = np.array([0.0, 7.0, 0.0])


@pytest.mark.parametrize(
    ("solid", "count"),
    [
        pytest.param(ball(8.0), 0, id="ball"),
        pytest.param(without(ball(12.0), ball(6.0)), 0, id="shell"),
        pytest.param(ring(11.0, 3.0), 1, id="torus"),
        pytest.param(ring(12.0, 1.2), 1, id="thin torus"),
        pytest.param(union(ring(7.0, 2.5, 0, MIDDLE - ASIDE), ring(7.0, 2.5, 0, MIDDLE + ASIDE)), 2, id="two"),
        pytest.param(union(ring(12.0, 2.0), brick(1.5, 12, 1.5)), 2, id="a ring with a bar"),
    ],
)
def test_there_is_a_loop_for_each_tunnel(solid, count):
    value = solid(grid())
    found = find_loops(np.argwhere(np.abs(value) < 0.6))
    assert len(found) == count
    for loop in found:
        steps = np.linalg.norm(np.diff(np.concatenate([loop, loop[:1]]), axis=0), axis=1)
        assert steps.max() < 6.0
        assert value[tuple(np.rint(loop).astype(int).T)].min() > -1.5
