"""Work on many items, shared among the cores.

No loop of the model starts threads of its own, so that two callers never meet inside one parallel region. A caller cuts
its items into parts, and each part is written by one thread alone: the same input gives the same bits on any machine.
There are more parts than threads, since some parts take longer than others. When the caller has finished its own part,
it also does the parts that no thread has begun, so that no caller waits for the work of another one.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache

_PARTS = 2
"""Parts for each thread."""

_MOST = 8
"""Threads beyond which the parts get too small to pay."""


@lru_cache(maxsize=1)
def cores() -> int:
    """Cores that this process may use, up to a sensible number."""
    allowed = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(allowed, _MOST)


def share(work: Callable[[int, int], object], count: int, least: int) -> None:
    """Do some work on items 0 to `count` - 1, in parts that run side by side.

    `work` gets the first item of a part and the one behind its last. It must release the interpreter's lock for a gain
    in time, and write only what belongs to its items. A part has `least` items or more; if there are not enough items
    for two parts, the caller does all the work.
    """
    threads = min(cores(), count // max(least, 1))
    if threads < 2:
        work(0, count)
        return
    parts = _PARTS * threads
    bounds = [count * part // parts for part in range(parts + 1)]
    others = [_pool().submit(work, bounds[part], bounds[part + 1]) for part in range(1, parts)]
    work(0, bounds[1])
    for part in reversed(range(1, parts)):
        if others[part - 1].cancel():
            work(bounds[part], bounds[part + 1])
        else:
            others[part - 1].result()


@lru_cache(maxsize=1)
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(max_workers=max(1, cores() - 1), thread_name_prefix="cpm-share")
