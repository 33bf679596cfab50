"""What goes down to the worker: commands, obeyed in order and never lost.

Each says itself what is done on the worker thread, and what is reported when that cannot be done. A new one is a class
here or in a module of its own; the worker does not know them.
"""

from __future__ import annotations

import gc
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from app.model.document.document import Document
from app.session.exchange.error_messages import sentence
from app.session.exchange.messages import Exported, Failed, Opened, Report, SeedsFound, Trouble, WarmedUp
from app.session.tasks.tasks import Task
from app.session.worker.command_context import Workshop
from cpm_core.contours.review import Mark, apply
from cpm_core.parameters import Parameters
from cpm_core.shapes.image_starts import NO_SEEDS


class Command:
    """Something to be done on the worker thread between two steps."""

    __slots__ = ()

    latest_only: ClassVar[bool] = False
    """Whether of many in a row, as while a slider is moved, only the last is worth the work."""

    doing: ClassVar[str] = "working"
    """What it does, as it stands after "while" in a sentence on trouble."""

    def obey(self, shop: Workshop) -> None:
        """Do it."""
        raise NotImplementedError

    def refusal(self, error: Exception) -> Report:
        """What is reported when it cannot be done."""
        return Trouble(sentence(error, self.doing))


@dataclass(frozen=True, eq=False, slots=True)
class Adopt(Command):
    """Change to an image that has been opened; see `app.session.tasks.opening`."""

    generation: int
    opened: Opened

    doing = "changing to another image"

    def obey(self, shop: Workshop) -> None:
        """Change to it."""
        shop.run.use(self.generation, self.opened.engine, self.opened.parameters)


@dataclass(frozen=True, slots=True)
class Start(Command):
    """Begin a run from the drawing of a document, if the image it was drawn on is still the one in use."""

    generation: int
    image_generation: int
    document: Document

    def obey(self, shop: Workshop) -> None:
        """Begin it; nobody moves yet."""
        if self.image_generation == shop.run.image_generation:
            shop.run.start(self.generation, self.document)

    def refusal(self, error: Exception) -> Report:
        """There is no run."""
        return Failed(self.generation, sentence(error, "starting"))


@dataclass(frozen=True, slots=True)
class Go(Command):
    """Step until told otherwise, or `steps` times."""

    generation: int
    steps: int | None = None

    def obey(self, shop: Workshop) -> None:
        """Set the run going."""
        if self.generation == shop.run.generation:
            shop.run.go(self.steps)


@dataclass(frozen=True, slots=True)
class Halt(Command):
    """Stop stepping and keep the particles."""

    def obey(self, shop: Workshop) -> None:
        """Stop."""
        shop.run.halt()


@dataclass(frozen=True, slots=True)
class Discard(Command):
    """Stop stepping and forget the particles."""

    generation: int

    def obey(self, shop: Workshop) -> None:
        """Forget them."""
        shop.run.discard(self.generation)


@dataclass(frozen=True, slots=True)
class SetParameters(Command):
    """Use these parameters from the next step on."""

    parameters: Parameters

    doing = "changing parameters"

    def obey(self, shop: Workshop) -> None:
        """Use them."""
        shop.run.set_parameters(self.parameters)


@dataclass(frozen=True, slots=True)
class SetPace(Command):
    """Take at most so many steps a second; None for no limit."""

    steps_per_second: float | None

    def obey(self, shop: Workshop) -> None:
        """Keep to it."""
        shop.run.pacer.limit(self.steps_per_second)


@dataclass(frozen=True, slots=True)
class SetOverlays(Command):
    """Keep the overlays of these names up to date for showing, and no others; see `app.session.worker.overlays`."""

    names: frozenset[str]

    doing = "preparing what lies over the image"

    def obey(self, shop: Workshop) -> None:
        """Send them up now and whenever they change."""
        shop.run.set_overlays(self.names)


@dataclass(frozen=True, slots=True)
class FindSeeds(Command):
    """Find the positions of a document's starts that depend on the image, for showing them."""

    image_generation: int
    document: Document

    latest_only = True

    def obey(self, shop: Workshop) -> None:
        """Find them."""
        if self.image_generation == shop.run.image_generation:
            shop.report(SeedsFound(self.image_generation, shop.run.seeds_for(self.document)))

    def refusal(self, error: Exception) -> Report:
        """There are none."""
        return SeedsFound(self.image_generation, NO_SEEDS, sentence(error, "looking for places to start from"))


@dataclass(frozen=True, slots=True)
class Export(Command):
    """Reconstruct and write what has not been rejected to a file whose suffix tells the format, unless given up."""

    path: Path
    task: Task
    marks: tuple[Mark, ...] = ()

    def obey(self, shop: Workshop) -> None:
        """Write it."""
        try:
            result = None if self.task.cancelled else shop.run.result()
            if result is not None and not self.task.cancelled:
                shop.core.export(apply(result, self.marks), self.path)
                shop.report(Exported(self.path))
        finally:
            self.task.end()

    def refusal(self, error: Exception) -> Report:
        """Nothing has been written."""
        return Trouble(sentence(error, f"writing {self.path.name}"))


@dataclass(frozen=True, slots=True)
class WarmUp(Command):
    """Compile or load the kernels, so that the first step does not wait for them."""

    doing = "preparing"

    def obey(self, shop: Workshop) -> None:
        """Compile or load them."""
        shop.core.warm_up(shop.closing)
        # All that is loaded by now stays; looking through it for garbage would hold up the window for frames, even a
        # single time.
        gc.freeze()
        shop.report(WarmedUp())


@dataclass(frozen=True, slots=True)
class Quit(Command):
    """End the thread."""
