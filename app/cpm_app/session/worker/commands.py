"""Commands to the worker: executed in order between two steps, and never lost.

A command says what is done on the worker thread, and what is reported when that fails. A new kind is a function here or
in another module; the worker thread does not know the kinds.
"""

from __future__ import annotations

import gc
from collections import Counter
from collections.abc import Callable, Hashable, Mapping
from concurrent.futures import Future
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Concatenate, ParamSpec

from cpm_app.model.display import stamps
from cpm_app.model.document.document import Document, ImageReference
from cpm_app.model.export import ExportOrder, What, chosen, summary_text, thinned
from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import (
    CommandFailed,
    Compiling,
    Core,
    Exported,
    Finished,
    Reconstruction,
    Report,
    RunFailed,
    RunsKept,
    SeedsFound,
    WarmedUp,
    WentOn,
)
from cpm_app.session.tasks.tasks import Task
from cpm_app.session.timeline.plain_runs import runs_from_plain, runs_to_plain
from cpm_app.session.worker.run import Run
from cpm_core import Result, Skeleton
from cpm_core.formats import DRAWN, descriptions, located, write_together
from cpm_core.numerics.types import Plain, record
from cpm_core.shapes import NO_SEEDS

P = ParamSpec("P")

_CHANGING_RUNS = (Run.discard, Run.rename_branch, Run.drop_branch, Run.set_timeline_budget)


@record
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


@record
class Command:
    """Work for the worker thread between two steps.

    Attributes
    ----------
    work : callable
        Does it.
    activity : str
        What it does, as it follows "while" in an error message.
    kind : object
        Only the newest posted command of a kind is executed, as while a slider is moved; None where each one is.
    failed : callable
        Makes what is reported when the work fails, from a sentence.
    """

    work: Callable[[CommandContext], object]
    activity: str = tr("working")
    kind: object = None
    failed: Callable[[str], Report] = CommandFailed


QUIT = Command(lambda context: None)
"""Ends the thread."""


def run_call(
    generation: int | None,
    method: Callable[Concatenate[Run, P], bool | None],
    *arguments: P.args,
    **named: P.kwargs,
) -> Command:
    """Call a method of the run, unless that of the `generation` has been replaced by then; None is any run.

    A method that returns True lets a run go on that had ended; this is reported. Of placed charges, regions and edits
    by hand only the newest count.
    """

    def work(context: CommandContext) -> None:
        run = context.run
        if generation not in (None, run.generation):
            return
        if method(run, *arguments, **named):
            context.report(WentOn(run.generation))
        if run.state is None and method in _CHANGING_RUNS:
            context.report(RunsKept(run.generation, run.timeline.outline))

    kind = method if method in (Run.place, Run.limit, Run.edit_by_hand) else None
    return Command(work, tr("changing the run"), kind)


def start(generation: int, image_generation: int, document: Document) -> Command:
    """Start a run from a document, without a step, if its image is still the current one."""

    def work(context: CommandContext) -> None:
        if image_generation == context.run.image_generation:
            context.run.start(generation, document)

    return Command(work, tr("starting"), failed=partial(RunFailed, generation))


def find_seeds(image_generation: int, document: Document) -> Command:
    """Find the seeds of a document that depend on the image, for showing them."""

    def work(context: CommandContext) -> None:
        if image_generation == context.run.image_generation:
            context.report(SeedsFound(image_generation, context.run.seeds_for(document)))

    return Command(work, tr("looking for starting positions"), "seeds", partial(SeedsFound, image_generation, NO_SEEDS))


