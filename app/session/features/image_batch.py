"""The session applied to many images, in processes of their own, as ``cpm batch`` does it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from app.model.document.saving import to_file
from app.model.text.language import cause, tr
from app.session.exchange.messages import CommandFailed, Report
from app.session.session import Session
from app.session.tasks.tasks import Task
from cpm_core.formats.common.content import fingerprint
from cpm_core.formats.sessions.session_file import SUFFIX, SessionFile, save_session
from cpm_core.objects.warm_up import is_compiled

if TYPE_CHECKING:  # the command line is loaded when there is a batch
    from cpm_core.cli.batch import Row

TOPIC = "batch"
"""What messages on it belong to."""

TABLE = "summary.csv"
"""Name of the table of all images."""

APPLIED = f"session{SUFFIX}"
"""Name of the file that keeps, beside the results, the session they were made with."""


@dataclass(frozen=True, slots=True)
class BatchDone(Report):
    """A batch has come to its end: the folder that was written to."""

    output: Path


class ImageBatch(QObject):
    """Applies the session as it is to images, and knows what has been done with each."""

    changed = Signal()
    """Another image is done, or the work has begun or ended."""
    _told = Signal(object)
    """An image is done: its order's output, its number and its row, sent by the thread that waits for it."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self.images: tuple[Path, ...] = ()
        self.rows: dict[int, Row] = {}
        """What has been done, by the number of the image."""
        self.output = Path()
        self.compiling = False
        """Whether the inner loops had not been compiled when the work began."""
        self.task: Task | None = None
        self._session = session
        self._told.connect(self._take)
        session.tasks.changed.connect(self._look_at_task)

    @property
    def running(self) -> bool:
        """Whether it is under way."""
        return self.task is not None

    @property
    def failed(self) -> int:
        """How many images could not be used."""
        return sum(bool(row.trouble) for row in self.rows.values())

    @property
    def trouble(self) -> str:
        """Why the session cannot be applied to images as it is, in a sentence; empty when it can."""
        document = self._session.document
        if document.mode == "skeleton":
            return tr("Skeletons are found image by image: choose another mode to run many images.")
        return "" if document.starts else document.nothing_to_start_from

    def start(self, images: Sequence[Path], output: Path, suffixes: tuple[str, ...]) -> None:
        """Apply the session to images and write into a folder; what is done there already is not done again."""
        if self.running or not images:
            return
        self._session.attempt(TOPIC)
        self.images, self.rows, self.output, self.compiling = tuple(images), {}, output, False
        name = tr("Running {count} images…").format(count=len(images))
        work = partial(self._work, to_file(self._session.document, {}), tuple(map(str, images)), output, suffixes)
        failure = partial(CommandFailed, topic=TOPIC)
        self.task = self._session.tasks.start(name, work, tr("running many images"), failure)
        self.changed.emit()

    def cancel(self) -> None:
        """Stop; what is done stays, and the same order goes on from there."""
        if self.task is not None:
            self.task.cancel()
            self._look_at_task()

    def _work(
        self, session: SessionFile, images: tuple[str, ...], output: Path, suffixes: tuple[str, ...], task: Task
    ) -> Report:
        from cpm_core.cli.batch import Batch, Order
        from cpm_core.cli.workers import here

        self.compiling = not is_compiled()
        applied = output / APPLIED
        try:
            output.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            text = tr("{folder} is no folder, and none can be made: {reason}.")
            raise ValueError(text.format(folder=output, reason=cause(error))) from error
        save_session(session, applied)
        batch = Batch(Order(images, session, fingerprint(applied), output, suffixes, session.parameters))
        for number, row in batch.known.items():
            self._told.emit((task, number, row))
        for number, row in batch.rows(here(batch.jobs, None, task.check_cancelled)):
            self._told.emit((task, number, row))
            task.fraction = len(batch.summary.rows) / len(images)
        return BatchDone(output)

    def _take(self, done: tuple[Task, int, Row]) -> None:
        """Keep what has been done with an image, if it is one of the present order."""
        task, number, row = done
        if task is self.task or self.task is None:
            self.rows[number] = row
            self.changed.emit()

    def _look_at_task(self) -> None:
        if self.task is not None and self.task.over:
            self.task = None
            self.changed.emit()

    @property
    def summary_text(self) -> str:
        """How far it is, in a sentence."""
        if not self.images:
            return ""
        done, count = len(self.rows) - self.failed, len(self.images)
        text = tr("{done} of {count} images are done.").format(done=done, count=count)
        more = tr("{failed} could not be used.").format(failed=self.failed)
        where = tr("The table is {path}.").format(path=self.output / TABLE)
        if self.running and self.compiling and not self.rows:
            text += " " + tr("The inner loops are compiled for this computer, once, before the first image.")
        parts = [text, more if self.failed else "", where if self.rows and not self.running else ""]
        return " ".join(filter(None, parts))
