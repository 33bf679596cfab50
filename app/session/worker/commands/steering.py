"""What goes down to the worker while a run exists and a person steers it."""

from __future__ import annotations

from dataclasses import dataclass

from app.model.document.document import Document
from app.session.exchange.messages import WentOn
from app.session.worker.command_context import CommandContext
from app.session.worker.commands.run import Command
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.image.regions import Regions
from cpm_core.numerics.types import Position


@dataclass(frozen=True, slots=True)
class PlaceCharges(Command):
    """Let the particles feel these placed charges and no others from the next step on."""

    image_generation: int
    charges: tuple[PlacedCharge, ...]

    latest_only = True
    activity = "placing charges"

    def execute(self, context: CommandContext) -> None:
        """Place them."""
        if self.image_generation == context.run.image_generation:
            _tell(context, context.run.place(self.charges))


@dataclass(frozen=True, slots=True)
class Limit(Command):
    """Hold the particles back by these regions of interest and barriers and no others from the next step on."""

    generation: int
    regions: Regions | None

    latest_only = True
    activity = "changing what limits the particles"

    def execute(self, context: CommandContext) -> None:
        """Hold them back."""
        if self.generation == context.run.generation:
            _tell(context, context.run.limit(self.regions))


@dataclass(frozen=True, slots=True)
class Join(Command):
    """Add the particles of a document's starts to those of the run."""

    generation: int
    document: Document

    activity = "adding particles"

    def execute(self, context: CommandContext) -> None:
        """Add them."""
        if self.generation == context.run.generation:
            _tell(context, context.run.join(self.document))


@dataclass(frozen=True, slots=True)
class Erase(Command):
    """Take away the particles near a path."""

    generation: int
    path: tuple[Position, ...]
    radius: float

    activity = "erasing particles"

    def execute(self, context: CommandContext) -> None:
        """Take them away."""
        if self.generation == context.run.generation:
            context.run.erase(self.path, self.radius)


def _tell(context: CommandContext, went_on: bool) -> None:
    if went_on:
        context.report(WentOn(context.run.generation))
