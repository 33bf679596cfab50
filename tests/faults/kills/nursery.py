"""Processes that are made to be killed: each does one thing, and ends by itself or in the middle of it."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable
from contextlib import nullcontext, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from ..report import asked_to_stop, stoppable

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

_MODULES = ["tests.faults.kills.warm", "cpm_core.cli", "cpm_app.views.application", __name__]
"""Loaded once, in the process that all others are copies of."""

_OPERATIONS = frozenset({"open", "os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.chmod", "os.utime", "os.fsync"})
"""Operations on files before which a process may be killed, as Python tells them."""

_LONGEST = 120.0
"""A process that goes on for so long beyond what it is told to hangs [s]."""


_LOOKS_EVERY = 0.5
"""Time after which is looked whether this process is asked to stop [s]."""


@dataclass(frozen=True, slots=True)
class End:
    """How a process ended: killed or not, what its function returned, its operations on files, killed as too slow."""

    killed: bool
    value: Any = None
    operations: int = 0
    late: bool = False


def outcome(folder: Path, function: Callable[..., Any], *arguments: Any, busy: float = 0.0) -> End:
    """Let a process call a function to its end, which is to be busy for so many seconds."""
    return _whole(_ended(folder, function, arguments, 0, busy + _LONGEST, until_stopped=busy > 0.0), function)


def killed_before(operation: int, folder: Path, function: Callable[..., Any], *arguments: Any) -> End:
    """Kill a process that calls a function just before so many operations on files of a folder, counted from one."""
    return _whole(_ended(folder, function, arguments, operation, _LONGEST), function)


def killed_after(seconds: float, folder: Path, function: Callable[..., Any], *arguments: Any) -> End:
    """Kill a process that calls a function after a time."""
    return _ended(folder, function, arguments, 0, seconds)


def _whole(end: End, function: Callable[..., Any]) -> End:
    """The end of a process that had all the time it needs."""
    if end.late:
        raise TimeoutError(f"{function.__name__} went on for {_LONGEST:.0f} s longer than it was told to.")
    return end


def _ended(
    folder: Path,
    function: Callable[..., Any],
    arguments: tuple[Any, ...],
    operation: int,
    seconds: float,
    until_stopped: bool = False,
) -> End:
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(_MODULES)
    line, theirs = context.Pipe(duplex=False)
    process = context.Process(target=_work, args=(theirs, folder, operation, function, arguments, until_stopped))
    process.start()
    theirs.close()
    told = None
    try:
        if not _tells(line, seconds, process if until_stopped else None):
            return End(True, late=True)
        with suppress(EOFError):  # it has been killed
            told = line.recv()
    finally:
        process.kill()
        process.join()
        line.close()
    return End(True) if told is None else End(False, *told)


def _tells(line: Connection, seconds: float, stopped: multiprocessing.process.BaseProcess | None) -> bool:
    """Whether a process tells something, or ends, within a time; it is asked to stop when this process is."""
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0.0:
        if line.poll(min(left, _LOOKS_EVERY)):
            return True
        if stopped is not None and asked_to_stop():
            stopped.terminate()
            stopped = None
    return False


def _work(
    line: Connection,
    folder: Path,
    operation: int,
    function: Callable[..., Any],
    arguments: tuple[Any, ...],
    until_stopped: bool,
) -> None:
    os.setsid()
    operations = _count_operations(folder, operation)
    os.chdir(folder)
    with stoppable() if until_stopped else nullcontext():
        value = function(*arguments)
    line.send((value, operations[0]))
    os.kill(os.getpid(), signal.SIGKILL)  # nothing that a normal end would still do


def _count_operations(folder: Path, last: int) -> list[int]:
    """Count operations on files of a folder from now on, and kill this process before the last."""
    counted, fsync = [0], os.fsync

    def see(event: str, arguments: tuple[Any, ...]) -> None:
        if event in _OPERATIONS and (event == "os.fsync" or any(_is_in(folder, argument) for argument in arguments)):
            counted[0] += 1
            if counted[0] == last:
                os.kill(os.getpid(), signal.SIGKILL)

    def fsync_seen(descriptor: int) -> None:
        sys.audit("os.fsync", descriptor)
        fsync(descriptor)

    os.fsync = fsync_seen
    sys.addaudithook(see)
    return counted


def _is_in(folder: Path, argument: object) -> bool:
    return isinstance(argument, str | bytes | os.PathLike) and os.fsdecode(argument).startswith(str(folder))
