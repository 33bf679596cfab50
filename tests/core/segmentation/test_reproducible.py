"""Reproducible: the same run gives the same bits on one core and on all."""

import os

import pytest

from . import reproduced


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="this system binds no process to a core")
def test_one_core_finds_what_all_cores_find_to_the_bit(compiled_loops):
    here = reproduced.vertices()
    assert {
        name: reproduced.apart(found, here[name]) for name, found in reproduced.on_one_core(0).items()
    } == dict.fromkeys(here, 0.0)
    assert all(sum(map(len, found)) > 20 for found in here.values()), "each run finds something"
