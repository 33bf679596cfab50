"""Warming up compiles the kernels and has no other effect."""

import os
import subprocess
import sys
import threading

import numpy as np

from cpm_core import Engine, Parameters, circle
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


def test_warming_up_next_to_a_run_does_not_change_it():
    engine = Engine(disk((48, 48), (23.3, 24.1), 14.0).values, Parameters())

    def forty_steps():
        state = engine.start(circle((23.0, 24.0), 7.0))
        for _ in range(40):
            state = engine.step(state, Parameters())
        return state.position.tobytes()

    alone = forty_steps()
    other = threading.Thread(target=warm_up)
    other.start()
    together = forty_steps()
    other.join()
    assert together == alone


def test_nothing_begins_once_it_is_canceled():
    called = []
    warm_up(lambda: True, called.append)
    assert called == []


_PROGRAM = """
from cpm_core.numerics.jit import compiled
from cpm_core.objects import warm_up

@compiled
def kernel(x):
    return x + 1.0

progress = []
warm_up._KERNELS = {(part := lambda: kernel(1.0)): 2}
warm_up.warm_up(on_progress=progress.append, parts=[part])
print(progress)
"""


def test_progress_is_reported_when_kernels_are_compiled_and_not_when_they_are_loaded(tmp_path):
    program = tmp_path / "program.py"
    program.write_text(_PROGRAM)
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, str(program)]
    first, second = (
        subprocess.run(command, env=environment, capture_output=True, text=True, check=False) for _ in range(2)
    )
    assert (first.stdout.strip(), second.stdout.strip()) == ("[0.5]", "[]"), first.stderr + second.stderr


def test_kernels_are_compiled_where_no_cache_folder_can_be_written(tmp_path):
    program = tmp_path / "program.py"
    program.write_text(
        "import numba.core.caching as caching\n"
        "caching.CacheImpl._locator_classes = []\n"
        "from cpm_core.numerics.jit import compiled\n"
        "print(compiled(lambda x: x + 1.0)(1.0))\n"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, str(program)], env=environment, capture_output=True, text=True, check=False)
    assert done.stdout == "2.0\n", done.stderr
