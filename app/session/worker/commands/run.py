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
from app.session.exchange.messages import (
    CommandFailed,
    Exported,
    Opened,
    Reconstruction,
    Report,
    RunFailed,
    SeedsFound,
    WarmedUp,
)
from app.session.tasks.tasks import Task
from app.session.worker.command_context import CommandContext
from cpm_core.contours.result import Result
from cpm_core.contours.review import Mark, apply
from cpm_core.formats import encoded
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.parameters import Parameters
from cpm_core.shapes.image_starts import NO_SEEDS


class Command:
    """Something to be done on the worker thread between two steps."""

    __slots__ = ()

    latest_only: ClassVar[bool] = False
    """Whether of many in a row, as while a slider is moved, only the last is worth the work."""

    activity: ClassVar[str] = "working"
    """What it does, as it stands after "while" in a sentence on trouble."""

    def execute(self, context: CommandContext) -> None:
        """Do it."""
        raise NotImplementedError

    def failure_report(self, error: Exception) -> Report:
        """What is reported when it cannot be done."""
        return CommandFailed(sentence(error, self.activity))


@dataclass(frozen=True, eq=False, slots=True)
class Adopt(Command):
    """Change to an image that has been opened; see `app.session.tasks.opening`."""

    generation: int
    opened: Opened

    activity = "changing to another image"

    def execute(self, context: CommandContext) -> None:
        """Change to it."""
        context.run.use(self.generation, self.opened.method, self.opened.parameters)


@dataclass(frozen=True, slots=True)
class Start(Command):
    """Begin a run from the drawing of a document, if the image it was drawn on is still the one in use."""

    generation: int
    image_generation: int
    document: Document

    def execute(self, context: CommandContext) -> None:
        """Begin it; nothing moves yet."""
        if self.image_generation == context.run.image_generation:
            context.run.start(self.generation, self.document)

    def failure_report(self, error: Exception) -> Report:
        """There is no run."""
        return RunFailed(self.generation, sentence(error, "starting"))


@dataclass(frozen=True, slots=True)
class Go(Command):
    """Step until told otherwise, or `steps` times."""

    generation: int
    steps: int | None = None

    def execute(self, context: CommandContext) -> None:
        """Set the run going."""
        if self.generation == context.run.generation:
            context.run.go(self.steps)


@dataclass(frozen=True, slots=True)
class Halt(Command):
    """Stop stepping and keep the particles."""

    def execute(self, context: CommandContext) -> None:
        """Stop."""
        context.run.halt()


@dataclass(frozen=True, slots=True)
class Discard(Command):
    """Stop stepping and forget the particles."""

    generation: int

    def execute(self, context: CommandContext) -> None:
        """Forget them."""
        context.run.discard(self.generation)


@dataclass(frozen=True, slots=True)
class SetParameters(Command):
    """Use these parameters from the next step on."""

    parameters: Parameters

    activity = "changing parameters"

    def execute(self, context: CommandContext) -> None:
        """Use them."""
        context.run.set_parameters(self.parameters)


@dataclass(frozen=True, slots=True)
class SetPace(Command):
    """Take at most so many steps a second; None for no limit."""

    steps_per_second: float | None

    def execute(self, context: CommandContext) -> None:
        """Keep to it."""
        context.run.pacer.limit(self.steps_per_second)


@dataclass(frozen=True, slots=True)
class SetOverlays(Command):
    """Keep the overlays of these names up to date for showing, and no others; see `app.session.worker.overlays`."""

    names: frozenset[str]

    activity = "preparing what lies over the image"

    def execute(self, context: CommandContext) -> None:
        """Send them up now and whenever they change."""
        context.run.set_overlays(self.names)


@dataclass(frozen=True, slots=True)
class FindSeeds(Command):
    """Find the positions of a document's starts that depend on the image, for showing them."""

    image_generation: int
    document: Document

    latest_only = True

    def execute(self, context: CommandContext) -> None:
        """Find them."""
        if self.image_generation == context.run.image_generation:
            context.report(SeedsFound(self.image_generation, context.run.seeds_for(self.document)))

    def failure_report(self, error: Exception) -> Report:
        """There are none."""
        return SeedsFound(self.image_generation, NO_SEEDS, sentence(error, "looking for places to start from"))


@dataclass(frozen=True, eq=False, slots=True)
class Deliver(Command):
    """Give the contours that are seen, without those that have been rejected, to a file or to the clipboard.

    Attributes
    ----------
    task : Task
        By which it can be given up.
    shown : Reconstruction or None
        The contours that the window shows, which count while the run goes on; of a run that is held those of its very
        last state count, which the window shows as soon as they are made.
    marks : tuple of Mark
        What has been said about them.
    """

    task: Task
    shown: Reconstruction | None = None
    marks: tuple[Mark, ...] = ()

    def execute(self, context: CommandContext) -> None:
        """Deliver them, unless it has been given up."""

        def wanted() -> bool:
            return not (self.task.over or context.closing())

        try:
            found = context.run.reconstruction(self.shown, wanted) if wanted() else None
            if found is not None and wanted():
                result = found.result
                self.deliver(context, result if isinstance(result, Skeleton) else apply(result, self.marks))
        finally:
            self.task.end()

    def deliver(self, context: CommandContext, result: Result | Skeleton) -> None:
        """Write them."""
        raise NotImplementedError


@dataclass(frozen=True, eq=False, slots=True)
class Export(Deliver):
    """Write the contours to a file whose suffix tells the format."""

    path: Path = Path()

    def deliver(self, context: CommandContext, result: Result | Skeleton) -> None:
        """Write them."""
        context.core.export(result, self.path)
        context.report(Exported(self.path))

    def failure_report(self, error: Exception) -> Report:
        """Nothing has been written."""
        return CommandFailed(sentence(error, f"writing {self.path.name}"))


@dataclass(frozen=True, slots=True)
class Copied(Report):
    """What is to be put on the clipboard, as a file of this suffix would hold it."""

    suffix: str
    content: bytes


@dataclass(frozen=True, eq=False, slots=True)
class Copy(Deliver):
    """Make the contours ready for the clipboard, as a file of this suffix would hold them."""

    suffix: str = ""

    activity = "copying contours"

    def deliver(self, context: CommandContext, result: Result | Skeleton) -> None:
        """Make them ready."""
        context.report(Copied(self.suffix, encoded(result, self.suffix)))


@dataclass(frozen=True, slots=True)
class WarmUp(Command):
    """Compile or load the kernels, so that the first step does not wait for them."""

    activity = "preparing"

    def execute(self, context: CommandContext) -> None:
        """Compile or load them."""
        context.core.warm_up(context.closing)
        # All that is loaded by now stays; looking through it for garbage would hold up the window for frames, even a
        # single time.
        gc.freeze()
        context.report(WarmedUp())


@dataclass(frozen=True, slots=True)
class Quit(Command):
    """End the thread."""
