"""Near pairs of a run, against sums over all pairs of particles in double precision."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cpm_core.model.coverage import cell_of
from cpm_core.model.plane import repulsion as plane
from cpm_core.model.plane import repulsion as plane_cells
from cpm_core.model.plane.repulsion import FILLER, LANES, softening, two_nearest

from ..dynamics.moving import cloud, coulomb, crowds, offsets

SINGLE = 3e-5
"""Error of single precision, relative to the sizes of the terms."""


def left_out(points, reach, coefficients):
    """Force on each particle of what the mesh leaves out of eq. (9), and the sum of the sizes of its terms."""
    apart, distance = offsets(points)
    near = np.where(distance < reach, distance, 1.0)
    smooth = coefficients[0] + coefficients[1] * near**2 + coefficients[2] * near**4
    weight = np.where(distance < reach, near**-3.0 - smooth, 0.0)
    return (weight[..., None] * apart).sum(axis=1), (weight * near).sum(axis=1)


@pytest.mark.parametrize(("kernels", "lists", "shape"), [pytest.param(plane, plane_cells, (60, 45), id="plane")])
class TestPairForce:
    """What holds for near pairs in any dimension."""

    def each(self, kernels, lists, points, shape, size, reach, coefficients):
        """Index, pair force and two least squared distances of each particle, by the list of its cell."""
        cells = lists.build_cells(points, shape, size)
        grid = [int(n / size) + 1 for n in shape]
        near = [np.empty(len(points) + LANES, np.float32) for _ in shape]
        squared = np.empty(len(points) + LANES, np.float32)
        for k, i in enumerate(cells.order.tolist()):
            cell = [cell_of(x, size, along) for x, along in zip(points[i], grid, strict=True)]
            length, own = kernels.gather(cells, *cell, *near)
            assert length % LANES == 0
            here = [along[own + k] for along in near]
            force = kernels.pair_sum(*near, squared, length, *here, np.float32(reach), coefficients)
            yield i, force, two_nearest(squared, squared.view(np.int32), length)

    @settings(max_examples=25, deadline=None)
    @given(seed=st.integers(0, 10**6), reach=st.sampled_from([3.0, 10.0, 30.0]))
    def test_force_is_what_the_mesh_leaves_out_of_the_sum_over_all_pairs(self, kernels, lists, shape, seed, reach):
        points = crowds(shape, seed)
        coefficients = softening(reach)
        truth, sizes = left_out(points, reach, coefficients.astype(float))
        for i, force, _ in self.each(kernels, lists, points, shape, reach, reach, coefficients):
            assert np.linalg.norm(np.array(force) - truth[i]) <= SINGLE * (sizes[i] + reach**-2.0 * len(points))

    def test_without_softening_and_bound_it_is_the_sum_over_all_pairs(self, kernels, lists, shape):
        points = cloud(shape, 60, 1)
        truth, none = coulomb(points), np.zeros(3, np.float32)
        for i, force, _ in self.each(kernels, lists, points, shape, float(max(shape) + 1), np.inf, none):
            np.testing.assert_allclose(force, truth[i], rtol=0, atol=1e-4)

    @settings(max_examples=25, deadline=None)
    @given(seed=st.integers(0, 10**6), size=st.sampled_from([4.0, 9.0, 70.0]))
    @example(seed=7076, size=4.0)
    def test_the_two_nearest_are_those_of_all_particles(self, kernels, lists, shape, seed, size):
        """Of those in the cells around; `two_nearest_of_many` finds them among all, up to a distance.

        The filler of the list counts where there are no two others.
        """
        points = crowds(shape, seed)
        distance = np.sort(np.concatenate([offsets(points)[1], np.full((len(points), 2), np.inf)], axis=1), axis=1)
        cells = lists.build_cells(points, shape, size)
        for i, _, squared in self.each(kernels, lists, points, shape, size, size, softening(size)):
            for found, true in zip(np.sqrt(np.array(squared)), distance[i, :2], strict=True):
                beyond = true > size and found > min(0.999 * true, FILLER)
                assert found == pytest.approx(true, rel=1e-5) or beyond
            many = kernels.two_nearest_of_many(cells, *points[i], 1e3)
            np.testing.assert_allclose(np.sqrt(many), distance[i, :2], rtol=1e-12)

    @settings(max_examples=25, deadline=None)
    @given(seed=st.integers(0, 10**6), reach=st.sampled_from([2.0, 5.0, 40.0]))
    def test_energy_is_the_sum_over_all_near_pairs(self, kernels, lists, shape, seed, reach):
        points = crowds(shape, seed)
        distance = np.linalg.norm(points[:, None] - points, axis=2)[np.triu_indices(len(points), 1)]
        truth = (1.0 / np.maximum(distance, 0.1) - 1.0 / reach)[distance < reach].sum()
        assert kernels.pair_energy(lists.build_cells(points, shape, reach), reach) == pytest.approx(truth, abs=1e-9)
