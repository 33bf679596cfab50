"""The newest wins: a slot between two threads, and a thread that does only the newest work."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

from PySide6.QtCore import QObject, Signal

log = logging.getLogger(__name__)

T = TypeVar("T")


class Mailbox(Generic[T]):
    """One slot in which the newest wins; what was not taken in time is replaced, never queued.

    No thread waits for another: a deque of one place replaces and gives out its content in single strokes, where behind
    a lock the window would have to wait for a worker that was interrupted while holding it.
    """

    def __init__(self) -> None:
        self._content: deque[T] = deque(maxlen=1)

    def put(self, content: T) -> None:
        """Leave `content`, in place of whatever was not taken yet."""
        self._content.append(content)

    def take(self) -> T | None:
        """Take what is there, or None; it is taken once."""
        try:
            return self._content.pop()
        except IndexError:
            return None

    @property
    def newest(self) -> T | None:
        """What is there, without taking it, or None."""
        try:
            return self._content[-1]
        except IndexError:
            return None

    def __bool__(self) -> bool:
        return bool(self._content)


class Latest(QObject):
    """Does the newest piece of work that it is given, and tells what came of it.

    Parameters
    ----------
    name : str
        Name of the thread.
    parent : QObject, optional
        Owner.
    """

    done = Signal(object)
    """What a piece of work has come to."""

    def __init__(self, name: str, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._name = name
        self._lock = threading.Lock()
        self._waiting: Mailbox[Callable[[], object]] = Mailbox()
        self._thread: threading.Thread | None = None

    @property
    def idle(self) -> bool:
        """Whether there is nothing to do."""
        return self._thread is None

    def ask(self, work: Callable[[], object]) -> None:
        """Do this instead of whatever is still waiting."""
        with self._lock:
            self._waiting.put(work)
            if self._thread is None:
                self._thread = threading.Thread(target=self._work, name=self._name, daemon=True)
                self._thread.start()

    def forget(self) -> None:
        """Drop what is waiting."""
        self._waiting.take()

    def close(self) -> None:
        """Drop what is waiting and wait for what is being done."""
        self.forget()
        thread = self._thread
        if thread is not None:
            thread.join()

    def _work(self) -> None:
        while (work := self._next()) is not None:
            try:
                came = work()
            except Exception as error:  # the thread's outermost frame: whatever happens must not end it
                log.error("unexpected trouble in %s", self._name, exc_info=error)
            else:
                self.done.emit(came)

    def _next(self) -> Callable[[], object] | None:
        with self._lock:
            work = self._waiting.take()
            if work is None:
                self._thread = None
            return work
