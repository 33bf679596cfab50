"""The session file of a document: where it is, whether it is up to date, saving."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject, Signal

from app.model.document.document import Document
from app.model.document.saving import View, changed_parts, to_file
from app.model.text.language import reason, tr
from app.session.exchange.messages import CommandFailed, Opened, Report
from app.session.session import Session
from app.session.signals import SAVING
from app.session.storage.run_keeping import RunKeeping
from app.session.tasks.tasks import Task
from cpm_core.formats import SUFFIX, SessionFile, TruthFile, save_session


@dataclass(frozen=True, eq=False, slots=True)
class Order:
    """What is to be saved: the content at the time of the order, and the number of the opened image."""

    path: Path
    file: SessionFile
    document: Document
    opening: int


@dataclass(frozen=True, eq=False, slots=True)
class Written(Report):
    """A session file has been written, with the runs of this edition."""

    order: Order
    edition: int


class DocumentFile(QObject):
    """The session file of what is open; `view` returns the view settings as plain JSON."""

    changed = Signal()
    """The file or its state, saved or unsaved, has changed."""
    edited = Signal()
    """The content to be saved may have changed."""
    restored = Signal(object)
    """A session has been opened: its view settings, as plain JSON."""

    def __init__(self, session: Session, view: Callable[[], View]) -> None:
        super().__init__(session)
        self._session = session
        self._view = view
        self._file: SessionFile | None = None
        self._known: Document | None = session.document
        self.runs = RunKeeping(session)
        self.truth: Callable[[], TruthFile | None] = lambda: None
        """Gives the ground truth to be saved; set by the window."""
        self.pages: Callable[[], Mapping[str, Any]] = dict
        """Gives the other pages of a stack, as plain JSON; set by what keeps them."""
        self.pages_unsaved: Callable[[], bool] = lambda: False
        """Whether closing would lose changes on other pages; set by what keeps them."""
        self._saving: Task | None = None
        self._opening = 0
        self._ordered: Order | None = None
        """What waits for the runs to be collected."""
        self._written: deque[Written] = deque(maxlen=1)
        self._waiting: dict[Path, Order] = {}
        """What waits for the file before it, the newest for each path: one is written at a time."""
        self._announced: tuple[Path | None, bool] = (None, False)
        self.path: Path | None = None
        session.document_changed.connect(lambda _: self._announce())
        self.runs.changed.connect(self._announce)
        session.listen(Opened, self._use_opened)
        session.listen(Written, self._use_written)
        session.tasks.changed.connect(self._save_next)

    @property
    def known(self) -> Document | None:
        """The document that the file has; None where it has another one."""
        return self._known

    @property
    def unsaved(self) -> bool:
        """Whether closing would lose changes."""
        return bool(self.lost)

    @property
    def lost(self) -> tuple[str, ...]:
        """What closing would lose, in words."""
        document = self._session.document
        if document.image is None:
            return ()
        others = ((self.runs.unsaved, tr("the runs")), (self.pages_unsaved(), tr("the other pages")))
        return (*changed_parts(document, self._known), *(words for lost, words in others if lost))

    @property
    def name(self) -> str:
        """Name of the file, or of the one that would be written."""
        image = self._session.document.image
        return self.path.name if self.path else f"{Path(image.name).stem}{SUFFIX}" if image else ""

    @property
    def file(self) -> SessionFile:
        """The content to be saved."""
        written = to_file(self._session.document, self._view(), self._file)
        return replace(written, runs=self.runs.plain, truth=self.truth(), pages=self.pages())

    def save(self, path: Path) -> None:
        """Write the session file on a separate thread, and use this path from now on."""
        self._waiting.pop(path, None)
        self._waiting[path] = self._order(path)
        self._save_next()

    def _order(self, path: Path) -> Order:
        return Order(path, self.file, self._session.document, self._opening)

    def _save_next(self) -> None:
        """Begin to carry out the order that has waited longest, unless one is being carried out."""
        if not self._waiting or self._ordered is not None or (self._saving is not None and not self._saving.over):
            return
        order = self._ordered = self._waiting.pop(next(iter(self._waiting)))
        self._session.attempt(SAVING)
        title = tr("Saving {name}…").format(name=order.path.name)
        task = self._saving = self._session.tasks.begin(title, cancellable=False)
        self.runs.collect(lambda _: self._write(task))

    def _write(self, waiting: Task) -> None:
        """Write the session file on a separate thread, in place of the task that waited for the runs."""
        if self._ordered is None:  # it has been written at once
            waiting.end()
            return
        order, self._ordered = self._with_runs(self._ordered), None
        edition = self.runs.edition

        def work(task: Task) -> Report:
            save_session(order.file, order.path)
            written = Written(order, edition)
            self._written.append(written)
            return written

        self._saving = self._session.tasks.start(
            waiting.name,
            work,
            tr("saving {name}").format(name=order.path.name),
            partial(CommandFailed, topic=SAVING),
            cancellable=False,
        )
        waiting.end()

    def _with_runs(self, order: Order) -> Order:
        """The order with the runs collected last, unless these belong to an image opened since."""
        if order.opening != self._opening:
            return order
        return replace(order, file=replace(order.file, runs=self.runs.plain))

    def finish(self) -> None:
        """Carry out at once, or wait for, what `save` has been asked for: closing must not overtake it."""
        ordered, waiting = self._ordered, list(self._waiting.values())
        self._ordered, self._waiting = None, {}
        if ordered is not None:  # it has waited for the runs until now
            self.runs.collect_at_once()
            self._write_at_once(self._with_runs(ordered))
            if self._saving is not None:
                self._saving.end()
        elif self._saving is not None and not self._saving.over:
            self._saving.wait()
        if self._written:
            self._use_written(self._written.pop())
        if waiting:
            self.runs.collect_at_once()
        for order in waiting:
            self._write_at_once(self._with_runs(order))

    def save_at_once(self, path: Path) -> bool:
        """Write the session file and wait for it; False, with an error message, when that fails."""
        self.finish()
        self.runs.collect_at_once()
        return self._write_at_once(self._order(path))

    def _write_at_once(self, order: Order) -> bool:
        try:
            save_session(order.file, order.path)
        except ValueError as error:
            self._session.say(reason(error), True, SAVING)
            return False
        self._session.pass_on(Written(order, self.runs.edition))
        return True

    def forget(self) -> None:
        """Treat the document as saved."""
        self._known = self._session.document
        self.runs.forget()
        self._announce()

    def _use_opened(self, opened: Opened) -> None:
        self._opening += 1
        saved = opened.saved
        self.path, self._file = (saved.path, saved.file) if saved else (None, None)
        self._known = self._session.document
        if saved is not None and (saved.recovered or saved.turned):
            self._known = saved.known and replace(saved.known, image=self._session.document.image)
        if saved is not None:
            self.restored.emit(saved.file.view)
        self._announce()

    def is_current(self, written: Written) -> bool:
        """Whether what has been written belongs to the image that is open."""
        return written.order.opening == self._opening

    def _use_written(self, written: Written) -> None:
        self._written.clear()
        order = written.order
        if self.is_current(written):
            self.path, self._file, self._known = order.path, order.file, order.document
            self.runs.saved(written.edition)
        self._session.say(tr("Saved: {path}").format(path=order.path), topic=SAVING)
        self._announce()

    def _announce(self) -> None:
        self.edited.emit()
        now = (self.path, self.unsaved)
        if now != self._announced:
            self._announced = now
            self.changed.emit()
