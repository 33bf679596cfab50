"""The present session as a script or a command, which find the same objects; checked by doing what they will do."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Literal

from cpm_app.model.document.document import Document
from cpm_app.model.document.modes import needs_start
from cpm_app.model.document.objects import object_from_selection
from cpm_app.model.document.saving import to_session_file
from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import CommandFailed
from cpm_app.session.features.selector import AnyPartition, EverywhereRun, PartitionUpdater, parameters_everywhere
from cpm_app.session.scene import Proposal
from cpm_app.session.session import Session
from cpm_app.session.session_messages import EXPORTING_CATEGORY
from cpm_app.session.tasks.tasks import ENDED_TASK, BackgroundTask
from cpm_core import Image, Result, Selection, partition, run
from cpm_core.formats import SessionFile
from cpm_core.formats.sessions.session_code import (
    SessionCode,
    write_saved_objects_command,
    write_saved_objects_script,
)
from cpm_core.numerics.types import record
from cpm_core.objects.segmented import SegmentedObject, SegmentedObjects, select_by_clicks
from cpm_core.shapes import Barrier, Everywhere, PolygonRegion, select_starts

CodeLanguage = Literal["python", "command"]
"""What a session is written as."""


@record
class KnownRuns:
    """Runs that need not be repeated, since the window shows what they give.

    Attributes
    ----------
    result : Result or None
        What a run from the starts of the document gives.
    partition : Partition or VolumePartition or None
        The partition made from that.
    everywhere : Partition or VolumePartition or None
        The partition of a run from everywhere, for clicks without a run.
    """

    result: Result | None
    partition: AnyPartition | None
    everywhere: AnyPartition | None

    @classmethod
    def of_window(cls, session: Session, updater: PartitionUpdater) -> KnownRuns:
        """Take what is known of a session: of its run only if it has ended, and nothing has interfered with it."""
        status, scene, document, found = session.status, session.scene, session.document, session.scene.result
        changed = status.stale or scene.timeline.steered or scene.timeline.parameters != document.parameters
        if changed or status.phase != "finished" or not session.idle:
            found = None
        clicked = None
        if scene.image is not None and not document.has_volume:
            inputs = EverywhereRun(scene.image, parameters_everywhere(document), document.regions)
            clicked = updater.find_prepared(inputs)
        return cls(found, updater.find_prepared(found) if found else None, clicked)


def write_session_code(
    session: Session,
    updater: PartitionUpdater,
    language: CodeLanguage,
    saved: Path | None,
    on_written: Callable[[str], object],
) -> BackgroundTask:
    """Write the present session as a script or a command, which is passed on, or explain why it cannot be written.

    Objects of the session are found again, on a thread, so that what is written gives the same ones; a run that the
    window shows is not repeated. Where it would not give them, as for objects that were drawn by hand, it takes those
    of the `saved` session, if there is one.
    """
    document, image, offered = session.document, session.image, session.scene.objects.proposals
    known = KnownRuns.of_window(session, updater)
    session.messages.clear(EXPORTING_CATEGORY)
    if image is None:
        return ENDED_TASK
    if not (document.starts or document.objects.items or document.objects.clicks):
        session.messages.show(document.nothing_to_start_from, True, EXPORTING_CATEGORY)
        return ENDED_TASK

    def write(task: BackgroundTask) -> str:
        write_code = SessionCode.write_script if language == "python" else SessionCode.write_command
        code = _find_code(document, image, offered, write_code, "" if saved is None else str(saved), known, task)
        if code is not None:
            return write_code(code)
        if not document.objects.items and (document.objects.clicks or document.objects.dismissed):
            raise ValueError(tr("Accept an object and save the session first: another run would not offer the same."))
        if saved is None:
            raise ValueError(tr("Save the session first: without its file this cannot be repeated."))
        write_saved = write_saved_objects_command if language == "command" else write_saved_objects_script
        return write_saved(to_session_file(document, {}), str(saved))

    return session.tasks.start_task(
        tr("Repeating the session…"),
        write,
        tr("repeating the session"),
        partial(CommandFailed, category=EXPORTING_CATEGORY),
        on_result=on_written,
    )


def _find_code(
    document: Document,
    image: Image,
    offered: Sequence[Proposal],
    write_code: Callable[[SessionCode], str],
    saved: str,
    known: KnownRuns,
    task: BackgroundTask,
) -> SessionCode | None:
    """Find the run and the clicks that give the objects of a document; None if none that can be written gives them."""
    objects = document.objects
    items = [item for item in objects.items if item.number != objects.edited]
    shown = next((each for each in offered if each.clicks == objects.clicks), None)
    if shown is not None and shown.selection.has_boundary:  # the object that is being selected
        items.append(shown.proposed_object)
    if objects.dismissed and not items:  # of what the run proposes, what is left
        items = [each.proposed_object for each in offered]
        if not items:
            return None
    for session, file, of_run in _list_runs(document, saved):
        bare = SessionCode(session, file=file)
        writable = bool(write_code(bare))  # else only a saved session could say what was drawn
        if not items:
            return bare if writable else None
        code = _match_objects(session, image, items, of_run, known, task) if writable else None
        if code is not None:
            return replace(code, file=file)
    return None


def _list_runs(document: Document, saved: str) -> Iterator[tuple[SessionFile, str, bool]]:
    """List the runs that objects may come from: that of the session, in a file, and that of clicks without a run.

    The last value tells them apart.
    """
    session = replace(to_session_file(document, {}), objects=SegmentedObjects())
    if document.starts and needs_start(document.mode):
        yield session, saved, True
    if document.has_volume:
        yield replace(session, shapes=()), "", False
    else:
        limits = (shape for shape in document.shapes if isinstance(shape, PolygonRegion | Barrier))
        shapes = (*limits, Everywhere("grid"))
        yield replace(session, shapes=shapes, parameters=parameters_everywhere(document), mode=""), "", False


def _match_objects(
    session: SessionFile,
    image: Image,
    items: Sequence[SegmentedObject],
    of_run: bool,
    known: KnownRuns,
    task: BackgroundTask,
) -> SessionCode | None:
    """Match objects with what a run proposes, and with what their clicks select; None unless all are found again."""
    result, source = (known.result, known.partition) if of_run else (None, known.everywhere)
    if result is None and not all(item.clicks for item in items):
        return None  # neither clicked, nor shown as found by a run: a run would most likely be in vain
    if source is None and result is None and select_starts(session.shapes):
        result = run(image, session, progress=lambda _: task.check_cancelled())
    proposed = result.objects if of_run and result is not None else ()
    places = [next((at for at, one in enumerate(proposed) if _is_same(one, item)), None) for item in items]
    picked = tuple(at for at in places if at is not None)
    if len(picked) == len(items):
        return SessionCode(session, None if sorted(picked) == list(range(len(proposed))) else picked)
    left = [item for item, at in zip(items, places, strict=True) if at is None]
    if not all(item.clicks for item in left):
        return None
    if source is None:
        source = partition(image if result is None else result)
    for own, clicked in (((), items), (picked, left)):
        clicks = tuple(item.clicks for item in clicked)
        if all(clicks):
            found = select_by_clicks(source, clicks, [proposed[at] for at in own])
            if all(map(_is_same, found, clicked)):
                return SessionCode(session, own or None, clicks)
    return None


def _is_same(selection: Selection, item: SegmentedObject) -> bool:
    """Tell whether accepting a selection would give an object."""
    return selection.has_boundary and object_from_selection(selection, (), 1, 1).region == item.region
