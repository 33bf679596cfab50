"""Changes of the interpreter by the window: where garbage is collected, and who receives unexpected errors."""

from __future__ import annotations

import gc
import logging
import sys
import threading
from types import TracebackType

from PySide6.QtCore import QObject, QTimer, Signal

from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import explain_failure
from cpm_app.session.session import Session
from cpm_app.session.session_messages import UNEXPECTED_CATEGORY

_COLLECTION_INTERVAL = 1000
"""Time between two checks [ms]."""


class GarbageCollector(QObject):
    """Collection of reference cycles on the thread of the window, in place of the automatic one.

    Python collects on any thread that allocates memory. Widgets and graphics items are often part of reference cycles,
    and Qt crashes if they are destroyed on another thread than their own, such as that of the worker.
    """

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._automatic = gc.isenabled()
        gc.disable()
        self._timer = QTimer(self, interval=_COLLECTION_INTERVAL)
        self._timer.timeout.connect(self.collect_due_generations)
        self._timer.start()

    def stop(self) -> None:
        """Restore the automatic collection."""
        self._timer.stop()
        if self._automatic:
            gc.enable()

    @staticmethod
    def collect_due_generations() -> None:
        """Collect each generation that Python would collect now."""
        for generation, (count, threshold) in enumerate(zip(gc.get_count(), gc.get_threshold(), strict=True)):
            if count > threshold:
                gc.collect(generation)


_log = logging.getLogger(__name__)


class UnexpectedErrors(QObject):
    """Handler of errors in slots and threads, which would otherwise go to a terminal that nobody sees."""

    error_happened = Signal(str)
    """An error occurred on any thread: a sentence about it."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self.error_happened.connect(self._show_error)
        self._previous_hooks = sys.excepthook, threading.excepthook
        sys.excepthook = self._on_exception
        threading.excepthook = lambda given: self._on_exception(given.exc_type, given.exc_value, given.exc_traceback)

    def restore_hooks(self) -> None:
        """Restore the previous handlers."""
        sys.excepthook, threading.excepthook = self._previous_hooks

    def _on_exception(
        self, kind: type[BaseException], error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if not isinstance(error, Exception):  # Ctrl+C and SystemExit
            if error is not None:
                self._previous_hooks[0](kind, error, trace)
            return
        _log.error("an error that nothing expects", exc_info=(kind, error, trace))
        self.error_happened.emit(explain_failure(error, tr("working")))

    def _show_error(self, message: str) -> None:
        self._session.messages.set_error(message, UNEXPECTED_CATEGORY)
