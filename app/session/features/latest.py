"""Work on other threads of which only the newest counts, and parts that are made again only when they would differ."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from PySide6.QtCore import QObject, Signal

from app.model.text.language import tr
from app.session.exchange.error_messages import sentence
from app.session.exchange.mailbox import Mailbox
from app.session.session import Session

T = TypeVar("T")


class Same:
    """Stands for a value that is compared by its identity."""

    def __init__(self, value: object) -> None:
        self._value = value

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Same) and self._value is other._value

    def __hash__(self) -> int:
        return id(self._value)


class MadeOnce:
    """Keeps the newest part of each name, with what it was made of."""

    def __init__(self) -> None:
        self._made: dict[str, tuple[tuple[Any, ...], Any]] = {}

    def of(self, name: str, given: tuple[Any, ...], make: Callable[[], T]) -> T:
        """What has been made of the same things before, or is made now."""
        known = self._made.get(name)
        if known is None or not is_same(known[0], given):
            known = self._made[name] = (given, make())
        made: T = known[1]
        return made

    def forget(self) -> None:
        """Keep nothing."""
        self._made.clear()


def is_same(known: tuple[Any, ...], given: tuple[Any, ...]) -> bool:
    """Whether what something is made of is what it was made of: the same objects, or equal values."""
    return len(known) == len(given) and all(
        one is other or one == other for one, other in zip(known, given, strict=True)
    )


class Latest(QObject):
    """Does the newest work on a thread of this name, which lasts as long as there is any.

    What the work fails with is said by the session, with `activity`, which follows "while" in the sentence.
    """

    done = Signal(object)
    """Result of a piece of work."""
    failed = Signal(str)
    """What a piece of work failed with, in a sentence."""

    def __init__(self, session: Session, name: str, activity: str) -> None:
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


@dataclass(frozen=True, eq=False, slots=True)
class _Made:
    """A part, and what it was made of."""

    given: tuple[Any, ...]
    part: Any
    whole: bool


class _Newest(QObject):
    """The newest part of one name."""

    def __init__(self, session: Session, tell: Callable[[], None]) -> None:
        super().__init__(session)
        self._tell = tell
        self._made: _Made | None = None
        self.latest = Latest(session, "cpm-slices", tr("drawing a slice"))
        self.latest.done.connect(self._take)

    def of(self, given: tuple[Any, ...], make: Callable[[], Any], meanwhile: Callable[[], Any]) -> Any:
        if self._made is None or not is_same(self._made.given, given):
            self._made = _Made(given, meanwhile(), False)
            self.latest.ask(lambda: _Made(given, make(), True))
        return self._made.part

    def _take(self, made: _Made) -> None:
        if self._made is not None and not self._made.whole and is_same(self._made.given, made.given):
            self._made = made
            self._tell()


class MadeLater(QObject):
    """Gives the newest parts of the slice of one view, each by its name."""

    completed = Signal()
    """A part that was asked for is whole now."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._parts: dict[str, _Newest] = {}

    def of(self, name: str, given: tuple[Any, ...], make: Callable[[], T], meanwhile: Callable[[], T]) -> T:
        """What is made of something, or at first what stands in its place meanwhile."""
        if name not in self._parts:
            self._parts[name] = _Newest(self._session, self.completed.emit)
        part: T = self._parts[name].of(given, make, meanwhile)
        return part

    def close(self) -> None:
        """End the threads."""
        for newest in self._parts.values():
            newest.latest.close()
