"""Work on other threads of which only the newest counts, and parts that are made again only when they would differ."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

from PySide6.QtCore import QObject, Signal

from app.model.text.language import tr
from app.session.exchange.mailbox import Mailbox
from app.session.exchange.messages import sentence
from app.session.session import Session

P = ParamSpec("P")
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
    """Keeps the newest part that each function has made, with what it was made of."""

    def __init__(self) -> None:
        self._made: dict[object, tuple[tuple[Any, ...], Any]] = {}

    def of(self, make: Callable[P, T], *given: P.args, **named: P.kwargs) -> T:
        """What the function has made of the same things before, or makes now."""
        return self.named(make, lambda: make(*given, **named), *given)

    def named(self, name: object, make: Callable[[], T], *given: object) -> T:
        """The same of a part with a name of its own."""
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


class MadeLater(QObject):
    """Makes the newest parts of the slice of one view on other threads, each by its name."""

    completed = Signal()
    """A part that was asked for is whole now."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._parts: dict[str, tuple[tuple[Any, ...], Any]] = {}
        self._threads: dict[str, Latest] = {}

    def named(self, name: str, make: Callable[[], T], meanwhile: Callable[[], T], *given: object) -> T:
        """What is made of something, or at first what is in its place meanwhile."""
        if name not in self._threads:
            self._threads[name] = Latest(self._session, "cpm-slices", tr("drawing a slice"))
            self._threads[name].done.connect(self._take)
        known = self._parts.get(name)
        if known is None or not is_same(known[0], given):
            known = self._parts[name] = given, meanwhile()
            self._threads[name].ask(lambda: (name, given, make()))
        part: T = known[1]
        return part

    def close(self) -> None:
        """End the threads."""
        for latest in self._threads.values():
            latest.close()

    def _take(self, made: tuple[str, tuple[Any, ...], Any]) -> None:
        name, given, part = made
        if is_same(self._parts[name][0], given):
            self._parts[name] = given, part
            self.completed.emit()
