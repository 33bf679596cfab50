"""Reproducible: the same run gives the same bits, however many cores the process may use."""

import os

import pytest

from . import reproduced


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="this system binds no process to a core")
def test_one_core_finds_what_all_cores_find_to_the_bit(compiled_loops):
    here = reproduced.hashes()
    assert reproduced.on_one_core(0) == here
    assert all(int(told.split()[1]) > 20 for told in here.values()), "each run finds something"
