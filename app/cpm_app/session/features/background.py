"""Work on other threads of which only the newest counts, and parts that are made again only when they would differ."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from typing import Any, ParamSpec, TypeVar

import numpy as np
from PySide6.QtCore import QObject, Signal

from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import sentence
from cpm_app.session.session import Session
from cpm_core.numerics.types import Callback

P = ParamSpec("P")
T = TypeVar("T")


class LatestOnlyWorker(QObject):
    """Does the newest work on a thread of its own; work that still waits is dropped for it.

    What the work fails with is shown by the session, with `activity`, which follows "while" in the sentence.
    """

    _done = Signal(str, object)
    """What a piece of work failed with, if it did, and what follows; sent by the thread that works."""

    def __init__(self, session: Session, name: str, activity: str) -> None:
        super().__init__(session)
        self._name = name
        self._activity = activity
        self._session = session
        self._pool: ThreadPoolExecutor | None = ThreadPoolExecutor(1, name)
        self._newest: Future[None] | None = None
        self._done.connect(self._finish)

    @property
    def idle(self) -> bool:
        """Whether there is no work."""
        return self._newest is None or self._newest.done()

    def ask(self, work: Callable[[], T], then: Callable[[T], object], failed: Callback = lambda: None) -> None:
        """Do this in place of work that is still waiting; nothing is done any more once this is closed.

        On the window's thread, `then` is called with the result, or else `failed`.
        """
        self.forget()
        if self._pool is not None:
            self._newest = self._pool.submit(self._work, work, then, failed)

    def forget(self) -> None:
        """Drop waiting work."""
        if self._newest is not None:
            self._newest.cancel()

    def close(self) -> None:
        """Drop waiting work, take no more, and wait for the current one."""
        self.forget()
        if self._pool is not None:
            self._pool.shutdown()
            self._pool = None

    def _work(self, work: Callable[[], T], then: Callable[[T], object], failed: Callback) -> None:
        try:
            result = work()
        except Exception as error:  # shown to the user
            self._done.emit(sentence(error, self._activity), failed)
        else:
            self._done.emit("", partial(then, result))

    def _finish(self, trouble: str, then: Callback) -> None:  # Qt calls no lambda on the window's thread
        self._session.trouble(trouble, self._name)
        then()


class IdentityCache:
    """The newest part of each name, with what it was made of."""

    def __init__(self) -> None:
        self._made: dict[object, tuple[tuple[Any, ...], Any]] = {}

    def get(self, make: Callable[P, T], *given: P.args, **named: P.kwargs) -> T:
        """What the function has made of the same things before, or makes now."""
        return self.named(make, lambda: make(*given, **named), *given)

    def named(self, name: object, make: Callable[[], T], *given: object) -> T:
        """The same of a part with a name of its own."""
        known = self._made.get(name)
        if known is None or not is_same(known[0], given):
            known = self._made[name] = (given, make())
        made: T = known[1]
        return made

    def replace(self, name: object, given: tuple[Any, ...], part: object) -> bool:
        """Put another part in the place of one, if that is still made of the same things."""
        same = is_same(self._made[name][0], given)
        if same:
            self._made[name] = given, part
        return same

    def forget(self) -> None:
        """Keep nothing."""
        self._made.clear()


def is_same(known: tuple[Any, ...], given: tuple[Any, ...]) -> bool:
    """Whether what something is made of is what it was made of: the same objects, or equal values."""
    return len(known) == len(given) and all(
        one is other or (not isinstance(one, np.ndarray | Mapping) and one == other)
        for one, other in zip(known, given, strict=True)
    )


class AsyncCache(QObject):
    """Makes the newest parts of the slice of one view on other threads, each by its name."""

    completed = Signal()
    """A part that was asked for is whole now."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._parts = IdentityCache()
        self._workers: dict[str, LatestOnlyWorker] = {}

    def named(self, name: str, make: Callable[[], T], meanwhile: Callable[[], T], *given: object) -> T:
        """What is made of something, or at first what is in its place meanwhile."""

        def begin() -> T:
            if name not in self._workers:
                self._workers[name] = LatestOnlyWorker(self._session, "cpm-slices", tr("drawing a slice"))
            self._workers[name].ask(make, partial(self._take, name, given))
            return meanwhile()

        return self._parts.named(name, begin, *given)

    def close(self) -> None:
        """End the threads."""
        for worker in self._workers.values():
            worker.close()

    def _take(self, name: str, given: tuple[Any, ...], part: object) -> None:
        if self._parts.replace(name, given, part):
            self.completed.emit()
