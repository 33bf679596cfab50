"""Garbage collection on the thread of the window only."""

from __future__ import annotations

import gc

from PySide6.QtCore import QObject, QTimer

_EVERY = 1000
"""Time between two checks [ms]."""


class GarbageCollector(QObject):
    """Collects reference cycles while a window is open, instead of the automatic collection of Python.

    Python collects on any thread that allocates memory. Widgets and graphics items are often part of reference cycles,
    and Qt crashes when they are destroyed on another thread than their own, such as that of the worker.
    """

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._automatic = gc.isenabled()
        self._timer = QTimer(self)
        self._timer.setInterval(_EVERY)
        self._timer.timeout.connect(self.collect)

    def start(self) -> None:
        """Replace the automatic collection."""
        self._automatic = gc.isenabled()
        gc.disable()
        self._timer.start()

    def stop(self) -> None:
        """Restore the automatic collection."""
        self._timer.stop()
        if self._automatic:
            gc.enable()

    @staticmethod
    def collect() -> None:
        """Collect each generation that Python would collect."""
        for generation, (count, threshold) in enumerate(zip(gc.get_count(), gc.get_threshold(), strict=True)):
            if count > threshold:
                gc.collect(generation)
