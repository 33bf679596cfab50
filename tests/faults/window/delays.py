"""Delays in the threads of the program, so that whatever can overtake something else does so."""

from __future__ import annotations

import random
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any
from unittest import mock

from cpm_app.session.storage import session_file
from cpm_app.session.storage.recovery import Journal
from cpm_app.session.tasks import opening
from cpm_app.session.worker.reconstruction import Reconstructor
from cpm_app.session.worker.run import Run
from cpm_app.views.features import offers

from cpm_core.segmentation.engine import Engine

LENGTHS = (0.0, 0.0, 0.0, 0.0005, 0.002, 0.008)
"""Delays before and after a piece of work, each as likely as another [s]."""

PLACES: tuple[tuple[Any, str], ...] = (
    (Run, "set_parameters"),
    (Run, "take_steps"),
    (Run, "take_step"),
    (Reconstructor, "_handle_request"),
    (Engine, "result"),
    (Run, "wait_for_reconstruction"),
    (opening, "prepare_image"),
    (offers, "guess_kind"),
    (Journal, "_write_journal"),
    (session_file, "save_session"),
)
"""What is delayed: the work of the engine, the reconstruction, opening, saving and the journal."""


class Delays:
    """Delays chosen from a seed; `count` is the number of those that were injected."""

    def __init__(self, seed: object) -> None:
        self.count = 0
        self._choice = random.Random(str(seed))
        self._lock = threading.Lock()

    @contextmanager
    def injected(self) -> Iterator[Delays]:
        """Delay the work in all places until the end of a block."""
        with ExitStack() as stack:
            for owner, name in PLACES:
                stack.enter_context(mock.patch.object(owner, name, self._slowed(getattr(owner, name))))
            yield self

    def _slowed(self, work: Callable[..., Any]) -> Callable[..., Any]:
        def slow(*arguments: Any, **named: Any) -> Any:
            self._delay()
            try:
                return work(*arguments, **named)
            finally:
                self._delay()

        return slow

    def _delay(self) -> None:
        with self._lock:
            seconds = self._choice.choice(LENGTHS)
            self.count += seconds > 0
        if seconds:
            time.sleep(seconds)
