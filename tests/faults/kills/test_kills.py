"""Whatever is killed, every file is the old one or the new one, and the next start goes on from it."""

import gc
import random
import time

import pytest

from . import interruptions, nursery
from .command_line import Batches, Runs
from .nursery import killed_before
from .windows import Windows


@pytest.mark.parametrize(("kind", "trials"), [(Runs, 2), (Batches, 2), (Windows, 1)])
def test_what_is_killed_leaves_whole_files_and_the_next_start_has_them(tmp_path, compiled_loops, kind, trials):
    victim = kind(tmp_path)
    for operation in random.Random(trials).sample(range(victim.operations // 3, victim.operations), trials):
        victim.trial(lambda *arguments, operation=operation: killed_before(operation, *arguments))


def test_a_process_may_be_busy_for_as_long_as_it_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(nursery, "_LONGEST", 0.0)
    with pytest.raises(TimeoutError, match="sleep went on for 0 s longer than it was told to"):
        nursery.outcome(tmp_path, time.sleep, 60.0)
    assert nursery.outcome(tmp_path, time.sleep, 0.01, busy=60.0) == nursery.End(False)


@pytest.fixture
def nobody_counts_garbage():
    """Hypothesis takes the time of each collection, in Python; an interrupt that arrives there is lost."""
    counted = gc.callbacks[:]
    gc.callbacks.clear()
    yield
    gc.callbacks[:] = counted


def test_what_is_interrupted_at_any_moment_goes_on_as_before(tmp_path, compiled_loops, nobody_counts_garbage):
    interruptions.prepare()
    assert interruptions.trial(random.Random(1), tmp_path) == 20
