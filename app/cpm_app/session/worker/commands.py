"""Commands to the worker: executed in order between two steps, and never lost.

A command holds the work for the worker thread, and the report for the case that it fails. A new kind is a function here
or in another module; the worker thread does not know the kinds.
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

from cpm_app.model.document.document import Document, ImageReference, Mode
from cpm_app.model.export import (
    EXPORT_TITLES,
    ExportKind,
    ExportOrder,
    describe_change,
    describe_export,
    encode_measures,
    prepare_export,
    simplify_result,
)
from cpm_app.model.text.language import explain_error, tr
from cpm_app.session.exchange.messages import (
    CommandFailed,
    CompilationProgress,
    FilesExported,
    Reconstruction,
    Report,
    RunContinued,
    RunFailed,
    RunsKept,
    SeedsFound,
    WarmedUp,
    WorkFinished,
)
from cpm_app.session.tasks.tasks import BackgroundTask
from cpm_app.session.timeline.branches import StoredRuns
from cpm_app.session.timeline.runs_json import runs_from_json, runs_to_json
from cpm_app.session.timeline.timeline_nodes import StepAction
from cpm_app.session.worker.run import Run
from cpm_core import Result, Skeleton, to_bytes
from cpm_core.formats import FIGURE_SUFFIXES, encode_descriptions, set_relative_source, write_together
from cpm_core.numerics.types import JsonObject, record
from cpm_core.shapes import NO_SEEDS
from cpm_core.warm_up import warm_up_runs, warm_up_volumes

RunArguments = ParamSpec("RunArguments")

_SETTING_METHODS = (Run.set_parameters, Run.set_start, Run.set_charges, Run.set_regions)
"""Methods that replace what an earlier call has set."""

_TIMELINE_CHANGING_METHODS = (Run.discard_state, Run.rename_branch, Run.remove_branch, Run.set_timeline_budget)
"""Methods that change the timeline even while no run is shown."""


@record
class CommandContext:
    """Everything that commands have access to; only the worker thread touches it.

    Attributes
    ----------
    run : Run
        Method, state and parameters.
    report : callable
        Sends a report to the window.
    closing : callable
        Returns whether the program is about to end, so that long work is no longer useful.
    """

    run: Run
    report: Callable[[Report], None]
    closing: Callable[[], bool]


@record
class WorkerCommand:
    """Work for the worker thread between two steps.

    Attributes
    ----------
    execute : callable
        Does the work.
    activity : str
        Description of the work that follows "while" in an error message.
    kind : object
        Of the commands of a kind that wait, only the newest is executed, for example while a slider is moved, unless
        one whose kind is None is between them; those are all executed.
    failure_report : callable
        Makes the report for a failure from an error message.
    """

    execute: Callable[[CommandContext], object]
    activity: str = tr("working")
    kind: object = None
    failure_report: Callable[[str], Report] = CommandFailed


QUIT_COMMAND = WorkerCommand(lambda context: None)
"""Ends the thread."""


def call_run(
    generation: int | None,
    method: Callable[Concatenate[Run, RunArguments], bool | None],
    *arguments: RunArguments.args,
    **named: RunArguments.kwargs,
) -> WorkerCommand:
    """Call a method of the run, unless the run of this `generation` has been replaced by then; None is any run.

    A method that returns True has continued a run that had ended, which is reported. Of successive parameters, placed
    charges, regions and manual edits only the newest is used.
    """

    def call_method(context: CommandContext) -> None:
        run = context.run
        if generation not in (None, run.generation):
            return
        if method(run, *arguments, **named):
            context.report(RunContinued(run.generation))
        if run.state is None and method in _TIMELINE_CHANGING_METHODS:
            context.report(RunsKept(run.generation, run.timeline.timeline_state))

    return WorkerCommand(call_method, tr("changing the run"), method if method in _SETTING_METHODS else None)


def start_run(generation: int, image_generation: int, document: Document) -> WorkerCommand:
    """Start a run from a document, without a step, if its image is still the current one."""

    def start_if_current(context: CommandContext) -> None:
        if image_generation == context.run.image_generation:
            context.run.start(generation, document)

    return WorkerCommand(start_if_current, tr("starting"), failure_report=partial(RunFailed, generation))


def find_seeds(image_generation: int, document: Document) -> WorkerCommand:
    """Find and report the seeds of a document that depend on the image, so that they can be shown."""

    def report_seeds(context: CommandContext) -> None:
        if image_generation == context.run.image_generation:
            context.report(SeedsFound(image_generation, context.run.compute_image_seeds(document)))

    failed = partial(SeedsFound, image_generation, NO_SEEDS)
    return WorkerCommand(report_seeds, tr("looking for starting positions"), "seeds", failed)


def write_files(
    task: BackgroundTask,
    shown: Reconstruction | None,
    document: Document,
    order: ExportOrder,
    on_encoded: Callable[[tuple[bytes, ...]], object] | None,
) -> WorkerCommand:
    """Encode all files of an order and write them, or pass their contents to `on_encoded`.

    During a run these are the contours `shown` in the window. Of a paused run they are the contours of its last state,
    which the window shows as soon as they are reconstructed.
    """

    def encode_and_write(context: CommandContext) -> None:
        """Write the files, unless the task has been cancelled, and report their contents."""

        def is_wanted() -> bool:
            return not (task.is_over or context.closing())

        run, needs_run = context.run, any(file.kind not in ("objects", "measures") for file in order.files)
        image = None if run.method is None else run.method.image
        source = None if document.image is None else document.image.path
        made: dict[tuple[ExportKind, bool], Result | Skeleton] = {}
        contents, counts, changes = [], dict[ExportKind, str](), list[str]()
        try:
            found = run.wait_for_reconstruction(shown, is_wanted) if is_wanted() and needs_run else None
            if not is_wanted() or (needs_run and found is None):
                return
            whole = None if found is None else run.with_provenance(found.result)
            for file in order.files:
                if file.kind == "measures" and image is not None:
                    contents.append((file.path, encode_measures(document, order, image)))
                    counts.setdefault("measures", EXPORT_TITLES["measures"][0])
                    continue
                key = file.kind, order.should_simplify(file.suffix)
                if key not in made:
                    result = prepare_export(whole, document, order, file.kind, image)
                    made[key] = simplify_result(result, order) if key[1] else result
                    changes.append(describe_change(result, made[key]))
                shaped = made[key]
                if file.suffix in FIGURE_SUFFIXES and shaped.image is None:
                    shaped = replace(shaped, image=image)
                elif file.suffix == ".labelme.json" and source is not None:
                    shaped = set_relative_source(shaped, file.path, Path(source))
                contents.append((file.path, to_bytes(shaped, file.suffix, space=order.space, image=source)))
                contents += [] if on_encoded else encode_descriptions(made[key], file.path)
                counts.setdefault(file.kind, describe_export(made[key], file.kind, file.suffix))
            if task.is_cancelled:
                return
            if on_encoded is not None:
                context.report(WorkFinished(partial(on_encoded, tuple(content for _, content in contents))))
                return
            write_together(contents)
            text = ", ".join([*counts.values(), *filter(None, changes)])
            context.report(FilesExported(order.files[0].path, text, len(dict(contents))))
        finally:
            task.end()

    activity = tr("writing {name}", name=order.files[0].path.name)
    return WorkerCommand(encode_and_write, activity, failure_report=partial(CommandFailed, category="exporting"))


def compile_kernels(volumes: bool = False) -> WorkerCommand:
    """Compile or load the kernels, of images or of volumes, so that the first step does not wait for them."""

    def compile_and_report(context: CommandContext) -> None:
        reported = -1

        def report_progress(done: float) -> None:
            nonlocal reported
            if (percent := int(100.0 * done)) > reported:
                reported = percent
                context.report(CompilationProgress(percent))

        (warm_up_volumes if volumes else warm_up_runs)(context.closing, report_progress)
        _freeze_loaded_objects(volumes)
        context.report(WarmedUp())

    return WorkerCommand(compile_and_report, tr("preparing"))


_freeze_loaded_objects = cache(lambda volumes: gc.freeze())
"""Excludes the objects loaded by now from garbage collection, which would delay the window by several frames.

