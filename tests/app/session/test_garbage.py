"""Garbage is collected on the window's thread only, for Qt falls over when another one destroys what is not its own."""

from __future__ import annotations

import gc
import threading
from typing import ClassVar

import pytest
from cpm_app.views.window.python_hooks import GarbageCollector


class Knot:
    """An object with a reference to itself, which records the thread that destroys it."""

    gone_on: ClassVar[list[str]] = []

    def __init__(self) -> None:
        self.myself = self

    def __del__(self) -> None:
        Knot.gone_on.append(threading.current_thread().name)


def make_garbage(count: int) -> None:
    for _ in range(count):
        Knot()


@pytest.fixture
def automatic():
    """Automatic garbage collection is on, as in a program."""
    Knot.gone_on.clear()
    gc.enable()
    yield
    gc.disable()
    gc.collect()


def test_no_other_thread_collects_while_a_window_is_open(automatic, window) -> None:
    assert not gc.isenabled()
    other = threading.Thread(target=make_garbage, args=(5000,))
    other.start()
    other.join()
    assert not Knot.gone_on
    GarbageCollector.collect_due_generations()
    assert len(Knot.gone_on) == 5000
    assert set(Knot.gone_on) == {threading.main_thread().name}
