"""Warming up compiles and has no other effect."""

import os
import shutil
import signal
import subprocess
import sys
import threading

import numba
import numpy as np
import pytest

from cpm_core import Engine, Parameters, circle
from cpm_core.numerics.loop_cache import elsewhere
from cpm_core.numerics.loop_cache.kept_loop import KeptLoop
from cpm_core.objects.warm_up import aside, parts, warm_up
from cpm_core.objects.warm_up.parts import FIRST, Part

from ..scenes import disk


def test_warming_up_twice_has_no_side_effects(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    environment = dict(os.environ)
    random_before = np.random.get_state()[1].tolist()  # noqa: NPY002 - the global generator must be untouched
    assert warm_up() is None
    threads = threading.active_count()
    assert warm_up() is None
    assert threading.active_count() == threads
    assert list(tmp_path.iterdir()) == []
    assert dict(os.environ) == environment
    assert np.random.get_state()[1].tolist() == random_before  # noqa: NPY002


def test_warming_up_beside_a_run_does_not_change_it():
    engine = Engine(disk((48, 48), (23.3, 24.1), 14.0).values, Parameters())

    def forty_steps():
        state = engine.start(circle((23.0, 24.0), 7.0))
        for _ in range(40):
            state = engine.step(state, Parameters())
        return state.position.tobytes()

    alone = forty_steps()
    beside = threading.Thread(target=warm_up)
    beside.start()
    together = forty_steps()
    beside.join()
    assert together == alone


@pytest.fixture
def new_folder(tmp_path, monkeypatch):
    """An empty folder for loops, and two cores."""
    monkeypatch.setattr(aside, "kept_folder", lambda: tmp_path)
    monkeypatch.setattr(parts, "has_loops", lambda module: any(tmp_path.rglob(f"{module}*")))
    monkeypatch.setattr(aside, "cores", lambda: 2)
    return tmp_path


def part(name, loops=1):
    return Part(lambda: None, (name,), loops)


def started_instead(monkeypatch, code):
    """Let other processes run this code; returns those that have been started."""
    processes = []

    def start(part, gently=False):
        processes.append(subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE))
        return processes[-1]

    monkeypatch.setattr(aside, "other_process", start)
    return processes


def test_only_parts_that_are_not_kept_are_compiled_and_progress_is_told(new_folder, monkeypatch):
    code = (
        "import pathlib\n"
        f"made = pathlib.Path({str(new_folder)!r}) / 'new-1'\n"
        "made.mkdir()\n"
        "(made / 'a.nbc').touch()\n"
        "input()"
    )
    (new_folder / "kept-1").mkdir()
    processes, told = started_instead(monkeypatch, code), []

    def follow(fraction):
        told.append(fraction)
        if fraction == 0.5 and processes[0].poll() is None:
            processes[0].communicate()

    warm_up(told=follow, parts=[part("kept"), part("new", loops=2)])
    warm_up(told=follow, parts=[part("kept"), part("new", loops=2)])
    assert len(processes) == 1
    assert sorted(set(told)) in ([0.0, 0.5], [0.5])


def test_no_more_processes_than_cores_compile_at_once(new_folder, monkeypatch):
    processes = started_instead(monkeypatch, "input()")
    at_once = []

    def follow(_):
        running = [process for process in processes if process.poll() is None]
        at_once.append(len(running))
        running[0].communicate()

    warm_up(told=follow, parts=[part("a"), part("b"), part("c")])
    assert len(processes) == 3
    assert max(at_once) == 2


def test_a_canceled_compilation_is_not_waited_for(new_folder, monkeypatch):
    processes = started_instead(monkeypatch, "input()")
    endless = [Part(lambda: pytest.fail("it continued"), (name,), 1) for name in ("a", "b", "c")]
    warm_up(lambda: len(processes) == 2, parts=endless)
    assert len(processes) == 2
    assert all(process.returncode for process in processes)
    assert not elsewhere.is_compiling()


def test_without_other_processes_the_loops_are_compiled_here(new_folder, monkeypatch):
    monkeypatch.setattr(sys, "executable", "")
    assert warm_up(parts=FIRST) is None
    assert list(new_folder.iterdir()) == []


def test_a_loop_that_another_process_compiles_is_waited_for_and_not_compiled(tmp_path):
    def loop(x):
        return x + 1

    def compiled_with(folder):
        made = numba.njit(loop)
        made._cache = KeptLoop(loop, folder)
        return made

    first, second = compiled_with(tmp_path / "made"), compiled_with(tmp_path / "kept")
    assert first(1) == 2
    looked = []

    def is_at_work():
        looked.append(None)
        if len(looked) == 2:
            shutil.copytree(tmp_path / "made", tmp_path / "kept")
        return len(looked) < 10

    with elsewhere.compiling(is_at_work):
        assert second(1) == 2
    assert sum(second.stats.cache_hits.values()) == 1
    assert len(looked) == 2


def test_the_other_processes_import_the_program_and_nothing_from_the_current_folder(tmp_path, monkeypatch):
    (tmp_path / "numpy.py").write_text("raise SystemExit(3)")
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("PYTHONPATH", raising=False)
    process = aside.other_process("cpm_core.numerics.parallel:cores")
    assert process.wait() == 0
    process.communicate()


def test_the_other_processes_end_with_the_one_that_started_them():
    process = aside.other_process("signal:pause" if hasattr(signal, "pause") else "builtins:input")
    assert process.poll() is None
    process.communicate()  # closes the pipe, as the end of this process would
    assert process.returncode == 1
