"""Work shared among cores: every item once, whatever the parts."""

import threading
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cpm_core.numerics import parallel
from cpm_core.numerics.parallel import run_in_parallel


@given(st.integers(0, 1000), st.integers(1, 300))
def test_every_item_is_in_exactly_one_part(count, least):
    parts = []
    run_in_parallel(lambda first, last: parts.append((first, last)), count, least)
    parts.sort()
    assert parts[0][0] == 0
    assert parts[-1][1] == count
    assert all(before[1] == after[0] for before, after in pairwise(parts))


def test_no_caller_waits_for_the_work_of_another(monkeypatch):
    monkeypatch.setattr(parallel, "count_cores", lambda: 2)
    begun, done = threading.Event(), threading.Event()

    def long(first, last):
        if first:
            begun.set()
            assert done.wait(20)

    callers = [threading.Thread(target=run_in_parallel, args=(long, 80, 1)) for _ in range(2)]
    for caller in callers:
        caller.start()
    assert begun.wait(20)
    items = []
    run_in_parallel(lambda first, last: items.extend(range(first, last)), 100, 1)
    done.set()
    for caller in callers:
        caller.join()
    assert sorted(items) == list(range(100))


def test_an_error_in_a_part_reaches_the_caller():
    def failing(first, last):
        raise ValueError(f"item {first}")

    with pytest.raises(ValueError, match="item"):
        run_in_parallel(failing, 100, 1)
