"""Work on many items, shared among the cores.

No loop of the model starts threads of its own, so that two callers never meet inside one parallel region. A caller cuts
its items into parts, and each part is written by one thread alone: the same input gives the same bits on any number of
threads. There are more parts than threads, since some parts take longer than others: a thread that has finished a part
takes the next one, so that no caller waits for threads that work for another one.
"""

from __future__ import annotations

import os
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import lru_cache
from itertools import pairwise
from typing import Any, TypeVar

from threadpoolctl import OpenBLASController, ThreadpoolController

_Item = TypeVar("_Item")
_Found = TypeVar("_Found")

_PARTS_PER_THREAD = 2
"""Number of parts for each thread."""

_MAX_USEFUL_THREADS = 8
"""Number of threads beyond which the parts get too small to pay."""

_USABLE_CORES = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
"""Number of cores that the system lets this process use."""

_limits = [_MAX_USEFUL_THREADS]
"""Limits set on the number of threads of this process; the last one applies."""


def count_cores() -> int:
    """Return how many cores to use: those of the process, up to a sensible number or to the limit of `limit_cores`."""
    return min(_USABLE_CORES, _limits[-1])


@contextmanager
def limit_cores(count: int) -> Iterator[None]:
    """Limit the number of cores within this context, as for one of several processes that share them."""
    _limits.append(count)
    try:
        yield
    finally:
        _limits.pop()


_find_blas = lru_cache(maxsize=1)(ThreadpoolController)
"""Finds the libraries of linear algebra of this process."""

_blas_lock = threading.Lock()
"""Held while the next variable changes."""

_blas_limits: list[Any] = []
"""The limit of `limit_blas`, once for each thread that is within it."""


def _free_blas() -> None:
    """Let any thread set the limit: newer releases of threadpoolctl ignore all but the first that did so."""
    getattr(OpenBLASController, "clear_controlling_thread", lambda **_: None)(force=True)


@contextmanager
def limit_blas() -> Iterator[None]:
    """Compute products of matrices on the calling thread alone within this context.

    Small ones gain nothing from more threads, which wait for one another in busy loops: while other programs are
    running, a product then takes many times as long.
    """
    with _blas_lock:
        _free_blas()
        _blas_limits.append(_blas_limits[0] if _blas_limits else _find_blas().limit(limits=1, user_api="blas"))
    try:
        yield
    finally:
        with _blas_lock:
            limit = _blas_limits.pop()
            if not _blas_limits:  # the last thread, since the limit is that of the process
                _free_blas()
                limit.restore_original_limits()
                _free_blas()


_helpers = lru_cache(maxsize=1)(lambda: ThreadPoolExecutor(max(1, count_cores() - 1), "cpm-share"))
"""The other threads."""


def run_in_parallel(work: Callable[[int, int], object], count: int, min_part_size: int) -> None:
    """Process items 0 to `count` - 1 in parts that run in parallel.

    `work` gets the first item of a part and the one behind its last. It must release the interpreter's lock for a gain
    in time, and write only what belongs to its items. A part has `min_part_size` items or more; if there are not enough
    items for two parts, the caller does all the work.
    """
    threads = min(count_cores(), count // max(min_part_size, 1))
    if threads < 2:
        work(0, count)
        return
    todo = deque(
        pairwise(count * part // (_PARTS_PER_THREAD * threads) for part in range(_PARTS_PER_THREAD * threads + 1))
    )
    helping = [_helpers().submit(_run_parts, todo, work) for _ in range(threads - 1)]
    try:
        _run_parts(todo, work)
    finally:  # after an error or an interruption no thread begins another part
        todo.clear()
        errors = [task.exception() for task in helping if not task.cancel()]
    for error in filter(None, errors):
        raise error


def map_in_parallel(work: Callable[[_Item], _Found], items: Sequence[_Item]) -> list[_Found]:
    """Return what `work` makes of each item; see `run_in_parallel`."""
    found: dict[int, _Found] = {}

    def work_on(first: int, end: int) -> None:
        for number in range(first, end):
            found[number] = work(items[number])

    run_in_parallel(work_on, len(items), 1)
    return [found[number] for number in range(len(items))]


def _run_parts(todo: deque[tuple[int, int]], work: Callable[[int, int], object]) -> None:
    """Process parts until none is left."""
    while todo:
        try:
            part = todo.popleft()
        except IndexError:  # another thread was faster
            return
        work(*part)
