"""The keeper of a document's file: where it is saved, whether it differs from that, saving."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from app.model.document.document import Document
from app.model.document.saving import View, to_file
from app.model.text.language import tr
from app.session.exchange.messages import Opened, Report
from app.session.session import Session
from app.session.tasks.tasks import Task
from cpm_core.formats.sessions.session_file import SUFFIX, SessionFile, save_session


@dataclass(frozen=True, slots=True)
class Written(Report):
    """A session file has been written, with what a document was then."""

    path: Path
    file: SessionFile
    document: Document


class DocumentFile(QObject):
    """Knows the session file of what is open.

    Parameters
    ----------
    session : Session
        Whose document it keeps.
    view : callable
        How the window looks at it, as plain JSON.
    """

    changed = Signal()
    """Another file, or unsaved where it was not or the other way round."""
    edited = Signal()
    """What is to be saved may be another."""
    restored = Signal(object)
    """A session has been opened: how it was looked at, as plain JSON."""

    def __init__(self, session: Session, view: Callable[[], View]) -> None:
        super().__init__(session)
        self._session = session
        self._view = view
        self._file: SessionFile | None = None
        self._known: Document | None = session.document
        self._saving: Task | None = None
        self._next: Path | None = None
        self._told: tuple[Path | None, bool] = (None, False)
        self.path: Path | None = None
        session.document_changed.connect(lambda _: self._tell())
        session.listen(Opened, self._use_opened)
        session.listen(Written, self._use_written)
        session.tasks.changed.connect(self._save_again)

    @property
    def unsaved(self) -> bool:
        """Whether something would be lost by closing."""
        document = self._session.document
        return document.image is not None and document != self._known

    @property
    def name(self) -> str:
        """What the file is called, or would be."""
        image = self._session.document.image
        return self.path.name if self.path else f"{Path(image.name).stem}{SUFFIX}" if image else ""

    @property
    def file(self) -> SessionFile:
        """What is to be saved now."""
        return to_file(self._session.document, self._view(), self._file)

    def save(self, path: Path) -> None:
        """Write the session file, and keep to this place from now on; the window goes on meanwhile."""
        if self._saving is not None and not self._saving.over:
            self._next = path  # two at once would be in each other's way
            return
        self._next = None
        file, document = self.file, self._session.document

        def work(task: Task) -> Report:
            save_session(file, path)
            return Written(path, file, document)

        name = tr("Saving {name}…").format(name=path.name)
        self._saving = self._session.tasks.start(name, work, f"saving {path.name}", cancellable=False)

    def save_at_once(self, path: Path) -> bool:
        """Write the session file before anything else happens; False, and told, when that cannot be done."""
        file, document = self.file, self._session.document
        try:
            save_session(file, path)
        except ValueError as error:
            self._session.say(str(error), True)
            return False
        self._use_written(Written(path, file, document))
        return True

    def forget(self) -> None:
        """Whatever has been changed is not to be saved."""
        self._known = self._session.document
        self._tell()

    def _save_again(self) -> None:
        if self._next is not None and (self._saving is None or self._saving.over):
            path, self._next = self._next, None
            self.save(path)

    def _use_opened(self, opened: Opened) -> None:
        saved = opened.saved
        self.path, self._file = (saved.path, saved.file) if saved else (None, None)
        self._known = None if saved is not None and saved.recovered else self._session.document
        if saved is not None:
            self.restored.emit(saved.file.view)
        self._tell()

    def _use_written(self, written: Written) -> None:
        self.path, self._file, self._known = written.path, written.file, written.document
        self._session.say(tr("Saved: {path}").format(path=written.path))
        self._tell()

    def _tell(self) -> None:
        self.edited.emit()
        now = (self.path, self.unsaved)
        if now != self._told:
            self._told = now
            self.changed.emit()
