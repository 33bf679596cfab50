"""Commands that take the runs of a session out of the worker, and put them into it."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field

from app.model.document.document import Document, ImageReference
from app.model.text.language import tr
from app.session.exchange.error_messages import sentence
from app.session.exchange.messages import CommandFailed, Report, RunFailed, RunsKept
from app.session.timeline.stored.plain_runs import Plain, RunsWriter, from_plain
from app.session.worker.commands.run import Command, CommandContext


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

    `drawn` are the sources of their particles, by generation. `done` is set at the end, and `found` holds the report,
    for who cannot wait for it in the usual way.
    """

    generation: int
    writer: RunsWriter
    drawn: Mapping[int, Counter[Hashable]]
    done: threading.Event = field(default_factory=threading.Event)
    found: list[RunsCollected] = field(default_factory=list)

    activity = tr("collecting the runs")

    def execute(self, context: CommandContext) -> None:
        """Collect them, unless another image has been opened."""
        try:
            run = context.run
            plain = self.writer.to_plain(run.stored(self.drawn))
            self.found.append(RunsCollected(self.generation, run.recorded.timeline.edition, plain))
            context.report(self.found[0])
        finally:
            self.done.set()

    def failure_report(self, error: Exception) -> Report:
        """A file without them can be written."""
        return RunsCollected(self.generation, -1, {}, sentence(error, self.activity))


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
        stored, fault = from_plain(self.plain, self.image)
        failed = run.restore(stored)
        if fault or failed:
            context.report(CommandFailed(fault or failed))
        known = {branch.identity for branch in run.recorded.timeline.branches}
        here = stored.here if stored.here is not None and stored.here[0] in known else None
        begun = {-number: (kept.document, kept.drawn) for number, kept in enumerate(stored.runs, 1)}
        context.report(RunsRestored(self.generation, begun, here is not None, run.recorded.timeline.edition))
        if here is None:
            context.report(RunsKept(run.generation, run.recorded.outline))
        else:
            run.go_to(*here, lambda: not context.closing())
            run.halt()

    def failure_report(self, error: Exception) -> Report:
        """There is no run."""
        return RunFailed(self.generation, sentence(error, tr("bringing back the runs")))
