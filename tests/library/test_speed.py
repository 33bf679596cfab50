"""The benchmark of speed: its measurements are right, and the table and JSON hold the same."""

import numpy as np
import pytest

from cpm_core import coulomb_force
from tests.benchmarks.speed import table
from tests.benchmarks.speed.coulomb import all_pairs, coulomb_error
from tests.benchmarks.speed.measurement import QUICK, Measurement
from tests.benchmarks.speed.scenes import along_curves

FEATURES = ["run", "field", "coulomb", "step", "reconstruction", "start"]

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def measured():
    """All measurements of the quick run."""
    return list(table.measurements(QUICK))


def test_every_part_is_measured_beside_something(measured):
    assert list(dict.fromkeys(row.part for row in measured)) == FEATURES
    for part in FEATURES:
        assert any(row.part == part and row.ratio for row in measured)
    for row in measured:
        assert row.value > 0.0
        assert row.unit in ("s", "ms")
        assert (row.peer is None) == (row.peer_value is None) == (row.ratio is None)
        if row.ratio is not None:
            assert row.ratio == pytest.approx(row.value / row.peer_value)
    assert {row.part for row in measured if row.growth is not None} == {"run", "coulomb"}


def test_measured_results_are_right(measured):
    errors = {row.what: row.error for row in measured if row.error is not None}
    assert len(errors) >= 6
    for what, error in errors.items():
        bound = 1e-3 if "Coulomb" in what else 1e-6 if "single" in what else 1e-12
        assert error <= bound, what


def test_without_a_peer_there_is_no_ratio():
    assert Measurement("run", "a run", 1.0, "s").ratio is None


def test_the_loop_over_all_pairs_is_the_coulomb_force():
    points = along_curves(1200)
    assert coulomb_error(points, all_pairs(points)) < 1e-12
    assert coulomb_error(points, 1.01 * all_pairs(points)) == pytest.approx(0.01, rel=1e-6)
    np.testing.assert_allclose(all_pairs(points), coulomb_force(points, method="exact"), rtol=1e-9, atol=1e-9)
