"""Output on the terminal: progress lines, and phrases of several commands."""

from __future__ import annotations

import io
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType

from cpm_core.formats.common.printable import printable
from cpm_core.model.state import State
from cpm_core.objects.warm_up import FIRST, is_compiled, warm_up

_REDRAW = 0.1  # [s] between two lines of progress


def say(sentence: str) -> None:
    """Print a sentence to standard error, if anybody reads it."""
    with suppress(OSError, ValueError):
        print(printable(sentence), file=sys.stderr, flush=True)


def take_any_character() -> None:
    """Let characters that the terminal cannot show be written as numbers: they are no reason to fail.

    Nor are streams that are closed, as they are where no terminal is: what is written there goes nowhere.
    """
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115 - as long as the program
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def drop_output() -> None:
    """Send what is left of the output nowhere, so that Python does not fail with it when it ends."""
    with suppress(OSError, ValueError, AttributeError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


class Progress:
    """A line on a terminal with the progress of a run."""

    def __init__(self) -> None:
        self._due = 0.0

    def __call__(self, state: State) -> None:
        """Show a state, at most once in `_REDRAW` seconds."""
        now = time.monotonic()
        if now >= self._due:
            self._due = now + _REDRAW
            text = f"step {state.step}  scale {state.scale}  particles {state.count}"
            print(f"\r\x1b[2K{text}", end="", file=sys.stderr, flush=True)

    def clear(self) -> None:
        """Remove the line."""
        print("\r\x1b[2K", end="", file=sys.stderr, flush=True)


@contextmanager
def progress_line(*followers: Callable[[State], object]) -> Iterator[Callable[[State], None]]:
    """What to call with each state of a run within the block: it shows the progress on a terminal, and tells others."""
    line = Progress() if sys.stderr.isatty() else None

    def follow(state: State) -> None:
        for follower in followers:
            follower(state)
        if line is not None:
            line(state)

    try:
        yield follow
    finally:
        if line is not None:
            line.clear()


def announce_compilation() -> None:
    """Compile the kernels of a run ahead, where that has not been done yet, and say so."""
    if is_compiled():
        return
    say("cpm: the inner loops are compiled for this computer, once; the first run begins some seconds later.")
    shown = sys.stderr.isatty()

    def show(done: float) -> None:
        if shown:
            print(f"\r\x1b[2Kcompiling: {done:.0%}", end="", file=sys.stderr, flush=True)

    try:
        warm_up(on_progress=show, parts=FIRST)
    finally:
        if shown:
            print("\r\x1b[2K", end="", file=sys.stderr, flush=True)


class Count:
    """A line on a terminal with how many of `total` items are done, and how long the others will take."""

    def __init__(self, total: int) -> None:
        self._total = total
        self._done = 0
        self._began = time.monotonic()
        self._shown = sys.stderr.isatty()

    def __enter__(self) -> Count:
        self._draw()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._clear()

    def advance(self) -> None:
        """Count one more item."""
        self._done += 1
        self._draw()

    def message(self, sentence: str) -> None:
        """Print a sentence on a line of its own."""
        self._clear()
        print(sentence, file=sys.stderr, flush=True)
        self._draw()

    def _draw(self) -> None:
        if self._shown:
            each = (time.monotonic() - self._began) / self._done if self._done else 0.0
            left = each * (self._total - self._done)
            rest = f", about {left:.0f} s left" if left else ""
            print(f"\r\x1b[2K{self._done} of {self._total}{rest}", end="", file=sys.stderr, flush=True)

    def _clear(self) -> None:
        if self._shown:
            print("\r\x1b[2K", end="", file=sys.stderr, flush=True)
