"""The session applied to all images of a folder, in processes of their own, as ``cpm batch`` does it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from cpm_app.model.document.saving import to_session_file
from cpm_app.model.text.language import explain_system_error, tr
from cpm_app.session.exchange.messages import CommandFailed
from cpm_app.session.session import Session
from cpm_app.session.session_messages import BATCH_CATEGORY
from cpm_app.session.tasks.opening import list_images
from cpm_app.session.tasks.tasks import BackgroundTask
from cpm_core.formats import SESSION_SUFFIX, SessionFile, choose_file_name, save_session
from cpm_core.numerics.types import Texts, frozen

_RESULTS_FOLDER = "objects"
"""Name of the folder of results, inside the folder of images."""

_APPLIED_SESSION = f"session{SESSION_SUFFIX}"
"""Name of the session that the results were made with, in their folder."""


@frozen
class BatchDone:
    """All images of a folder are done.

    Attributes
    ----------
    images, objects, likely : int
        Number of images, of the objects found in them, and of those that are likely.
    failed : tuple of str
        Names of the images that could not be used.
    folder : Path
        Where everything was written.
    """

    images: int
    objects: int
    likely: int
    failed: Texts
    folder: Path


def results_folder(folder: Path) -> Path:
    """Return the folder that the results of the images in a folder are written to."""
    return folder / _RESULTS_FOLDER


def count_written_files(folder: Path, suffixes: Texts) -> int:
    """Count the files of earlier results, in formats of these suffixes, of the images in a folder."""
    try:
        names = [path.name for path in results_folder(folder).iterdir()]
    except OSError:
        return 0
    endings = tuple(choose_file_name("", "objects", suffix) for suffix in suffixes)
    return sum(name.endswith(endings) for name in names)


def apply_to_folder(
    session: Session, folder: Path, suffixes: Texts, on_done: Callable[[BatchDone], object]
) -> BackgroundTask:
    """Write the objects of all images of a folder by the present session, on a thread; none is done twice.

    `suffixes` are those of the formats that are written.
    """
    session.messages.clear(BATCH_CATEGORY)
    document = session.document
    work = partial(_run_batch, to_session_file(document, {}), folder, suffixes)
    return session.tasks.start_task(
        tr("Running the images of {folder}…", folder=folder.name),
        work,
        tr("running many images"),
        partial(CommandFailed, category=BATCH_CATEGORY),
        on_result=on_done,
    )


def describe_lack_of_start(session: Session) -> str:
    """Return why the present session cannot be applied to other images; empty if it can."""
    document = session.document
    if document.mode == "skeleton":
        return tr("Skeletons are found image by image: choose another mode to run many images.")
    return "" if document.starts else document.nothing_to_start_from


def _run_batch(session: SessionFile, folder: Path, suffixes: Texts, task: BackgroundTask) -> BatchDone:
    from cpm_core.cli.batch import Batch
    from cpm_core.cli.workers import run_locally

    images, output = tuple(map(str, list_images(folder))), results_folder(folder)
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
    batch = Batch(images, session, output / _APPLIED_SESSION, output, suffixes)
    for _ in batch.write_results(run_locally(batch.jobs, None, task.check_cancelled)):
        task.fraction = len(batch.rows) / len(images)
    rows = batch.rows.values()
    failed = tuple(Path(row.image).name for row in rows if row.trouble)
    likely = sum(int(str(row.facts.get("likely", 0))) for row in rows)
    return BatchDone(len(images), sum(row.found for row in rows), likely, failed, output)
