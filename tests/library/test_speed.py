"""The benchmark of speed: every part is measured, next to something where there is a peer."""

import re

import pytest

from tests.benchmarks.speed import growth, table
from tests.benchmarks.speed.measurement import QUICK, Measurement

FEATURES = ["run", "field", "step", "reconstruction", "start"]

pytestmark = pytest.mark.long


def test_every_part_is_measured_next_to_something():
    measured = list(table.measurements(QUICK))
    assert list(dict.fromkeys(row.part for row in measured)) == FEATURES
    for part in FEATURES:
        assert any(row.part == part and row.ratio for row in measured)
    for row in measured:
        assert row.value > 0.0
        assert row.unit in ("s", "ms")
        assert (row.peer is None) == (row.peer_value is None) == (row.ratio is None)
        if row.ratio is not None:
            assert row.ratio == pytest.approx(row.value / row.peer_value)


def test_without_a_peer_there_is_no_ratio():
    assert Measurement("run", "a run", 1.0, "s").ratio is None


def test_the_growth_of_what_is_linear_is_one(monkeypatch):
    what = "Coulomb force, particles"
    monkeypatch.setattr(growth, "ROWS", {what: growth.ROWS[what]})
    monkeypatch.setattr(
        growth.subprocess, "check_output", lambda command, text: f"[{command[-1]}, {command[-1]}, 2e6, 1]"
    )
    rows = [re.split(r" *\| *", line)[1:-1] for line in growth.table()][2:]
    assert [row[3] for row in rows] == ["", "1.00", "1.00", "1.00"]
    assert [row[5] for row in rows] == ["", "0.00", "0.00", "0.00"]
    count, seconds, memory, least = growth.measured(what, 2000)
    assert count == 2000
    assert memory > 0
    assert 0.0 < least < seconds
