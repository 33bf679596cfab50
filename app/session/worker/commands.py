"""Commands to the worker: executed in order between two steps, and never lost.

A command says what is done on the worker thread, and what is reported when that fails. A new kind is a class here or in
another module; the worker thread does not know the kinds.
"""

from __future__ import annotations

import gc
from collections import Counter
from collections.abc import Callable, Hashable, Mapping
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any, ClassVar, Concatenate, ParamSpec

from app.model.document.document import Document, ImageReference
from app.model.export import ExportOrder, chosen, closed, summarize
from app.model.text.language import tr
from app.session.exchange.core_functions import Core
from app.session.exchange.messages import (
    CommandFailed,
    Compiling,
    Exported,
    Reconstruction,
    Report,
    RunFailed,
    RunsKept,
    SeedsFound,
    WarmedUp,
    WentOn,
    sentence,
)
from app.session.tasks.tasks import Task
from app.session.timeline.plain_runs import Plain, RunsWriter, runs_from_plain
from app.session.worker.run import Run
from cpm_core import Image, Result, Skeleton, encoded
from cpm_core.formats import DRAWN, IN_SPACE
from cpm_core.shapes import NO_SEEDS

P = ParamSpec("P")

_CHANGING_RUNS = (Run.discard, Run.rename_branch, Run.drop_branch, Run.set_timeline_budget)


@dataclass(frozen=True, eq=False, slots=True)
class CommandContext:
    """What commands work with; only the worker thread touches it.

    Attributes
    ----------
    core : Core
        The core's functions.
    run : Run
        Method, state and parameters.
    report : callable
        Sends a report to the window.
    closing : callable
        Whether the program is about to end, so that long work is no longer useful.
    """

    core: Core
    run: Run
    report: Callable[[Report], None]
    closing: Callable[[], bool]


class Command:
    """Work for the worker thread between two steps."""

    __slots__ = ()

    latest_only: ClassVar[bool] = False
    """Whether only the last of many in a row is worth the work, as while a slider is moved."""

    activity: ClassVar[str] = tr("working")
    """What it does, as it follows "while" in an error message."""

    topic: ClassVar[str] = ""
    """The kind of attempt that its error messages belong to; see `app.session.signals`."""

    @property
    def kind(self) -> object:
        """Only the newest posted command of a kind is executed; None where each one is."""
        return type(self) if self.latest_only else None

    def execute(self, context: CommandContext) -> None:
        """Do the work."""
        raise NotImplementedError

    def failure_report(self, error: Exception) -> Report:
        """What is reported when the work fails."""
        return CommandFailed(sentence(error, self.activity), self.topic)


class RunCall(Command):
    """Calls a method of the run, unless the run has been replaced by then.

    A method that returns True lets a run go on that had ended; this is reported.

    Parameters
    ----------
    generation : int or None
        The run; None for any.
    method : callable
        Method of `Run`.
    *arguments
        Its arguments.
    """

    __slots__ = ("_call", "generation", "method")

    def __init__(
        self,
        generation: int | None,
        method: Callable[Concatenate[Run, P], bool | None],
        *arguments: P.args,
        **named: P.kwargs,
    ) -> None:
        self.generation = generation
        self.method = method
        self._call: Callable[[Run], bool | None] = lambda run: method(run, *arguments, **named)

    @property
    def kind(self) -> object:
        """Of placed charges, regions and edits by hand only the newest count."""
        return self.method if self.method in (Run.place, Run.limit, Run.edit_by_hand) else None

    def execute(self, context: CommandContext) -> None:
        """Call the method."""
        run = context.run
        if self.generation not in (None, run.generation):
            return
        if self._call(run):
            context.report(WentOn(run.generation))
        if run.state is None and self.method in _CHANGING_RUNS:
            context.report(RunsKept(run.generation, run.timeline.outline))

    def failure_report(self, error: Exception) -> Report:
        """Nothing has changed."""
        return CommandFailed(sentence(error, tr("changing the run")))


@dataclass(frozen=True, slots=True)
class Start(Command):
    """Start a run from a document, if its image is still the current one."""

    generation: int
    image_generation: int
    document: Document

    def execute(self, context: CommandContext) -> None:
        """Start the run, without a step."""
        if self.image_generation == context.run.image_generation:
            context.run.start(self.generation, self.document)

    def failure_report(self, error: Exception) -> Report:
        """There is no run."""
        return RunFailed(self.generation, sentence(error, tr("starting")))


@dataclass(frozen=True, slots=True)
class FindSeeds(Command):
    """Find the seeds of a document that depend on the image, for showing them."""

    image_generation: int
    document: Document

    latest_only = True

    def execute(self, context: CommandContext) -> None:
        """Find the seeds."""
        if self.image_generation == context.run.image_generation:
            context.report(SeedsFound(self.image_generation, context.run.seeds_for(self.document)))

    def failure_report(self, error: Exception) -> Report:
        """There are none."""
        return SeedsFound(self.image_generation, NO_SEEDS, sentence(error, tr("looking for places to start from")))


@dataclass(frozen=True, slots=True)
class Copied(Report):
    """Content for the clipboard, as a file with this suffix would hold it."""

    suffix: str
    content: bytes


