"""What commands work with on the worker thread."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from app.session.core_functions import Core
from app.session.exchange.messages import Report
from app.session.worker.run import Run


@dataclass(frozen=True, eq=False, slots=True)
class CommandContext:
    """What belongs to the worker thread; no other thread touches it.

    Attributes
    ----------
    core : Core
        The core's functions.
    run : Run
        Method, state and parameters.
    report : callable
        Sends a report up.
    closing : callable
        Whether the program is about to end, so that nothing long is worth while.
    """

    core: Core
    run: Run
    report: Callable[[Report], None]
    closing: Callable[[], bool]