def write_files(
    task: Task,
    shown: Reconstruction | None,
    document: Document,
    order: ExportOrder,
    then: Callable[[tuple[bytes, ...]], object] | None = None,
) -> Command:
    """Make all files of an order and write them, or give their contents to `then`.

    During a run contours are those `shown` in the window; of a paused run they are those of its last state, which the
    window shows as soon as they are made.
    """

    def work(context: CommandContext) -> None:
        """Write them, unless the task has been cancelled, and report what the files hold and what not."""

        def wanted() -> bool:
            return not (task.over or context.closing())

        run, needs_run = context.run, any(file.what != "objects" for file in order.files)
        image = None if run.method is None else run.method.image
        source = None if document.image is None else document.image.path
        made: dict[tuple[What, bool], Result | Skeleton] = {}
        contents, counts = [], dict[What, str]()
        try:
            found = run.reconstruction(shown, wanted) if wanted() and needs_run else None
            if not wanted() or (needs_run and found is None):
                return
            whole = None if found is None else run.with_provenance(found.result)
            for file in order.files:
                key = file.what, order.thins(file.suffix)
                if key not in made:
                    result = chosen(whole, document, order, file.what, image)
                    made[key] = thinned(result, order.tolerance) if key[1] else result
                shaped = made[key]
                if file.suffix in DRAWN and shaped.image is None:
                    shaped = replace(shaped, image=image)
                elif file.suffix == ".labelme.json" and source is not None:
                    shaped = located(shaped, file.path, Path(source))
                contents.append((file.path, context.core.encode(shaped, file.suffix, space=order.space, image=source)))
                contents += [] if then else descriptions(made[key], file.path)
                counts.setdefault(file.what, summary_text(made[key], file.what, file.suffix))
            if then is not None:
                context.report(Finished(partial(then, tuple(content for _, content in contents))))
                return
            write_together(contents)
            several = tr("{count} files", count=len(contents))
            text = ", ".join([several] * (len(contents) > 1) + [*counts.values()])
            context.report(Exported(order.files[0].path, text))
        finally:
            task.end()

    activity = tr("writing {name}", name=order.files[0].path.name)
    return Command(work, activity, failed=partial(CommandFailed, topic="exporting"))


def warm_up(volumes: bool = False) -> Command:
    """Compile or load the kernels, of images or of volumes, so that the first step does not wait for them."""

    def work(context: CommandContext) -> None:
        reported = -1

        def report(done: float) -> None:
            nonlocal reported
            if (percent := int(100.0 * done)) > reported:
                reported = percent
                context.report(Compiling(percent))

        (context.core.warm_up_volumes if volumes else context.core.warm_up)(context.closing, report)
        stamps.load()
        _keep_loaded(volumes)
        context.report(WarmedUp())

    return Command(work, tr("preparing"))


_keep_loaded = cache(lambda volumes: gc.freeze())
"""Lets no search for garbage go through what is loaded by now, which would delay the window by several frames.

Once for images and once for volumes: done with every volume that is opened, this would keep each of them.
"""


@record
class RunsCollected(Report):
    """The runs on the image opened as `generation`, as plain JSON, or a sentence on why there are none.

    `edition` is that of the timeline.
    """

    generation: int
    edition: int
    plain: Plain
    fault: str = ""


def collect_runs(generation: int, drawn: Mapping[int, Counter[Hashable]], found: Future[RunsCollected]) -> Command:
    """Write the runs on the image opened as `generation` as plain JSON; `found` is the report, for other threads.

    `drawn` are the sources of their particles, by generation. Without them a file can be written as well.
    """

    def report(collected: RunsCollected) -> Report:
        found.set_result(collected)
        return collected

    def work(context: CommandContext) -> None:
        plain = runs_to_plain(context.run.stored(drawn))
        context.report(report(RunsCollected(generation, context.run.timeline.edition, plain)))

    return Command(
        work,
        tr("collecting the runs"),
        failed=lambda sentence: report(RunsCollected(generation, -1, {}, sentence)),
    )


@record
class RunsRestored(Report):
    """The runs of a session are on the timeline.

    `begun` are their first documents and the sources of their particles, by generation; `shown` is whether one of them
    is about to be shown, `edition` that of the timeline.
    """

    generation: int
    begun: Mapping[int, tuple[Document, Counter[Hashable]]]
    shown: bool
    edition: int


def restore_runs(generation: int, plain: Plain, image: ImageReference) -> Command:
    """Put the runs of a session file on the timeline, and go to the step that was shown.

    What is damaged is left out and reported.
    """

    def work(context: CommandContext) -> None:
        run = context.run
        if run.image_generation != generation:
            return
        stored, fault = runs_from_plain(plain, image)
        failed = run.restore(stored)
        if fault or failed:
            context.report(CommandFailed(fault or failed))
        outline, here = run.timeline.outline, stored.here
        if here is not None and all(branch.identity != here[0] for branch in outline.branches):
            here = None
        begun = {-number: (kept.document, kept.drawn) for number, kept in enumerate(stored.runs, 1)}
        context.report(RunsRestored(generation, begun, here is not None, outline.edition))
        if here is None:
            context.report(RunsKept(run.generation, outline))
        else:
            run.go_to(*here, lambda: not context.closing())
            run.halt()

    return Command(work, tr("restoring the runs"), failed=partial(RunFailed, generation))
