"""A short run of each fault test of the window; ``python -m tests.faults`` runs them at length."""

from __future__ import annotations

import random
from collections import Counter

import pytest

from tests.faults.report import Budget
from tests.faults.window.closing import run_mosaic, save, try_closing, write_film
from tests.faults.window.memory import Taken, still_rising
from tests.faults.window.monkey import play
from tests.faults.window.orders import sequences, try_orders

pytestmark = pytest.mark.usefixtures("qapp", "compiled_loops")

LONG = 1e9


def test_random_gestures_raise_nothing_and_leave_nothing(tmp_path) -> None:
    report, measured = play(Budget(LONG, 3, tmp_path), gestures=40, between=40)
    assert report.failures == ()
    assert report.inputs > 40
    assert len(measured) == 1


def test_orders_under_delays_end_as_the_last_ones_say(tmp_path) -> None:
    rows = random.Random(7).sample(list(sequences(3)), 20)
    report = try_orders(Budget(LONG, 7, tmp_path), iter(rows))
    assert report.failures == ()
    assert report.inputs == len(rows)
    assert report.faults > 0


def test_closing_ends_everything_that_goes_on(tmp_path) -> None:
    tasks = (run_mosaic, save, write_film)
    report = try_closing(Budget(LONG, 1, tmp_path), tasks, moments=(0.01,), rounds=1)
    assert report.failures == ()
    assert report.inputs == len(tasks)


def test_memory_that_rises_to_the_end_is_told() -> None:
    level = Taken(400.0, 1000, Counter(QWidget=100))
    assert still_rising([level, level, level, level]) == []
    more = Taken(500.0, 1000, Counter(QWidget=200))
    assert len(still_rising([level, level, level, more])) == 2
