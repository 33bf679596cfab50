"""A thread that does only the newest work of a kind, and says in the window when it fails."""

from __future__ import annotations

import threading
from collections.abc import Callable

from PySide6.QtCore import QObject, Signal

from app.session.exchange.error_messages import sentence
from app.session.exchange.mailbox import Mailbox
from app.session.signals import SessionSignals


class Latest(QObject):
    """Does the newest work on a thread of this name, which lasts as long as there is any.

    What the work fails with is said by the session, with `activity`, which follows "while" in the sentence.
    """

    done = Signal(object)
    """Result of a piece of work."""
    failed = Signal(str)
    """What a piece of work failed with, in a sentence."""

    def __init__(self, session: SessionSignals, name: str, activity: str) -> None:
        super().__init__(session)
        self._name = name
        self._activity = activity
        self._session = session
        self._lock = threading.Lock()
        self._waiting: Mailbox[Callable[[], object]] = Mailbox()
        self._thread: threading.Thread | None = None
        self._closed = False
        self.done.connect(self._succeed)
        self.failed.connect(self._fail)

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
                self.failed.emit(sentence(error, self._activity))
            else:
                self.done.emit(result)

    def _next(self) -> Callable[[], object] | None:
        with self._lock:
            work = self._waiting.take()
            if work is None:
                self._thread = None
            return work

    # Called on the window's thread: methods, because Qt calls anything else on the thread that emits.

    def _succeed(self, _: object) -> None:
        self._session.trouble("", self._name)

    def _fail(self, trouble: str) -> None:
        self._session.trouble(trouble, self._name)
