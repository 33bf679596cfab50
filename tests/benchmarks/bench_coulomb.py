"""The Coulomb force, by each method and beside a loop over all pairs."""

import pytest

from cpm_core import coulomb_force
from tests.benchmarks.speed.coulomb import all_pairs, coulomb_error
from tests.benchmarks.speed.scenes import along_curves


@pytest.mark.parametrize("count", [1_000, 4_000, 16_000, 64_000])
def test_auto(benchmark, timed, count):
    points = along_curves(count if timed else 500)
    assert coulomb_error(points, benchmark(coulomb_force, points)) < 1e-3


@pytest.mark.parametrize("count", [1_000, 4_000, 16_000])
def test_exact(benchmark, timed, count):
    points = along_curves(count if timed else 500)
    assert coulomb_error(points, benchmark(coulomb_force, points, method="exact")) < 1e-9


@pytest.mark.parametrize("count", [1_000, 4_000, 16_000])
def test_loop_over_all_pairs(benchmark, timed, count):
    points = along_curves(count if timed else 500)
    assert coulomb_error(points, benchmark(all_pairs, points)) < 1e-9
