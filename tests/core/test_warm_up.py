"""Warming up compiles the kernels and has no other effect."""

import os
import sys
import threading

import numpy as np

from cpm_core import Engine, Parameters, circle
from cpm_core import warm_up as warm_up_module
from cpm_core.field import scale_field, scale_space
from cpm_core.model.plane import state as state_module
from cpm_core.numerics import jit
from cpm_core.segmentation import local_fields
from cpm_core.warm_up import warm_up

from .scenes import disk


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


def test_the_share_of_the_kernels_that_are_compiled_is_told_without_those_of_other_threads(monkeypatch):
    def part():
        for number in (1.0, 2):
            jit._numba().njit(lambda value: value + 1)(number)
        other = threading.Thread(target=jit._numba().njit(lambda value: value + 2), args=(1.0,))
        other.start()
        other.join()

    told = []
    monkeypatch.setitem(warm_up_module._KERNELS, part, 4)
    warm_up(on_progress=told.append, parts=(part, part))
    assert told == [0.125, 0.25, 0.375, 0.5]
    assert not jit._told


def test_nothing_begins_once_it_is_canceled():
    called = []
    warm_up(lambda: True, called.append)
    assert called == []


def compiled() -> dict[str, list[object]]:
    """The types of arguments that each kernel is compiled for."""
    modules = [module for name, module in [*sys.modules.items()] if name.startswith("cpm_core")]
    kernels = [kernel for module in modules for kernel in vars(module).values() if isinstance(kernel, jit._LazyKernel)]
    found = {kernel.__wrapped__.__qualname__: list(kernel.signatures) for kernel in kernels}
    assert any(found.values())
    return found


def test_no_kernel_is_left_to_compile_for_a_large_image(monkeypatch):
    warm_up()
    before = compiled()
    for module in (scale_field, scale_space, local_fields):
        monkeypatch.setattr(module, "LARGE_IMAGE_PIXELS", 1000)
    monkeypatch.setattr(scale_field, "_FIELD_TILE_SIDE", 20)
    monkeypatch.setattr(state_module, "_MIN_WINDOWED_PIXELS", 1000)
    monkeypatch.setattr(state_module, "_MIN_WINDOW_ROOM", 12)
    parameters, windows = Parameters(scales=1), []
    for seeds in (circle((64.0, 64.0), 7.0), np.argwhere(np.ones((16, 16))) * 8.0):
        engine = Engine(disk((128, 128), (64.0, 64.0), 14.0).values, parameters)
        state = engine.start(seeds)
        for _ in range(40):
            state = engine.step(state, parameters)
        assert engine.result(state, parameters).contours
        windows.append(state.window is not None)
    assert windows == [True, False]
    assert compiled() == before