Once for images and once for volumes: frozen with each opened volume, all of them would be kept in memory.
"""


@record
class RunsCollected(Report):
    """The runs on the image opened as `generation`, as plain JSON, or an error message.

    `edition` is the edition of the timeline.
    """

    generation: int
    edition: int
    plain: JsonObject
    error: str = ""


def collect_runs(
    generation: int, sources: Mapping[int, Counter[Hashable]], found: Future[RunsCollected]
) -> WorkerCommand:
    """Encode the runs on the image opened as `generation` as plain JSON; `found` has the report for other threads.

    `sources` are the sources of their particles, by generation. A failure is reported too, so that the file can still
    be written without runs.
    """

    def hand_over(collected: RunsCollected) -> Report:
        found.set_result(collected)
        return collected

    def encode_runs(context: CommandContext) -> None:
        plain = runs_to_json(context.run.timeline.to_stored_runs(sources, context.run.parameters))
        context.report(hand_over(RunsCollected(generation, context.run.timeline.edition, plain)))

    return WorkerCommand(
        encode_runs,
        tr("collecting the runs"),
        failure_report=lambda sentence: hand_over(RunsCollected(generation, -1, {}, sentence)),
    )


@record
class RunsRestored(Report):
    """The runs of a session are on the timeline.

    `begun` are their first documents and the sources of their particles, by generation; `shown` is whether one of them
    is about to be shown, `edition` is the edition of the timeline.
    """

    generation: int
    begun: Mapping[int, tuple[Document, Counter[Hashable]]]
    shown: bool
    edition: int


def restore_runs(generation: int, plain: JsonObject, image: ImageReference, mode: Mode) -> WorkerCommand:
    """Put the runs of a session file on the timeline, and go to the step that was shown.

    It keeps its own parameters if those of the session are for a run in another `mode`. Damage is reported: no runs.
    """

    def restore_and_show(context: CommandContext) -> None:
        run = context.run
        if run.image_generation != generation:
            return
        stored, fault = runs_from_json(plain, image)
        try:
            run.restore_runs(stored)
        except ValueError as error:
            run.timeline.clear()
            stored, fault = StoredRuns(), explain_error(error)
        if fault:
            context.report(CommandFailed(fault))
        outline, here = run.timeline.timeline_state, stored.shown_step
        if here is not None and all(branch.identity != here[0] for branch in outline.branches):
            here = None  # there was no memory left for its run
        begun = {-number: (kept.document, kept.sources) for number, kept in enumerate(stored.runs, 1)}
        context.report(RunsRestored(generation, begun, here is not None, outline.edition))
        if here is None:
            context.report(RunsKept(run.generation, outline))
        else:
            lines = ((line, kept.document.mode) for kept in stored.runs for line in kept.branches)
            shown, first = next(one for one in lines if one[0].identity == here[0])
            taken = shown.node_at(here[1]).nodes_of_step[0].action
            if first != mode and isinstance(taken, StepAction):
                run.set_parameters(stored.parameters or taken.parameters)
            run.go_to(*here)
            run.halt()

    return WorkerCommand(restore_and_show, tr("restoring the runs"), failure_report=partial(RunFailed, generation))
