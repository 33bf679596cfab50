"""A short run of each fault test of the window; ``python -m tests.faults`` runs them at length."""

from __future__ import annotations

import random
import sys
import threading
from collections import Counter
from dataclasses import replace

import pytest

from tests.faults.clock import Clock, waits
from tests.faults.fuzzing.inputs.session_samples import IMAGE
from tests.faults.report import Budget
from tests.faults.window.closing import run_mosaic, save, try_closing, write_film
from tests.faults.window.memory import Taken, quarters, still_rising
from tests.faults.window.monkey import play
from tests.faults.window.opening import try_opening
from tests.faults.window.orders import sequences, try_orders

pytestmark = pytest.mark.usefixtures("qapp", "compiled_loops")

LONG = 1e9


def test_random_gestures_raise_nothing_and_leave_nothing(tmp_path) -> None:
    report, measured = play(Budget(LONG, 3, tmp_path), gestures=40, between=40, checks=1)
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


def test_damaged_sessions_are_shown_or_refused_in_one_sentence(tmp_path) -> None:
    report = try_opening(Budget(LONG, 4, tmp_path), most=8, of=(IMAGE,))
    assert report.failures == ()
    assert report.inputs == 8


def test_time_without_a_processor_does_not_count() -> None:
    told = iter([(0.0, {"1": 5.0}), (10.0, {"1": 5.0, "2": 9.0}), (12.0, {"1": 5.5, "2": 9.0}), (13.0, {})])
    ticks = []

    def time_now() -> float:
        ticks.append(next(told))
        return ticks[-1][0]

    clock = Clock(time_now, lambda: ticks[-1][1])
    assert [clock(), clock(), clock()] == [1.0, 2.5, 3.5]


def test_threads_that_wait_for_a_processor_are_told() -> None:
    assert all(seconds >= 0.0 for seconds in waits().values())
    assert (str(threading.get_native_id()) in waits()) == sys.platform.startswith("linux")


def test_memory_that_rises_to_the_end_is_told() -> None:
    def rising(resident: float, qt: float) -> list[Taken]:
        return [Taken(400.0 + resident * n, Counter(QWidget=round(1000 + qt * n))) for n in range(40)]

    assert still_rising(quarters(rising(0.0, 0.0))) == []
    assert len(still_rising(quarters(rising(1.0, 0.0)))) == 1
    assert len(still_rising(quarters(rising(1.0, 5.0)))) == 2


def test_memory_that_rises_only_at_the_beginning_or_for_a_moment_is_no_leak() -> None:
    marks = [Taken(400.0 + 10.0 * min(n, 10), Counter(QWidget=100)) for n in range(40)]
    marks[-1] = replace(marks[-1], resident=900.0)
    assert still_rising(quarters(marks)) == []
