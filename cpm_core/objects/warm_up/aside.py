"""Compiling in other processes, for which a window that waits stays responsive, and which may use other cores.

Numba cannot compile in two threads at once.
"""

from __future__ import annotations

import gc
import importlib
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from cpm_core.numerics.loop_cache import elsewhere
from cpm_core.numerics.loop_cache.folders import SUFFIX, kept_folder
from cpm_core.numerics.parallel import cores
from cpm_core.objects.warm_up.parts import Part

_LOOK_EVERY = 0.05
"""Interval at which the other processes are polled [s]."""

_GENTLE = 10
"""By how much the priority of a process is lowered that other programs go before."""

_ALMOST = 0.99
"""Greatest fraction that is told before the end."""


def compile_parts(
    parts: Sequence[Part],
    canceled: Callable[[], bool],
    told: Callable[[float], object],
    gently: bool = False,
) -> None:
    """Compile parts of the loops in other processes, one for each core; where none can be started, do nothing.

    `told` is called with the fraction that is done. When `canceled()` becomes true the processes are ended. Other
    programs go before them if `gently`.
    """
    folder = kept_folder()
    if not parts or folder is None or cores() < 2:
        return
    waiting, expected, before = list(parts), sum(part.loops for part in parts), _count(folder)
    processes: list[subprocess.Popen[bytes]] = []

    def is_at_work() -> bool:
        return bool(waiting) or any(process.poll() is None for process in processes)

    with suppress(OSError), elsewhere.compiling(is_at_work):
        try:
            while is_at_work() and not canceled():
                while waiting and sum(process.poll() is None for process in processes) < cores():
                    processes.append(other_process(waiting.pop(0).name, gently=gently))
                told(min((_count(folder) - before) / expected, _ALMOST))
                time.sleep(_LOOK_EVERY)
        finally:
            waiting.clear()
            for process in processes:
                process.kill()
                process.communicate()


def other_process(
    part: str, environment: Mapping[str, str] | None = None, *, gently: bool = False, telling: bool = False
) -> subprocess.Popen[bytes]:
    """Start a process that compiles a part of the loops, module:function; its errors are seen if `telling`."""
    if getattr(sys, "frozen", False) or not sys.executable:
        raise FileNotFoundError("there is no interpreter to start")
    found_in = [str(Path(__file__).parents[3]), *filter(None, [os.environ.get("PYTHONPATH")])]
    module, _, function = part.partition(":")
    code = f"from cpm_core.objects.warm_up import aside; aside.run_alone({module!r}, {function!r}, {gently})"
    return subprocess.Popen(
        # -P: nothing is imported from the current folder of the user
        [sys.executable, "-P", "-c", code],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(found_in), **(environment or {})},
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=None if telling else subprocess.DEVNULL,
        creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),  # Windows would open a console
    )


def run_alone(module: str, function: str, gently: bool) -> None:
    """Compile a part of the loops, in a process of its own that ends with the one that has started it.

    Garbage is not collected: compiling makes so many objects that the search through them takes a tenth of the time.
    """
    _end_with_the_caller()
    if gently and hasattr(os, "nice"):
        os.nice(_GENTLE)
    gc.disable()
    getattr(importlib.import_module(module), function)()


def _end_with_the_caller() -> None:
    """End this process when the one that has started it ends, for any reason."""

    def watch() -> None:
        os.read(0, 1)  # nothing is ever sent: this blocks until the other end is closed
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def _count(folder: Path) -> int:
    """Loops that are kept in a folder."""
    return sum(1 for _ in folder.glob(f"*/*{SUFFIX}"))
