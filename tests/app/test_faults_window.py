"""A short run of each fault test of the window; ``python -m tests.faults`` runs them at length."""

from __future__ import annotations

import random
from collections import Counter
from dataclasses import replace

import pytest

from tests.faults.report import Budget
from tests.faults.window.closing import run_mosaic, save, try_closing, write_film
from tests.faults.window.memory import Taken, quarters, still_rising
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
    def rising(resident: float, qt: float) -> list[Taken]:
        return [Taken(400.0 + resident * n, 1000, Counter(QWidget=round(1000 + qt * n))) for n in range(40)]

    assert still_rising(quarters(rising(0.0, 0.0))) == []
    assert len(still_rising(quarters(rising(1.0, 0.0)))) == 1
    assert len(still_rising(quarters(rising(1.0, 5.0)))) == 2


def test_memory_that_rises_only_at_the_beginning_or_for_a_moment_is_no_leak() -> None:
    marks = [Taken(400.0 + 10.0 * min(n, 10), 1000, Counter(QWidget=100)) for n in range(40)]
    marks[-1] = replace(marks[-1], resident=900.0)
    assert still_rising(quarters(marks)) == []