@dataclass(frozen=True, eq=False, slots=True)
class Export(Command):
    """Write contours to a file, whose suffix gives the format; without a folder, prepare them for the clipboard.

    During a run these are the contours `shown` in the window; of a paused run they are those of its last state, which
    the window shows as soon as they are made.
    """

    task: Task
    shown: Reconstruction | None
    document: Document
    suffix: str
    path: Path | None = None
    order: ExportOrder = field(default_factory=ExportOrder)

    def execute(self, context: CommandContext) -> None:
        """Write the contours, unless the task has been cancelled."""

        def wanted() -> bool:
            return not (self.task.over or context.closing())

        run, needs_run = context.run, self.order.source != "objects"
        try:
            found = run.reconstruction(self.shown, wanted) if wanted() and needs_run else None
            if not wanted() or (needs_run and found is None):
                return
            image = None if run.method is None else run.method.image
            result = None if found is None else run.with_provenance(found.result)
            ordered = chosen(result, self.document, self.order, image)
            if self.path is None:
                context.report(Copied(self.suffix, encoded(ordered, self.suffix)))
            else:
                self._write(context, ordered, image, self.path)
        finally:
            self.task.end()

    def _write(self, context: CommandContext, result: Result | Skeleton, image: Image | None, path: Path) -> None:
        """Write the contours, and report what the file holds and what not."""
        whole = result
        if image is not None:
            whole = closed(result, self.order, image, context.run.parameters)
            if self.suffix in DRAWN and whole.image is None:
                whole = replace(whole, image=image)
        settings: dict[str, Any] = {"outlines": True} if self.order.outlines else {}
        if self.suffix in IN_SPACE:
            settings["space"] = self.order.space
        if self.document.image is not None:
            settings["image"] = self.document.image.path
        context.core.export(whole, path, **settings)
        context.report(Exported(path, summarize(result, whole, self.suffix, self.order)))

    def failure_report(self, error: Exception) -> Report:
        """Nothing has been written."""
        activity = tr("copying contours")
        if self.path is not None:
            activity = tr("writing {name}").format(name=self.path.name)
        return CommandFailed(sentence(error, activity), "exporting")


@dataclass(frozen=True, slots=True)
class WarmUp(Command):
    """Compile or load the kernels, of images or of volumes, so that the first step does not wait for them."""

    volumes: bool = False

    activity = tr("preparing")

    def execute(self, context: CommandContext) -> None:
        """Compile or load them."""
        reported = -1

        def report(done: float) -> None:
            nonlocal reported
            if (percent := int(100.0 * done)) > reported:
                reported = percent
                context.report(Compiling(percent))

        (context.core.warm_up_volumes if self.volumes else context.core.warm_up)(context.closing, report)
        _keep_loaded(self.volumes)
        context.report(WarmedUp())


@cache
def _keep_loaded(volumes: bool) -> None:
    """Let no search for garbage go through what is loaded by now, which would delay the window by several frames.

    Once for images and once for volumes: done with every volume that is opened, this would keep each of them.
    """
    gc.freeze()


@dataclass(frozen=True, slots=True)
class Quit(Command):
    """End the thread."""


@dataclass(frozen=True, eq=False, slots=True)
class RunsCollected(Report):
    """The runs on the image opened as `generation`, as plain JSON, or a sentence on why there are none.

    `edition` is that of the timeline.
    """

    generation: int
    edition: int
    plain: Plain
    fault: str = ""


@dataclass(frozen=True, eq=False, slots=True)
class CollectRuns(Command):
    """Write the runs on the image opened as `generation` as plain JSON.

    `drawn` are the sources of their particles, by generation. `found` is the report, for other threads.
    """

    generation: int
    writer: RunsWriter
    drawn: Mapping[int, Counter[Hashable]]
    found: Future[RunsCollected] = field(default_factory=Future)

    activity = tr("collecting the runs")

    def execute(self, context: CommandContext) -> None:
        """Collect them."""
        plain = self.writer.to_plain(context.run.stored(self.drawn))
        self.found.set_result(RunsCollected(self.generation, context.run.timeline.edition, plain))
        context.report(self.found.result())

    def failure_report(self, error: Exception) -> Report:
        """A file without them can be written."""
        self.found.set_result(RunsCollected(self.generation, -1, {}, sentence(error, self.activity)))
        return self.found.result()


@dataclass(frozen=True, eq=False, slots=True)
class RunsRestored(Report):
    """The runs of a session are on the timeline.

    `begun` are their first documents and the sources of their particles, by generation; `shown` is whether one of them
    is about to be shown, `edition` that of the timeline.
    """

    generation: int
    begun: Mapping[int, tuple[Document, Counter[Hashable]]]
    shown: bool
    edition: int


@dataclass(frozen=True, eq=False, slots=True)
class RestoreRuns(Command):
    """Put the runs of a session file on the timeline, and go to the step that was shown."""

    generation: int
    plain: Plain
    image: ImageReference

    def execute(self, context: CommandContext) -> None:
        """Read the runs; what is damaged is left out and reported."""
        run = context.run
        if run.image_generation != self.generation:
            return
        stored, fault = runs_from_plain(self.plain, self.image)
        failed = run.restore(stored)
        if fault or failed:
            context.report(CommandFailed(fault or failed))
        known = {branch.identity for branch in run.timeline.outline.branches}
        here = stored.here if stored.here is not None and stored.here[0] in known else None
        begun = {-number: (kept.document, kept.drawn) for number, kept in enumerate(stored.runs, 1)}
        context.report(RunsRestored(self.generation, begun, here is not None, run.timeline.edition))
        if here is None:
            context.report(RunsKept(run.generation, run.timeline.outline))
        else:
            run.go_to(*here, lambda: not context.closing())
            run.halt()

    def failure_report(self, error: Exception) -> Report:
        """There is no run."""
        return RunFailed(self.generation, sentence(error, tr("bringing back the runs")))
