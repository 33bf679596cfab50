"""Whole runs, and the import of the core."""

import subprocess
import sys

from cpm_core import PRESETS, circle, segment, uniform_grid
from tests.benchmarks.speed.scenes import HAND, objects, one_object


def test_run_that_starts_everywhere(benchmark, timed):
    values = objects(HAND if timed else (80, 80))
    result = benchmark.pedantic(
        segment, (values, uniform_grid(values.shape), PRESETS["automatic"]), rounds=3 if timed else 1
    )
    assert result.contours


def test_run_that_starts_in_one_object(benchmark, timed):
    values = objects(HAND if timed else (80, 80))
    result = benchmark(segment, values, circle(one_object(values.shape), 12.0))
    assert any(contour.closed for contour in result.contours)


def test_import(benchmark, timed):
    program = [sys.executable, "-c", "import cpm_core"]
    done = benchmark.pedantic(subprocess.run, (program,), {"check": True}, rounds=5 if timed else 1)
    assert done.returncode == 0
