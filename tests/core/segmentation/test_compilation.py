"""Warming up compiles and has no other effect."""

import os
import subprocess
import sys
import threading

import numpy as np
import pytest

from cpm_core import Engine, Parameters, circle
from cpm_core.numerics import jit_cache
from cpm_core.objects import warm_up as compilation
from cpm_core.objects.warm_up import warm_up

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
    """An empty cache folder, and two cores."""
    monkeypatch.setattr(jit_cache, "folder_of_this_package", lambda: tmp_path)
    monkeypatch.setattr(compilation, "cores", lambda: 2)
    return tmp_path


def test_caches_of_other_processes_are_copied_once(new_folder, monkeypatch):
    started = []

    def quick_process(part, aside):
        started.append(part)
        code = (
            "import pathlib, sys\n"
            "kept = pathlib.Path(sys.argv[1]) / 'loops-1' / 'cpm_core_1'\n"
            "kept.mkdir(parents=True)\n"
            "(kept / f'{sys.argv[2]}.nbi').touch()"
        )
        return subprocess.Popen([sys.executable, "-c", code, str(aside), part], stdin=subprocess.PIPE)

    monkeypatch.setattr(compilation, "_other_process", quick_process)
    warm_up()
    warm_up()
    assert started == ["step_once", "reconstruct_once"]
    assert sorted(path.name for path in new_folder.rglob("*.nbi")) == ["reconstruct_once.nbi", "step_once.nbi"]
    assert [path.name for path in new_folder.iterdir()] == ["cpm_core_1"]


def test_a_canceled_compilation_is_not_waited_for(new_folder, monkeypatch):
    started = []

    def endless_process(part, aside):
        started.append(subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE))
        return started[-1]

    monkeypatch.setattr(compilation, "_other_process", endless_process)

    def step_once():
        pytest.fail("it continued")

    monkeypatch.setattr(compilation, "step_once", step_once)
    warm_up(lambda: len(started) == 2)
    assert all(process.returncode for process in started)
    assert list(new_folder.iterdir()) == []


def test_without_other_processes_the_loops_are_compiled_here(new_folder, monkeypatch):
    monkeypatch.setattr(sys, "executable", "")
    assert warm_up() is None
    assert list(new_folder.iterdir()) == []


def test_the_other_processes_import_the_program_and_nothing_from_the_current_folder(tmp_path, monkeypatch):
    (tmp_path / "numpy.py").write_text("raise SystemExit(3)")
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("PYTHONPATH", raising=False)
    aside = tmp_path / "aside"
    process = compilation._other_process("cores", aside)
    assert process.wait() == 0
    process.communicate()
    assert list(aside.glob("loops-*"))


def test_the_other_processes_end_with_the_one_that_started_them(tmp_path):
    process = compilation._other_process("threading.Event().wait", tmp_path)
    assert process.poll() is None
    process.communicate()  # closes the pipe, as the end of this process would
    assert process.returncode == 1


def test_loops_already_in_the_cache_are_not_overwritten(tmp_path):
    aside, kept = tmp_path / "aside", tmp_path / "kept"
    source = aside / "loops-1" / "cpm_core_1"
    for folder, text in ((source, "new"), (kept / "cpm_core_1", "old")):
        folder.mkdir(parents=True)
        for name in ("a.f-1.py311.nbi", "a.f-1.py311.1.nbc"):
            (folder / name).write_text(text)
    for name in ("a.g-9.py311.nbi", "a.g-9.py311.1.nbc", "a.g-9.py311.2.nbc"):
        (source / name).write_text("new")
    jit_cache.take_over(aside, kept)
    assert {path.name: path.read_text() for path in (kept / "cpm_core_1").iterdir()} == {
        "a.f-1.py311.nbi": "old",
        "a.f-1.py311.1.nbc": "old",
        "a.g-9.py311.nbi": "new",
        "a.g-9.py311.1.nbc": "new",
        "a.g-9.py311.2.nbc": "new",
    }
