"""Errors in the middle of the work of other threads: any call of a function of the core can raise one."""

from __future__ import annotations

import functools
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass
from types import FunctionType
from typing import Any

from cpm_core.segmentation.engine import Engine

_METHODS = ("start", "step", "result", "forces", "energies")


@dataclass
class Raising:
    """Counts calls of functions of the core by other threads than the main one, and lets one of them raise an error."""

    number: int = 0
    error: Exception | None = None
    calls: int = 0

    def arm(self, number: int, error: Exception | None) -> None:
        """Count from the beginning, and let the call with this number raise an error."""
        self.calls, self.number, self.error = 0, number, error

    @property
    def raised(self) -> bool:
        """Whether the error has been raised."""
        return 0 < self.number <= self.calls

    def place(self) -> None:
        """Put itself in front of all functions of the core, wherever they are called by name."""
        known: dict[FunctionType, Callable[..., Any]] = {}
        for name, module in list(sys.modules.items()):
            if name.startswith(("cpm_core.", "cpm_app.session.")) and ".cli" not in name:
                for attribute, value in list(vars(module).items()):
                    if isinstance(value, FunctionType) and value.__module__.startswith("cpm_core."):
                        setattr(module, attribute, known.setdefault(value, self._before(value)))
        for name in _METHODS:
            setattr(Engine, name, self._before(vars(Engine)[name]))

    def _before(self, function: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(function)
        def called(*arguments: Any, **named: Any) -> Any:
            if threading.current_thread() is not threading.main_thread():
                self.calls += 1
                if self.calls == self.number and self.error is not None:
                    raise self.error
            return function(*arguments, **named)

        return called
