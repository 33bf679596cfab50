"""Work in pieces, so that the window answers between them."""

from __future__ import annotations

from collections import deque

from PySide6.QtCore import QObject, QTimer

from cpm_core.numerics.types import Callback


class Turns(QObject):
    """Does pieces of work in order, each in a turn of the event loop of its own; they end with the parent."""

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._waiting: deque[Callback] = deque()
        # A timer, since Qt calls what is queued within one turn in the same turn.
        self._timer = QTimer(self, interval=0)
        self._timer.timeout.connect(self._next)

    @property
    def idle(self) -> bool:
        """Whether nothing waits."""
        return not self._waiting

    def ask(self, work: Callback) -> None:
        """Do this after what waits already; what is the same piece of work and waits is done once."""
        if work not in self._waiting:
            self._waiting.append(work)
            self._timer.start()

    def finish(self) -> None:
        """Do now what waits."""
        while self._waiting:
            self._next()

    def stop(self) -> None:
        """Forget what waits."""
        self._waiting.clear()
        self._timer.stop()

    def _next(self) -> None:
        if not self._waiting:
            self._timer.stop()
            return
        self._waiting.popleft()()
