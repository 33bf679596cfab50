"""The benchmarks can be run, and the ordinary tests do not run them."""

import os
import subprocess
import sys
from fnmatch import fnmatch
from pathlib import Path

ROOT = Path(__file__).parent.parent
FILES = sorted(path.relative_to(ROOT).as_posix() for path in (ROOT / "tests" / "benchmarks").glob("bench_*.py"))
RUN_BEFORE = "tests/benchmarks/bench_blocking.py::test_running"
"""Takes ten seconds, and does nothing that a test does not do as well."""


def pytest_run(*arguments):
    alone = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_XDIST")}
    environment = {**alone, "PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
    return subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *arguments],
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
    )


def test_each_benchmark_can_be_run(request):
    assert len(FILES) >= 4
    warnings = [f"-W{given}" for given in request.config.getoption("pythonwarnings") or ()]  # as here
    done = pytest_run("--benchmark-disable", *warnings, "--deselect", RUN_BEFORE, *FILES)
    assert done.returncode == 0, done.stdout + done.stderr
    assert " passed" in done.stdout


def test_no_benchmark_is_collected_by_itself(request):
    collected = request.config.getini("python_files")
    assert collected
    for path in (ROOT / "tests" / "benchmarks").rglob("*.py"):
        assert not any(fnmatch(path.name, pattern) for pattern in collected), path
