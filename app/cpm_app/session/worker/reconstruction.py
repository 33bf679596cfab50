"""Reconstruction of the newest particles, on a separate thread at a slower pace."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from cpm_app.model.text.language import tr
from cpm_app.session.exchange.mailbox import Mailbox
from cpm_app.session.exchange.messages import Reconstruction, ReconstructionFailed, explain_failure
from cpm_core import Method, Parameters, Result, Skeleton
from cpm_core.numerics.types import record
from cpm_core.segmentation import MethodState

_SHORTEST_PAUSE = 0.15
"""Shortest pause between two reconstructions during a run [s]."""

_REST_PER_WORK = 5.0
"""Ratio of the pause after a reconstruction to the time that it took."""

_NICE_INCREMENT = 5
"""Lower priority of this thread than of the ones that step and draw, in units of Unix niceness."""

_CHECK_INTERVAL = 0.05
"""Time between two checks whether a reconstruction is still wanted [s]."""


@record
class ReconstructionRequest:
    """A state to reconstruct contours from; if `last`, none follows soon and there is no pause before it."""

    generation: int
    method: Method[Any]
    state: MethodState
    parameters: Parameters
    last: bool

    def reconstruct(self) -> Result | Skeleton:
        """Reconstruct the contours of the state; the first state has none."""
        result = self.method.result(self.state, self.parameters)
        if self.state.step == 0 and isinstance(result, Result):  # back at the initialization
            result = replace(result, contours=(), bridges=(), surface=None)
        return result


class Reconstructor:
    """Reconstructs the newest request on a thread of its own and leaves the contours in `results`."""

    def __init__(self) -> None:
        self.results: Mailbox[Reconstruction | ReconstructionFailed] = Mailbox()
        self._changed = threading.Condition()
        self._requests: Mailbox[ReconstructionRequest] = Mailbox()
        self._latest: Reconstruction | ReconstructionFailed | None = None
        self._made: tuple[tuple[object, ...], Result | Skeleton] | None = None
        """What the newest contours were made of, and these contours."""
        self._working = False
        self._quit = False
        self._thread = threading.Thread(target=self._run_loop, name="cpm-reconstruction", daemon=True)
        self._thread.start()

    @property
    def idle(self) -> bool:
        """Whether there is no work; read in every display frame, and therefore without the lock."""
        return not self._requests and not self._working

    def submit(self, request: ReconstructionRequest) -> None:
        """Submit a request in place of one that is still waiting."""
        with self._changed:
            self._requests.put(request)
            self._changed.notify_all()

    def drop_waiting(self) -> None:
        """Drop the waiting request."""
        with self._changed:
            self._requests.take()

    def wait_for_latest(self, generation: int, is_wanted: Callable[[], bool]) -> Reconstruction | None:
        """Wait for the contours of the newest request of a run and return them.

        None if there are none, or if `is_wanted`, which is called while they are being made, returns False. Raises
        ValueError if they could not be made, because the previous ones belong to another state.
        """
        with self._changed:
            waiting = self._requests.newest
            if waiting is not None and not waiting.last:  # no pause before this one
                self._requests.put(replace(waiting, last=True))
                self._changed.notify_all()
            while not (self.idle or self._quit):
                if not is_wanted():
                    return None
                self._changed.wait(_CHECK_INTERVAL)
            found = self._latest
            if found is None or found.generation != generation:
                return None
            if isinstance(found, ReconstructionFailed):
                raise ValueError(found.message)
            return found

    def close(self) -> None:
        """End the thread and wait for it."""
        with self._changed:
            self._quit = True
            self._changed.notify_all()
        self._thread.join()

    def _run_loop(self) -> None:
        if sys.platform == "linux":  # 25,000 particles take seconds: stepping and drawing go first on few cores
            thread = threading.get_native_id()
            os.setpriority(os.PRIO_PROCESS, thread, min(os.getpriority(os.PRIO_PROCESS, thread) + _NICE_INCREMENT, 19))
        rest = 0.0
        while (request := self._wait_for_request(rest)) is not None:
            began = time.perf_counter()
            self._handle_request(request)
            rest = max(_SHORTEST_PAUSE, _REST_PER_WORK * (time.perf_counter() - began))
            with self._changed:
                self._working = False
                self._changed.notify_all()

    def _wait_for_request(self, rest: float) -> ReconstructionRequest | None:
        with self._changed:
            self._changed.wait_for(lambda: self._quit or getattr(self._requests.newest, "last", False), timeout=rest)
            self._changed.wait_for(lambda: self._quit or bool(self._requests))
            if self._quit:
                return None
            self._working = True  # set before the request is taken, so that `idle` is never true in between
            return self._requests.take()

    def _handle_request(self, request: ReconstructionRequest) -> None:
        found: Reconstruction | ReconstructionFailed
        try:
            made_of = (request.method, request.state, request.parameters)
            if self._made is None or self._made[0] != made_of:
                self._made = made_of, request.reconstruct()
            found = Reconstruction.from_result(request.generation, self._made[1])
        except Exception as error:  # no error may end the thread
            found = ReconstructionFailed(request.generation, explain_failure(error, tr("reconstructing contours")))
        self._latest = found
        self.results.put(found)
