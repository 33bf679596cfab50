"""Asking for the energy where it is not always worked out."""

from __future__ import annotations

from dataclasses import dataclass

from app.session.worker.command_context import CommandContext
from app.session.worker.commands.run import Command


@dataclass(frozen=True, slots=True)
class WatchEnergy(Command):
    """Work out the potential energy even where it takes long, or no more."""

    wanted: bool

    def execute(self, context: CommandContext) -> None:
        """Set the gauge."""
        context.run.energy_sampler.wanted = self.wanted
