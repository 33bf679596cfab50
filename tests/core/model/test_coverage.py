"""Coverage, against a dictionary of visited cells."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.model import coverage as plane
from cpm_core.model.coverage import no_coverage, with_times_reset, with_times_reset_near

from .moving import cloud

SHAPE = (50, 38)
SIDE, ACROSS = 4.0, 9
seeds = st.integers(0, 10**6)


def cell(point):
    return tuple(int((p + 0.5) // SIDE) for p in point)


def visits(shape, seed, least=1):
    """Particles, and which of them are on an edge, in some steps."""
    rng = np.random.default_rng(seed)
    for _ in range(rng.integers(least, 7)):
        points = cloud(shape, int(rng.integers(0, 9)), int(rng.integers(0, 10**6)))
        yield points, rng.uniform(size=len(points)) < 0.6


def idle_truth(first, points, now, far):
    truth = []
    for p in points:
        near = [s for c, s in first.items() if max(abs(a - b) for a, b in zip(c, cell(p), strict=True)) <= ACROSS // 2]
        truth.append(now - max(near) if near else far)
    return truth


@pytest.mark.parametrize(
    ("kernels", "shape"), [pytest.param(plane, SHAPE, id="small"), pytest.param(plane, (300, 150), id="large")]
)
class TestCoverage:
    """What holds for coverage in any dimension."""

    def visited(self, kernels, coverage, first, steps, start=1):
        """Coverage and dictionary after visits in one step after the other; both give the same number of new cells."""
        for step, (points, on_edge) in enumerate(steps, start=start):
            coverage, new = kernels.mark_covered(coverage, points, on_edge, step)
            fresh = {cell(p) for p in points[on_edge]} - set(first)
            assert new == len(fresh)
            first = first | dict.fromkeys(fresh, step)
        return coverage, first

    @settings(max_examples=24, deadline=None)
    @given(seed=seeds)
    def test_first_visits_are_kept_and_counted_once(self, kernels, shape, seed):
        coverage, first = self.visited(kernels, no_coverage(shape), {}, visits(shape, seed))
        found = coverage.found
        assert {tuple(map(int, c)): int(found[tuple(c)]) for c in np.argwhere(found >= 0)} == first
        assert coverage.size == len(first)

    @settings(max_examples=24, deadline=None)
    @given(seed=seeds)
    def test_idle_steps_count_from_the_newest_cells_around(self, kernels, shape, seed):
        coverage, first = self.visited(kernels, no_coverage(shape), {}, visits(shape, seed))
        points = cloud(shape, 8, seed)
        assert kernels.idle_steps_at(coverage, points, 20, 99).tolist() == idle_truth(first, points, 20, 99)

    @settings(max_examples=24, deadline=None)
    @given(seed=seeds)
    def test_renewed_coverage_counts_as_newly_covered_and_grows_further(self, kernels, shape, seed):
        coverage, first = self.visited(kernels, no_coverage(shape), {}, visits(shape, seed))
        coverage, first, points = with_times_reset(coverage, 10), dict.fromkeys(first, 10), cloud(shape, 8, seed)
        assert kernels.idle_steps_at(coverage, points, 10, 99).tolist() == idle_truth(first, points, 10, 99)
        coverage, first = self.visited(kernels, coverage, first, visits(shape, seed + 1), start=11)
        assert kernels.idle_steps_at(coverage, points, 30, 99).tolist() == idle_truth(first, points, 30, 99)

    @settings(max_examples=16, deadline=None)
    @given(seed=seeds, reach=st.floats(0.5, 25.0))
    def test_renewal_near_a_position_changes_the_cells_within_reach_and_no_others(self, kernels, shape, seed, reach):
        """Of all particles there, those whose distance from the place is below the reach; not those a cell beyond."""
        place, points = cloud(shape, 1, seed), cloud(shape, 50, seed + 1)
        idle = kernels.idle_steps_at(with_times_reset_near(no_coverage(shape), place, reach, 7), points, 9, 99)
        distance = np.linalg.norm(points - place, axis=1)
        assert np.all(idle[distance < reach] == 2)
        assert np.all(idle[distance > reach + SIDE * len(shape) ** 0.5] == 99)

    def test_every_place_on_the_image_has_a_cell(self, kernels, shape):
        corners = np.stack(np.meshgrid(*[(-0.5, n - 0.5) for n in shape]), axis=-1).reshape(-1, len(shape))
        _, new = kernels.mark_covered(no_coverage(shape), corners, np.ones(len(corners), bool), 1)
        assert new == 2 ** len(shape)
