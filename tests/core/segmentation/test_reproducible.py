"""Reproducible: the same run gives the same bits on all cores, and the same contours on registers of any width."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from cpm_core.particles.coulomb.pair_force.plane import pair_sum

from . import reproduced

MODULES = reproduced.ROOT / "cpm_core"
SUM = (
    "import json, sys; from tests.core.segmentation.test_reproducible import sum_of_pairs; "
    "sys.stdout.write(json.dumps(sum_of_pairs()))"
)


@pytest.fixture(scope="module")
def here(compiled_loops):
    return reproduced.vertices()


def sum_of_pairs():
    """The force of many particles on one, as two numbers in hexadecimal."""
    near = np.random.default_rng(3).random((2, 96), np.float32) * np.float32(30.0)
    room, softening = np.empty((3, 96), np.float32), np.array([35 / 8e3, -21 / 4e5, 15 / 8e7], np.float32)
    place, reach = np.float32(15.0), np.float32(10.0)
    force = pair_sum(near[0], near[1], room[0], 96, place, place, reach, softening, room[1], room[2])
    return [number.hex() for number in force]


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="this system binds no process to a core")
def test_one_core_finds_what_all_cores_find_to_the_bit(here):
    assert {
        name: reproduced.apart(found, here[name]) for name, found in reproduced.on_one_core(0).items()
    } == dict.fromkeys(here, 0.0)
    assert all(sum(map(len, found)) > 20 for found in here.values()), "each run finds something"


@pytest.mark.skipif(not reproduced.HAS_WIDE, reason="this processor has vector registers of one width")
def test_libraries_for_narrow_registers_give_the_same_contours(here):
    found = reproduced.on_narrow_registers(0, reproduced.NARROW_LIBRARIES)
    assert max(reproduced.apart(found[name], here[name]) for name in here) <= reproduced.LAW


@pytest.mark.skipif(not reproduced.HAS_WIDE, reason="this processor has vector registers of one width")
def test_a_sum_over_pairs_has_the_same_bits_on_narrow_registers(tmp_path):
    settings = reproduced.NARROW | {"NUMBA_CACHE_DIR": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", SUM], cwd=reproduced.ROOT, env=os.environ | settings, capture_output=True, check=True
    )
    assert json.loads(done.stdout) == sum_of_pairs()


def test_only_what_no_contour_depends_on_may_reorder_its_sums():
    reordering = {
        path.relative_to(MODULES).as_posix()
        for path in MODULES.rglob("*.py")
        if "import reordered" in path.read_text(encoding="utf-8")
    }
    allowed = {f"particles/coulomb/{name}.py" for name in ("direct_sum", "expansions", "fast_multipole", "space")}
    assert reordering == allowed
    forces = "coulomb_force import coulomb_force"
    using = {path for path in MODULES.rglob("*.py") if forces in path.read_text(encoding="utf-8")}
    assert {Path(path).relative_to(MODULES).parts[:2] for path in using} == {("__init__.py",)}
