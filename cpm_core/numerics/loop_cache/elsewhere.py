"""Whether other processes compile loops for this one, which then waits for them and compiles none of them again."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

_AT_WORK: list[Callable[[], bool]] = []


def is_compiling() -> bool:
    """Whether a loop that is missing may yet come from another process."""
    return any(is_at_work() for is_at_work in tuple(_AT_WORK))


@contextmanager
def compiling(is_at_work: Callable[[], bool]) -> Iterator[None]:
    """Within this context, loops are waited for as long as `is_at_work()` is true."""
    _AT_WORK.append(is_at_work)
    try:
        yield
    finally:
        _AT_WORK.remove(is_at_work)
