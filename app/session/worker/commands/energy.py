"""Saying that somebody looks at what is not always worked out."""

from __future__ import annotations

from dataclasses import dataclass

from app.session.worker.command_context import Workshop
from app.session.worker.commands.run import Command


@dataclass(frozen=True, slots=True)
class WatchEnergy(Command):
    """Work out the potential energy even where it takes long, or no more."""

    wanted: bool

    def obey(self, shop: Workshop) -> None:
        """Set the gauge."""
        shop.run.gauge.wanted = self.wanted
