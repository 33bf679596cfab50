"""Reconstruction of the newest particles, on a thread of its own and at its own slower pace."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass, replace

from app.session.exchange.contour_tracking import ContourTracker
from app.session.exchange.error_messages import sentence
from app.session.exchange.mailbox import Mailbox
from app.session.exchange.messages import Reconstruction
from cpm_core.parameters import Parameters
from cpm_core.particles.state import State
from cpm_core.segmentation.engine import Engine

_SHORTEST_PAUSE = 0.15
_REST_PER_WORK = 5.0


@dataclass(frozen=True, eq=False, slots=True)
class Request:
    """Particles to reconstruct contours from; `last` says that none will follow soon, so do not wait."""

    generation: int
    engine: Engine
    state: State
    parameters: Parameters
    last: bool


class Reconstructor:
    """Reconstructs the newest request and leaves the contours in `results`."""

    def __init__(self) -> None:
        self.results: Mailbox[Reconstruction] = Mailbox()
        self._changed = threading.Condition()
        self._tracker = ContourTracker()
        self._request: Request | None = None
        self._working = False
        self._quit = False
        self._thread = threading.Thread(target=self._work, name="cpm-reconstruction", daemon=True)
        self._thread.start()

    @property
    def idle(self) -> bool:
        """Whether there is nothing to do; asked in every frame, and therefore without waiting for the lock."""
        return self._request is None and not self._working

    def ask(self, request: Request) -> None:
        """Reconstruct this instead of whatever is still waiting."""
        with self._changed:
            self._request = request
            self._changed.notify_all()

    def forget(self) -> None:
        """Drop what is waiting."""
        with self._changed:
            self._request = None

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

    def _next(self, rest: float) -> Request | None:
        with self._changed:
            self._changed.wait_for(
                lambda: self._quit or (self._request is not None and self._request.last), timeout=rest
            )
            self._changed.wait_for(lambda: self._quit or self._request is not None)
            if self._quit:
                return None
            self._working = True  # before the request is gone, so that in between nobody takes this for idle
            request, self._request = self._request, None
            return request

    def _reconstruct(self, request: Request) -> None:
        try:
            result = request.engine.result(request.state, request.parameters)
            if request.state.step == 0:  # gone back to the drawing, of which nothing has been found
                result = replace(result, contours=(), bridges=())
            tracked = self._tracker.track(result, thorough=request.last)
        except Exception as error:  # the thread's outermost frame: whatever happens must not end it
            sentence(error, "reconstructing contours")
            return
        self.results.put(Reconstruction(request.generation, result, tracked))
