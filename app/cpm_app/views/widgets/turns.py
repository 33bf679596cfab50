"""Work in small pieces, between which the window stays responsive."""

from __future__ import annotations

from collections import deque

from PySide6.QtCore import QObject, QTimer

from cpm_core.numerics.types import Callback


class Turns(QObject):
    """Queue of work that is done in order, one piece per turn of the event loop, as long as the parent exists."""

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._waiting: deque[Callback] = deque()
        # A timer, since Qt would run calls that are queued in one turn in this same turn.
        self._timer = QTimer(self, interval=0)
        self._timer.timeout.connect(self._do_next)

    @property
    def is_idle(self) -> bool:
        """Whether no work is waiting."""
        return not self._waiting

    def schedule_work(self, work: Callback) -> None:
        """Add a piece of work to the end of the queue, unless it is waiting already."""
        if work not in self._waiting:
            self._waiting.append(work)
            self._timer.start()

    def finish(self) -> None:
        """Do all waiting work now."""
        while self._waiting:
            self._do_next()

    def stop(self) -> None:
        """Drop all waiting work."""
        self._waiting.clear()
        self._timer.stop()

    def _do_next(self) -> None:
        if not self._waiting:
            self._timer.stop()
            return
        self._waiting.popleft()()
