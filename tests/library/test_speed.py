"""The benchmark of speed: its measurements are right, and the table and JSON hold the same."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

from cpm_core import coulomb_force, electric_field
from cpm_core.image.image import Image
from cpm_core.image.regions import Regions
from cpm_core.segmentation.evolve import segment
from tests.benchmarks.speed import measurement, table
from tests.benchmarks.speed.__main__ import _time as time_in_words
from tests.benchmarks.speed.__main__ import line
from tests.benchmarks.speed.coulomb import all_pairs, coulomb_error
from tests.benchmarks.speed.field import field_error
from tests.benchmarks.speed.measurement import QUICK, Measurement, Patience, seconds_of
from tests.benchmarks.speed.runs import whole_runs
from tests.benchmarks.speed.scenes import along_curves, objects, one_object

KEYS = ["part", "what", "value", "unit", "peer", "peer_value", "error", "growth", "note", "ratio"]
FEATURES = ["run", "field", "coulomb", "step", "reconstruction", "start"]


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


def test_each_measurement_is_one_line(measured):
    for row in measured:
        text = line(row)
        assert text.startswith(row.what)
        assert re.search(r"[\d.]+ (s|ms|µs)\b", text[len(row.what) :])
        assert row.peer is None or row.peer in text
        assert all(name in text for name in ("error", "growth") if getattr(row, name) is not None)


def test_an_image_of_the_users_own_takes_the_place_of_the_scene():
    values = objects((80, 90))
    rows = list(whole_runs(QUICK, Image(values, source="mine.png")))
    assert len(rows) == 3
    assert all(row.what == "mine.png 80 x 90, start everywhere" and row.ratio for row in rows)


@pytest.fixture
def clock(monkeypatch):
    """A clock that only work advances: a list of one time [s]."""
    now = [0.0]
    monkeypatch.setattr(measurement, "time", SimpleNamespace(perf_counter=lambda: now[0]))
    return now


def taking(clock, times):
    """Task that takes these times, one after the other."""
    left = iter(times)

    def work():
        clock[0] += next(left)

    return work, left


def test_a_time_is_the_median_of_some_and_the_first_is_left_out(clock):
    work, left = taking(clock, [2.0, 0.3, 0.1, 0.2, 0.5])
    assert seconds_of(Patience(seconds=10.0, repeats=3), work) == pytest.approx([0.2])
    assert next(left) == 0.5


def test_nothing_is_repeated_after_the_time_limit(clock):
    work, left = taking(clock, [0.4, 0.3, 0.4, 0.5])
    assert seconds_of(Patience(seconds=1.0, repeats=9), work) == pytest.approx([0.35])
    assert next(left) == 0.5


def test_a_long_task_is_done_once(clock):
    work, left = taking(clock, [3.1, 0.5])
    assert seconds_of(Patience(seconds=1.0), work) == pytest.approx([3.1])
    assert next(left) == 0.5


def test_ours_and_its_peers_are_done_in_turn(clock):
    done = []

    def work(name, seconds):
        done.append(name)
        clock[0] += seconds

    times = seconds_of(Patience(seconds=1.0, repeats=2), lambda: work("ours", 0.2), lambda: work("peer", 0.3))
    assert times == pytest.approx([0.2, 0.3])
    assert done == ["ours", "peer"] * 3


@pytest.mark.parametrize(
    ("value", "unit", "shown"),
    [
        (0.000012345, "s", "12.3 µs"),
        (0.25, "ms", "0.25 ms"),
        (12.345, "ms", "12.3 ms"),
        (7764.0, "ms", "7.76 s"),
        (16.06, "s", "16.1 s"),
        (0.2, "s", "200 ms"),
    ],
)
def test_a_time_is_shown_in_a_unit_of_its_size(value, unit, shown):
    assert time_in_words(value, unit) == shown


def test_without_a_peer_there_is_no_ratio():
    assert Measurement("run", "a run", 1.0, "s").ratio is None


def test_the_loop_over_all_pairs_is_the_coulomb_force():
    points = along_curves(1200)
    assert coulomb_error(points, all_pairs(points)) < 1e-12
    assert coulomb_error(points, 1.01 * all_pairs(points)) == pytest.approx(0.01, rel=1e-6)
    np.testing.assert_allclose(all_pairs(points), coulomb_force(points, method="exact"), rtol=1e-9, atol=1e-9)


def test_the_error_of_a_field_is_relative():
    f = np.random.default_rng(0).uniform(size=(30, 26))
    field = electric_field(f)
    assert field_error(f, field) < 1e-12
    assert field_error(f, 1.01 * field) == pytest.approx(0.01, rel=0.1)


@pytest.mark.parametrize("count", [300, 5000])
def test_particles_along_curves_keep_their_distance(count):
    points = along_curves(count)
    assert abs(len(points) - count) < 100
    apart = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1)
    assert np.median(apart) == pytest.approx(1.5, abs=0.1)


def test_the_scene_has_objects_and_a_circle_in_one_of_them_finds_it():
    values = objects((160, 220))
    row, col = center = one_object(values.shape)
    near = (slice(int(row) - 5, int(row) + 6), slice(int(col) - 5, int(col) + 6))
    assert values[near].min() > values.mean()
    around = Regions(interest=[[(row + r, col + c) for r, c in ((-34, -34), (-34, 34), (34, 34), (34, -34))]])
    angle = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    seeds = np.array(center) + 8.0 * np.stack([np.sin(angle), np.cos(angle)], axis=1)
    (contour,) = segment(values, seeds, regions=around).contours
    assert contour.closed
    assert np.all(np.ptp(contour.points, axis=0) > 26.0)
