"""Errors that no other part expects, on any thread: logged in full, and said in the window."""

from __future__ import annotations

import logging
import sys
import threading
from types import TracebackType

from PySide6.QtCore import QObject, Signal

from app.model.text.language import tr
from app.session.exchange.error_messages import sentence
from app.session.session import Session
from app.session.signals import UNEXPECTED

_log = logging.getLogger(__name__)


class UnexpectedErrors(QObject):
    """Takes the errors of slots and threads that would otherwise be written to a terminal that nobody sees."""

    happened = Signal(str)
    """A sentence on an error, from any thread."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._before = sys.excepthook, threading.excepthook
        self.happened.connect(self._say)

    def watch(self) -> None:
        """Take errors from now on."""
        self._before = sys.excepthook, threading.excepthook
        sys.excepthook = self._take
        threading.excepthook = lambda given: self._take(given.exc_type, given.exc_value, given.exc_traceback)

    def end(self) -> None:
        """Take errors no longer."""
        sys.excepthook, threading.excepthook = self._before

    def _take(self, kind: type[BaseException], error: BaseException | None, trace: TracebackType | None) -> None:
        if not isinstance(error, Exception):  # Ctrl+C, and the end of the program
            if error is not None:
                self._before[0](kind, error, trace)
            return
        _log.error("an error that nothing expects", exc_info=(kind, error, trace))
        self.happened.emit(sentence(error, tr("working")))

    def _say(self, trouble: str) -> None:
        self._session.trouble(trouble, UNEXPECTED)
