"""Limits of one input: the time that it may take, the memory, and the kinds of refusal that are sound."""

from __future__ import annotations

import contextlib
import resource
import signal
import traceback
from collections.abc import Iterator
from pathlib import Path

from cpm_core.formats.common.printable import make_printable

LONGEST = 10.0
"""Processor time that one input may take [s]; that of the clock would tell how busy the computer is."""

LONGEST_SENTENCE = 1000
"""Most characters of a message: values in it are cut short."""

_ROOT = Path(__file__).parents[3]


class TooLongError(BaseException):
    """An input takes too long; no `except Exception` on its way holds it up."""


@contextlib.contextmanager
def in_time(seconds: float = LONGEST) -> Iterator[None]:
    """Raise `TooLongError` in the block after so much processor time."""

    def stop(*_: object) -> None:
        raise TooLongError(f"took more than {seconds:g} s")

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def limit_memory(size: int) -> None:
    """Let this process take so much address space at most [bytes]."""
    resource.setrlimit(resource.RLIMIT_AS, (size, resource.getrlimit(resource.RLIMIT_AS)[1]))


def check_sentence(error: Exception) -> None:
    """Fail unless an error says in one line of bounded length what is wrong."""
    text = str(error)
    assert text, f"{type(error).__name__} without a word"
    assert "\n" not in text, f"more than one line: {text[:200]!r}"
    assert make_printable(text) == text, f"not printable: {text[:200]!r}"
    assert text[-1] in ".?!", f"no sentence: {text[:200]!r}"
    assert len(text) <= LONGEST_SENTENCE, f"{len(text)} characters: {text[:200]!r}"


def failure_of(error: BaseException) -> str:
    """What failed and where: the error, and the last two lines of this project that it came through."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if Path(frame.filename).is_relative_to(_ROOT)]
    places = " < ".join(f"{Path(frame.filename).relative_to(_ROOT)}:{frame.lineno}" for frame in reversed(own[-2:]))
    return f"{type(error).__name__}: {str(error)[:300]} [{places}]"
