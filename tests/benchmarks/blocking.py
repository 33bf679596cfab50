"""Longest time for which the window's thread keeps its event loop waiting, in what `test_never_blocks` does.

Run by ``python -m pytest -s tests/benchmarks/blocking.py``. Measured is what this thread itself computes between
two returns to the loop, not what others take of the computer meanwhile.
"""

import sys
import time

import pytest
from PySide6.QtCore import QTimer

from tests.app import conftest as app
from tests.app.session import test_never_blocks as scenarios

qapp_cls, workspace, session, hand = app.qapp_cls, app.workspace, app.session, app.hand
kept_window = app.kept_window
own_preferences, nobody_is_asked = app.own_preferences, app.nobody_is_asked
window, large = scenarios.window, scenarios.large


@pytest.fixture
def image_file(tmp_path):
    return scenarios.write_discs(tmp_path / "large.npy", scenarios.LARGE)


@pytest.fixture(autouse=True)
def timed(monkeypatch):
    """Take times where the tests count calls."""

    def take(what, do):
        longest, at = 0.0, time.thread_time()

        def beat():
            nonlocal longest, at
            now = time.thread_time()
            longest, at = max(longest, now - at), now

        timer = QTimer()
        timer.timeout.connect(beat)
        timer.start(1)
        do()
        timer.stop()
        beat()
        sys.stdout.write(f"{what}: {1e3 * longest:.0f} ms\n")

    monkeypatch.setattr(scenarios, "free", take)


def test_running(large, hand, qtbot):
    scenarios.test_nothing_blocks_the_window_while_it_runs(large, hand, qtbot)


def test_working(large, hand, qtbot, tmp_path):
    scenarios.test_nothing_blocks_the_window_while_it_is_worked_with(large, hand, qtbot, tmp_path)
