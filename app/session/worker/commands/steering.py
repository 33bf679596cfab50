"""What goes down to the worker while a run exists and a person steers it."""

from __future__ import annotations

from dataclasses import dataclass

from app.model.document.document import Document
from app.session.exchange.messages import WentOn
from app.session.worker.command_context import Workshop
from app.session.worker.commands.run import Command
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.image.regions import Regions
from cpm_core.numerics.polyline import Position


@dataclass(frozen=True, slots=True)
class PlaceCharges(Command):
    """Let the particles feel these placed charges and no others from the next step on."""

    image_generation: int
    charges: tuple[PlacedCharge, ...]

    latest_only = True
    doing = "placing charges"

    def obey(self, shop: Workshop) -> None:
        """Place them."""
        if self.image_generation == shop.run.image_generation:
            _tell(shop, shop.run.place(self.charges))


@dataclass(frozen=True, slots=True)
class Limit(Command):
    """Hold the particles back by these regions of interest and barriers and no others from the next step on."""

    generation: int
    regions: Regions | None

    latest_only = True
    doing = "changing what limits the particles"

    def obey(self, shop: Workshop) -> None:
        """Hold them back."""
        if self.generation == shop.run.generation:
            _tell(shop, shop.run.limit(self.regions))


@dataclass(frozen=True, slots=True)
class Join(Command):
    """Add the particles of a document's starts to those of the run."""

    generation: int
    document: Document

    doing = "adding particles"

    def obey(self, shop: Workshop) -> None:
        """Add them."""
        if self.generation == shop.run.generation:
            _tell(shop, shop.run.join(self.document))


@dataclass(frozen=True, slots=True)
class Erase(Command):
    """Take away the particles near a path."""

    generation: int
    path: tuple[Position, ...]
    radius: float

    doing = "erasing particles"

    def obey(self, shop: Workshop) -> None:
        """Take them away."""
        if self.generation == shop.run.generation:
            shop.run.erase(self.path, self.radius)


def _tell(shop: Workshop, went_on: bool) -> None:
    if went_on:
        shop.report(WentOn(shop.run.generation))
