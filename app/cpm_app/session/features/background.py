"""Work on other threads, of which only the newest matters, and caches of parts that depend on their inputs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from typing import Any, ParamSpec, TypeVar

import numpy as np
from PySide6.QtCore import QObject, Signal

from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import explain_failure
from cpm_app.session.session import Session
from cpm_core.numerics.types import Callback

Arguments = ParamSpec("Arguments")
Made = TypeVar("Made")


class LatestOnlyWorker(QObject):
    """Does the newest work on a thread of its own, until the session closes; work that is still waiting is dropped.

    Errors of the work are shown by the session; `activity` follows "while" in their messages.
    """

    _done = Signal(str, object)
    """The error message of the work or "", and the callback that follows; sent by the thread that works."""

    def __init__(self, session: Session, name: str, activity: str) -> None:
        super().__init__(session)
        self._name = name
        self._activity = activity
        self._session = session
        self._pool: ThreadPoolExecutor | None = ThreadPoolExecutor(1, name)
        self._newest: Future[None] | None = None
        self._done.connect(self._on_done)
        session.closing.connect(self.close)

    @property
    def idle(self) -> bool:
        """Whether there is no work."""
        return self._newest is None or self._newest.done()

    def submit(
        self, compute: Callable[[], Made], on_result: Callable[[Made], object], on_error: Callback = lambda: None
    ) -> None:
        """Do this work in place of work that is still waiting; after `close` nothing is done.

        On the window's thread, `on_result` is called with the result, or `on_error` after an error.
        """
        self.drop_waiting()
        if self._pool is not None:
            self._newest = self._pool.submit(self._compute_and_report, compute, on_result, on_error)

    def drop_waiting(self) -> None:
        """Drop waiting work."""
        if self._newest is not None:
            self._newest.cancel()

    def close(self) -> None:
        """Drop waiting work, accept no more, and wait for the current one."""
        self.drop_waiting()
        if self._pool is not None:
            self._pool.shutdown()
            self._pool = None

    def _compute_and_report(self, work: Callable[[], Made], then: Callable[[Made], object], failed: Callback) -> None:
        try:
            result = work()
        except Exception as error:  # shown to the user
            self._done.emit(explain_failure(error, self._activity), failed)
        else:
            self._done.emit("", partial(then, result))

    def _on_done(self, trouble: str, then: Callback) -> None:  # a method: Qt would call a lambda on the sending thread
        self._session.messages.set_error(trouble, self._name)
        then()


class IdentityCache:
    """The newest part of each name, with the inputs that it was made from."""

    def __init__(self) -> None:
        self._made: dict[object, tuple[tuple[Any, ...], Any]] = {}

    def get(self, make: Callable[Arguments, Made], *given: Arguments.args, **named: Arguments.kwargs) -> Made:
        """Return the function's result for these arguments, computed again only if they differ from the last ones."""
        return self.get_named(make, lambda: make(*given, **named), *given)

    def get_named(self, name: object, make: Callable[[], Made], *given: object) -> Made:
        """Return the part with a name, made again only if its inputs differ from the last ones."""
        known = self._made.get(name)
        if known is None or not is_same_input(known[0], given):
            known = self._made[name] = (given, make())
        made: Made = known[1]
        return made

    def replace_part(self, name: object, given: tuple[Any, ...], part: object) -> bool:
        """Replace a part, if its inputs are still the same; return whether they are."""
        same = is_same_input(self._made[name][0], given)
        if same:
            self._made[name] = given, part
        return same

    def clear(self) -> None:
        """Remove all parts."""
        self._made.clear()


def is_same_input(known: tuple[Any, ...], given: tuple[Any, ...]) -> bool:
    """Return whether two tuples of inputs agree: each the same object, or equal and neither array nor mapping."""
    return len(known) == len(given) and all(
        one is other or (not isinstance(one, np.ndarray | Mapping) and one == other)
        for one, other in zip(known, given, strict=True)
    )


class AsyncCache(QObject):
    """Makes the newest parts of the slice of one view on other threads, each by its name."""

    completed = Signal()
    """A requested part is complete."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._parts = IdentityCache()
        self._workers: dict[str, LatestOnlyWorker] = {}

    def get_named(self, name: str, make: Callable[[], Made], meanwhile: Callable[[], Made], *given: object) -> Made:
        """Return the part made from these inputs, or `meanwhile` until it is ready."""

        def start_making() -> Made:
            if name not in self._workers:
                self._workers[name] = LatestOnlyWorker(self._session, "cpm-slices", tr("drawing a slice"))
            self._workers[name].submit(make, partial(self._on_part_made, name, given))
            return meanwhile()

        return self._parts.get_named(name, start_making, *given)

    def _on_part_made(self, name: str, given: tuple[Any, ...], part: object) -> None:
        if self._parts.replace_part(name, given, part):
            self.completed.emit()
