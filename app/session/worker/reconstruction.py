"""Reconstruction of the newest particles, on a thread of its own and at its own slower pace."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from app.session.exchange.contour_tracking import ContourTracker
from app.session.exchange.error_messages import sentence
from app.session.exchange.mailbox import Mailbox
from app.session.exchange.messages import Reconstruction
from cpm_core.contours.result import Result
from cpm_core.parameters import Parameters
from cpm_core.segmentation.method import Method, MethodState

_SHORTEST_PAUSE = 0.15
_REST_PER_WORK = 5.0
_LOOK_EVERY = 0.05
"""Time between two looks at whether what is waited for is still wanted [s]."""


@dataclass(frozen=True, eq=False, slots=True)
class Request:
    """A state to reconstruct contours from; `last` says that none will follow soon, so do not wait."""

    generation: int
    method: Method[Any]
    state: MethodState
    parameters: Parameters
    last: bool


class Reconstructor:
    """Reconstructs the newest request and leaves the contours in `results`."""

    def __init__(self) -> None:
        self.results: Mailbox[Reconstruction] = Mailbox()
        self._changed = threading.Condition()
        self._tracker = ContourTracker()
        self._requests: Mailbox[Request] = Mailbox()
        self._latest: Reconstruction | None = None
        self._working = False
        self._quit = False
        self._thread = threading.Thread(target=self._work, name="cpm-reconstruction", daemon=True)
        self._thread.start()

    @property
    def idle(self) -> bool:
        """Whether there is nothing to do; asked in every frame, and therefore without waiting for the lock."""
        return not self._requests and not self._working

    def ask(self, request: Request) -> None:
        """Reconstruct this instead of whatever is still waiting."""
        with self._changed:
            self._requests.put(request)
            self._changed.notify_all()

    def forget(self) -> None:
        """Drop what is waiting."""
        with self._changed:
            self._requests.take()

    def latest(self, generation: int, wanted: Callable[[], bool]) -> Reconstruction | None:
        """The contours of the newest request of a run, once they are made.

        Parameters
        ----------
        generation : int
            The run.
        wanted : callable
            Asked while they are being made.

        Returns
        -------
        Reconstruction or None
            The one that is left in `results`; None where there is none, or it is no longer wanted.
        """
        with self._changed:
            waiting = self._requests.newest
            if waiting is not None and not waiting.last:  # no pause before these
                self._requests.put(replace(waiting, last=True))
                self._changed.notify_all()
            while not (self.idle or self._quit):
                if not wanted():
                    return None
                self._changed.wait(_LOOK_EVERY)
            found = self._latest
            return found if found is not None and found.generation == generation else None

    def close(self) -> None:
        """End the thread and wait for it."""
        with self._changed:
            self._quit = True
            self._changed.notify_all()
        self._thread.join()

    def _work(self) -> None:
        rest = 0.0
        while (request := self._next(rest)) is not None:
            began = time.perf_counter()
            self._reconstruct(request)
            rest = max(_SHORTEST_PAUSE, _REST_PER_WORK * (time.perf_counter() - began))
            with self._changed:
                self._working = False
                self._changed.notify_all()

    def _next(self, rest: float) -> Request | None:
        with self._changed:
            self._changed.wait_for(lambda: self._quit or self._is_last_waiting(), timeout=rest)
            self._changed.wait_for(lambda: self._quit or bool(self._requests))
            if self._quit:
                return None
            self._working = True  # before the request is gone, so that in between this is not taken for idle
            return self._requests.take()

    def _is_last_waiting(self) -> bool:
        request = self._requests.newest
        return request is not None and request.last

    def _reconstruct(self, request: Request) -> None:
        try:
            result = request.method.result(request.state, request.parameters)
            if request.state.step == 0 and isinstance(result, Result):  # gone back to the drawing
                result = replace(result, contours=(), bridges=())
            found = Reconstruction.of(request.generation, result, self._tracker, thorough=request.last)
        except Exception as error:  # the thread's outermost frame: whatever happens must not end it
            sentence(error, "reconstructing contours")
            return
        self._latest = found
        self.results.put(found)
