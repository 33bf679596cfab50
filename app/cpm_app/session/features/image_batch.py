"""The session applied to all images of a folder, in processes of their own, as ``cpm batch`` does it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from cpm_app.model.document.saving import to_session_file
from cpm_app.model.text.language import explain_system_error, tr
from cpm_app.session.exchange.messages import CommandFailed
from cpm_app.session.session import Session
from cpm_app.session.tasks.opening import list_images
from cpm_app.session.tasks.tasks import ENDED_TASK, BackgroundTask
from cpm_core.formats import SESSION_SUFFIX, SessionFile, save_session
from cpm_core.numerics.types import frozen

BATCH_CATEGORY = "batch"
"""Category of messages about the batch."""

_RESULTS_FOLDER = "contours"
"""Name of the folder of results, inside the folder of images."""

_APPLIED_SESSION = f"session{SESSION_SUFFIX}"
"""Name of the session that the results were made with, in their folder."""

_SUMMARY_TABLE = "summary.csv"
"""Name of the table of all results, in their folder."""


@frozen
class BatchDone:
    """All images of a folder are done: their number, the number of unusable ones, and the table of all results."""

    images: int
    failed: int
    table: Path


def apply_to_folder(session: Session, folder: Path, on_done: Callable[[BatchDone], object]) -> BackgroundTask:
    """Apply the present session to the images of a folder, on a thread; finished images are not run again."""
    session.messages.clear(BATCH_CATEGORY)
    document = session.document
    if document.mode == "skeleton":
        session.messages.show(
            tr("Skeletons are found image by image: choose another mode to run many images."), True, BATCH_CATEGORY
        )
        return ENDED_TASK
    if not document.starts:
        session.messages.show(document.nothing_to_start_from, True, BATCH_CATEGORY)
        return ENDED_TASK
    name = tr("Running the images of {folder}…", folder=folder.name)
    work = partial(_run_batch, to_session_file(document, {}), folder)
    return session.tasks.start_task(
        name, work, tr("running many images"), partial(CommandFailed, category=BATCH_CATEGORY), on_result=on_done
    )


def _run_batch(session: SessionFile, folder: Path, task: BackgroundTask) -> BatchDone:
    from cpm_core.cli.batch import DEFAULT_SUFFIXES, Batch
    from cpm_core.cli.workers import run_locally

    images, output = tuple(map(str, list_images(folder))), folder / _RESULTS_FOLDER
    if not images:
        raise ValueError(tr("This folder contains no readable image: choose another one."))
    try:
        output.mkdir(exist_ok=True)
    except OSError as error:
        raise ValueError(
            tr(
                "{folder} is not a folder and cannot be created: {reason}.",
                folder=output,
                reason=explain_system_error(error),
            )
        ) from error
    save_session(session, output / _APPLIED_SESSION)
    batch = Batch(images, session, output / _APPLIED_SESSION, output, DEFAULT_SUFFIXES)
    for _ in batch.write_results(run_locally(batch.jobs, None, task.check_cancelled)):
        task.fraction = len(batch.rows) / len(images)
    failed = sum(bool(row.trouble) for row in batch.rows.values())
    return BatchDone(len(images), failed, output / _SUMMARY_TABLE)
