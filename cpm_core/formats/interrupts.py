"""Interrupts: what Ctrl+C does for a while."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def interrupts_handled(handler: Callable[[int, FrameType | None], object] | signal.Handlers) -> Iterator[None]:
    """Handle Ctrl+C in the block by `handler`; in any but the main thread, which alone is interrupted, as before."""
    try:
        before = signal.signal(signal.SIGINT, handler)
    except ValueError:  # only the main thread may change it
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def interrupts_put_off() -> Iterator[None]:
    """Let Ctrl+C wait until the end of the block, and then have the effect that it would have had."""
    before = signal.getsignal(signal.SIGINT)
    if not callable(before):  # ignored, or not of Python
        yield
        return
    came: list[tuple[int, FrameType | None]] = []
    with interrupts_handled(lambda *told: came.append(told)):
        yield
    if came:
        before(*came[0])
