"""Loops in what a boundary encloses, and whether they are linked, against the integral of Gauss."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cpm_core.numerics.voxel_graph import linking_number, loops_of

from ..reconstruction.surface.solids import MIDDLE, ball, brick, grid, ring, union, without

ASIDE = np.array([0.0, 7.0, 0.0])


def gauss(one, other):
    """Linking number of two closed polygons: the solid angles of all pairs of sides (Arai 2013)."""
    total = 0.0
    for a, b in zip(one, np.roll(one, -1, axis=0), strict=True):
        for c, d in zip(other, np.roll(other, -1, axis=0), strict=True):
            p = [c - a, d - a, d - b, c - b]
            for x, y, z in ((p[0], p[1], p[2]), (p[2], p[3], p[0])):
                n = [np.linalg.norm(v) for v in (x, y, z)]
                below = n[0] * n[1] * n[2] + (x @ y) * n[2] + (y @ z) * n[0] + (z @ x) * n[1]
                total += 2.0 * np.arctan2(x @ np.cross(y, z), below)
    return total / (4.0 * np.pi)


def along(loop):
    """Places along a closed polygon."""
    sides = zip(loop, np.roll(loop, -1, axis=0), strict=True)
    return np.concatenate([a + np.linspace(0.0, 1.0, 100)[:, None] * (b - a) for a, b in sides])


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.integers(3, 9), st.integers(3, 9))
def test_loops_are_linked_where_their_linking_number_is_not_zero(seed, n, m):
    rng = np.random.default_rng(seed)
    one, other = rng.normal(0.0, 10.0, (n, 3)), rng.normal(0.0, 10.0, (m, 3))
    number = gauss(one, other)
    assume(abs(number - round(number)) < 1e-6)
    fine, near = along(one), along(other)  # those that nearly meet may cross within the offset from the grid
    assume(np.linalg.norm(fine[:, None] - near, axis=-1).min() > 0.3)
    assert abs(linking_number(one, other)) == abs(linking_number(other, one)) == abs(round(number))


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
    found = loops_of(np.argwhere(np.abs(value) < 0.6))
    assert len(found) == count
    for loop in found:
        steps = np.linalg.norm(np.diff(np.concatenate([loop, loop[:1]]), axis=0), axis=1)
        assert steps.max() < 6.0
        assert value[tuple(np.rint(loop).astype(int).T)].min() > -1.5
