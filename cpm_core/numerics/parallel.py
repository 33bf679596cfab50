"""Work on many items, shared among the cores.

No loop of the model starts threads of its own, so that two callers never meet inside one parallel region. A caller cuts
its items into parts, and each part is written by one thread alone: the same input gives the same bits on any machine.
There are more parts than threads, since some parts take longer than others. When the caller has finished its own part,
it also does the parts that no thread has begun, so that no caller waits for the work of another one.

Callers may be interrupted at any moment, as by Ctrl+C in a notebook. The executors and conditions of the standard
library are written in Python, and may then keep a lock for ever; what stands here takes its parts and gives its results
by single operations that nothing interrupts.
"""

from __future__ import annotations

import atexit
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from queue import SimpleQueue
from threading import Thread

_PARTS = 2
"""Parts for each thread."""

_MOST = 8
"""Threads beyond which the parts get too small to pay."""


_limits = [_MOST]
"""What those who run this process allow it, the last of them counts."""


def cores() -> int:
    """Cores that this process may use, up to a sensible number, or to what `at_most` allows."""
    return min(_cores(), _limits[-1])


@contextmanager
def at_most(count: int) -> Iterator[None]:
    """Within this context, use so many cores at most, as one of several processes that share them."""
    _limits.append(count)
    try:
        yield
    finally:
        _limits.pop()


@lru_cache(maxsize=1)
def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


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
    left, ends = iter(range(1, parts)), SimpleQueue[BaseException | None]()

    def help_out() -> None:
        for part in left:
            try:
                work(bounds[part], bounds[part + 1])
            except BaseException as error:  # the caller raises it
                ends.put(error)
            else:
                ends.put(None)

    helpers = _helpers()
    for _ in range(threads - 1):
        helpers.put(help_out)
    given = parts - 1
    try:
        work(0, bounds[1])
        for part in left:
            given -= 1
            work(bounds[part], bounds[part + 1])
    finally:
        given -= sum(1 for _ in left)  # after an error or an interruption nobody begins another part
    errors = [ends.get() for _ in range(given)]
    for error in filter(None, errors):
        raise error


@lru_cache(maxsize=1)
def _helpers() -> SimpleQueue[Callable[[], object] | None]:
    """What the other threads are to do; they end when the program does."""
    waiting = SimpleQueue[Callable[[], object] | None]()

    def work() -> None:
        while (task := waiting.get()) is not None:
            task()
            del task  # and the arrays that it writes

    threads = [Thread(target=work, name=f"cpm-share-{number}", daemon=True) for number in range(1, max(2, cores()))]
    for thread in threads:
        thread.start()

    def end() -> None:
        """Let no compiled loop run while the interpreter takes away what it stands on."""
        for _ in threads:
            waiting.put(None)
        for thread in threads:
            thread.join()

    atexit.register(end)
    return waiting
