"""Steps of runs that are under way, and contours of one."""

import pytest
from scipy.spatial import Delaunay

from cpm_core import Parameters, reconstruct_curve
from tests.benchmarks.speed.scenes import along_curves
from tests.benchmarks.speed.steps import SIDES, under_way

ONE_SCALE = Parameters(scales=1)


@pytest.mark.parametrize("side", SIDES)
def test_step(benchmark, timed, side):
    engine, state = under_way(side if timed else 100, ONE_SCALE)
    assert benchmark(engine.step, state, ONE_SCALE).step == state.step + 1


def test_contours_of_a_run(benchmark, timed):
    engine, state = under_way(SIDES[0] if timed else 100, ONE_SCALE)
    assert benchmark(engine.result, state, ONE_SCALE).contours


def test_curves_through_points(benchmark, timed):
    assert benchmark(reconstruct_curve, along_curves(5000 if timed else 500))


def test_one_triangulation(benchmark, timed):
    assert len(benchmark(Delaunay, along_curves(5000 if timed else 500)).simplices)
