"""The parts that try damaged and random input, by name."""

from __future__ import annotations

from types import ModuleType

from ..report import Budget, Part, Report
from . import calls, command_line, files, images, sessions, volumes
from .trials import at_length


def _part(module: ModuleType) -> Part:
    """A part that runs the trials of a module."""

    def run(budget: Budget) -> Report:
        return at_length(module.trial, budget, getattr(module, "prepare", None))

    return run


PARTS: dict[str, tuple[str, Part]] = {
    "files": ("damaged files of every kind, read", files.part),
    "sessions": ("damaged sessions, read and run", _part(sessions)),
    "calls": ("calls of the library, with values of right and wrong kinds", _part(calls)),
    "images": ("images, starts and parameters against the laws of the model", _part(images)),
    "volumes": ("volumes, starts and parameters against the laws of the model", _part(volumes)),
    "command_line": ("lists of arguments of commands", _part(command_line)),
}
