"""All that goes wrong in a window without stopping it: exceptions in slots and threads, words of Qt, logged errors."""

from __future__ import annotations

import logging
import sys
import threading
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Any

from PySide6.QtCore import QMessageLogContext, QTimer, QtMsgType, qInstallMessageHandler

from ..clock import now

ANSWERS_WITHIN = 10.0
"""Longest time that the window may be held [s]."""

HARMLESS = ("This plugin does not support", "propagateSizeHints")
"""Words of Qt on what the platform without a screen cannot do."""

_LOOKS_EVERY, _ANSWERS_EVERY = 0.5, 0.1
"""Times after which it looks whether the window has answered, and in which a window that is free answers [s]."""


class Watch(logging.Handler):
    """Collects troubles, one text each, while it is in use."""

    def __init__(self) -> None:
        super().__init__(logging.ERROR)
        self.troubles: list[str] = []
        self._window = threading.current_thread()
        self._beat = now()
        self._over = threading.Event()

    def _heard(self) -> None:
        """The window has answered."""
        self._beat = now()

    @contextmanager
    def kept(self) -> Iterator[Watch]:
        """Collect until the end of a block."""
        hooks = sys.excepthook, threading.excepthook, sys.unraisablehook
        sys.excepthook, sys.unraisablehook = self._raised, self._unraised
        threading.excepthook = lambda args: self._raised(args.exc_type, args.exc_value, args.exc_traceback)
        before, root = qInstallMessageHandler(self._said_by_qt), logging.getLogger()
        root.addHandler(self)
        guard = threading.Thread(target=self._guard, name="watch", daemon=True)
        answers = QTimer(interval=round(1000 * _ANSWERS_EVERY))
        answers.timeout.connect(self._heard)
        answers.start()
        self._heard()
        guard.start()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                yield self
        finally:
            answers.stop()
            self._over.set()
            guard.join()
            root.removeHandler(self)
            qInstallMessageHandler(before)
            sys.excepthook, threading.excepthook, sys.unraisablehook = hooks

    def emit(self, record: logging.LogRecord) -> None:
        """Take what is logged as an error: no trouble of a user's making is."""
        self.troubles.append(self.format(record))

    def _raised(self, kind: type[BaseException], error: BaseException | None, trace: TracebackType | None) -> None:
        self.troubles.append("".join(traceback.format_exception(kind, error, trace)))

    def _unraised(self, what: Any) -> None:
        self.troubles.append(f"{what.err_msg} {what.object!r}: {what.exc_value!r}")

    def _said_by_qt(self, kind: QtMsgType, context: QMessageLogContext, message: str) -> None:
        if kind != QtMsgType.QtDebugMsg and not any(words in message for words in HARMLESS):
            self.troubles.append(f"Qt: {message}")

    def _guard(self) -> None:
        """Record where the window is held for too long, once each time."""
        told = 0.0
        while not self._over.wait(_LOOKS_EVERY):
            held = now() - self._beat
            if held > ANSWERS_WITHIN and told != self._beat:
                told = self._beat
                frame = sys._current_frames().get(self._window.ident or 0)
                where = "".join(traceback.format_stack(frame)[-12:]) if frame is not None else "nowhere"
                self.troubles.append(f"The window has not answered for {held:.1f} s:\n{where}")
