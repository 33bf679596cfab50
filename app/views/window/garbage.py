"""Garbage collection on the window's thread only."""

from __future__ import annotations

import gc

from PySide6.QtCore import QObject, QTimer

_EVERY = 1000
"""Time between two looks at how much there is [ms]."""


class GarbageCollector(QObject):
    """Collects what refers to itself while a window is open, and keeps Python from doing so by itself.

    Python collects on whichever thread happens to ask for memory. Widgets and what lies on a canvas are often part of
    such garbage, and Qt falls over when they are destroyed on a thread that is not theirs, such as the worker's.

    Parameters
    ----------
    parent : QObject
        The window.
    """

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._automatic = gc.isenabled()
        self._timer = QTimer(self)
        self._timer.setInterval(_EVERY)
        self._timer.timeout.connect(self.collect)

    def start(self) -> None:
        """From now on only here."""
        self._automatic = gc.isenabled()
        gc.disable()
        self._timer.start()

    def stop(self) -> None:
        """From now on as before."""
        self._timer.stop()
        if self._automatic:
            gc.enable()

    @staticmethod
    def collect() -> None:
        """Collect each generation that Python would collect, had it been let."""
        for generation, (count, threshold) in enumerate(zip(gc.get_count(), gc.get_threshold(), strict=True)):
            if count > threshold:
                gc.collect(generation)
