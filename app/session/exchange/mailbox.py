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
    """One slot in which the newest wins; content that was not taken in time is replaced, never queued.

    No thread waits for another: a deque of length one replaces and returns its content in single atomic operations.
    With a lock, the window would have to wait for a worker that was interrupted while holding it.
    """

    def __init__(self) -> None:
        self._content: deque[T] = deque(maxlen=1)

    def put(self, content: T) -> None:
        """Leave `content` in place of any that was not taken yet."""
        self._content.append(content)

    def take(self) -> T | None:
        """Take the content once, or None."""
        try:
            return self._content.pop()
        except IndexError:
            return None

    @property
    def newest(self) -> T | None:
        """The content without taking it, or None."""
        try:
            return self._content[-1]
        except IndexError:
            return None

    def __bool__(self) -> bool:
        return bool(self._content)


class Latest(QObject):
    """Does the newest work on a thread of this name, which lasts as long as there is any."""

    done = Signal(object)
    """Result of a piece of work."""

    def __init__(self, name: str, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._name = name
        self._lock = threading.Lock()
        self._waiting: Mailbox[Callable[[], object]] = Mailbox()
        self._thread: threading.Thread | None = None
        self._closed = False

    @property
    def idle(self) -> bool:
        """Whether there is no work."""
        return self._thread is None

    def ask(self, work: Callable[[], object]) -> None:
        """Do this in place of work that is still waiting; nothing is done any more once this is closed."""
        with self._lock:
            if self._closed:  # its result would be emitted by an object that may have been deleted
                return
            self._waiting.put(work)
            if self._thread is None:
                self._thread = threading.Thread(target=self._work, name=self._name, daemon=True)
                self._thread.start()

    def forget(self) -> None:
        """Drop waiting work."""
        self._waiting.take()

    def close(self) -> None:
        """Drop waiting work, take no more, and wait for the current one."""
        with self._lock:
            self._closed = True
        self.forget()
        thread = self._thread
        if thread is not None:
            thread.join()

    def _work(self) -> None:
        while (work := self._next()) is not None:
            try:
                result = work()
            except Exception as error:  # no error may end the thread
                log.error("unexpected error in %s", self._name, exc_info=error)
            else:
                self.done.emit(result)

    def _next(self) -> Callable[[], object] | None:
        with self._lock:
            work = self._waiting.take()
            if work is None:
                self._thread = None
            return work
