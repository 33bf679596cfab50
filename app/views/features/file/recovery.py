"""Autosave, and the offer to restore unsaved work after a crash."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QDateTime, QLocale

from app.model.text.language import tr
from app.model.text.shortening import shortened
from app.session.exchange.messages import Opened
from app.session.signals import JOURNAL, RECOVERY
from app.session.storage.autosave import Journal, folder_of_journals
from app.session.storage.recovery import Leftover, left_behind
from app.session.storage.session_file import DocumentFile, Written
from app.session.tasks.opening import Wanted
from app.views.window.dialogs import Button, Question
from app.views.window.feature import Feature, FeatureContext

_PATH = 300
"""Letters of a path that are shown in a question."""


class RecoveryFeature(Feature):
    """Recovery of unsaved work after the program has ended unexpectedly."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self._folder = folder_of_journals()
        self.journal: Journal | None = None
        self.box: Question | None = None
        self._waiting: list[Leftover] = []
        self._restoring: Leftover | None = None
        self._wanted: Wanted | None = None
        self._restored = False
        self._document_file: DocumentFile | None = None

    def keep(self, document_file: DocumentFile) -> None:
        """Keep a journal of the open document."""
        self._document_file = document_file
        self.journal = Journal(document_file, self._folder, self.context.preferences)
        self.journal.put.connect(self._tell)
        self.context.session.listen(Opened, self._use_opened)
        self.context.session.listen(Written, self._use_written)

    def offer(self) -> None:
        """Offer to restore the unsaved work of earlier windows, and say what of it cannot be read."""
        found = left_behind(self._folder)
        if found.troubles:
            self.context.session.say(" ".join(found.troubles), True, RECOVERY)
        self._waiting = list(found.leftovers)
        self._ask()

    def close(self) -> bool:
        """Remove the journal of this window; keep work that the user has not decided on."""
        for leftover in self._waiting:
            leftover.keep()
        if self._restoring is not None:
            self._restoring.keep()
        self._waiting, self._restoring = [], None
        if self.box is not None:
            self.box.close()
        if self.journal is not None:
            self.journal.close()
        return True

    def _ask(self) -> None:
        if not self._waiting:
            return
        leftover = self._waiting[0]
        buttons = (
            Button("restore", tr("&Restore"), "accept"),
            Button("discard", tr("&Discard this work"), "discard"),
            Button("later", tr("Ask me &later"), "cancel"),
        )
        text = tr("CPM ended unexpectedly. Restore “{name}”?").format(name=shortened(leftover.name, _PATH))
        details = "\n".join(_details(leftover))
        self.box = box = Question(self.context.window, tr("Restore unsaved work"), text, details, buttons)
        box.buttonClicked.connect(lambda _: self._act_on(box.given()))
        box.open()

    def _act_on(self, answer: str) -> None:
        if answer == "restore":
            self._restore()
        elif answer == "discard":
            self._discard()

    def _restore(self) -> None:
        if self._restoring is not None:  # its image was not found, and it waits for another time
            self._restoring.keep()
        self._restoring = self._waiting.pop(0)
        self._wanted = self._restoring.wanted
        self.context.session.begin(self._wanted)

    def _discard(self) -> None:
        self._waiting.pop(0).discard()
        self._ask()

    def _use_opened(self, opened: Opened) -> None:
        """Write a restored document to the new journal, and delete the old one only when that is on the disk."""
        self._restored = self._wanted is not None and opened.saved is self._wanted.saved
        if self._restored and self.journal is not None:
            self.journal.write()
            if self.journal.flush() and self.journal.path.exists():
                self._end_restoring()

    def _use_written(self, written: Written) -> None:
        """A restored document that no journal could take is in a session file now."""
        if self._restored and self._document_file is not None and self._document_file.is_current(written):
            self._end_restoring()

    def _end_restoring(self) -> None:
        if self._restoring is not None:
            self._restoring.discard()
        self._restoring, self._wanted, self._restored = None, None, False

    def _tell(self, trouble: str) -> None:
        self.context.session.trouble(trouble, JOURNAL)


def _details(leftover: Leftover) -> Sequence[str]:
    when = QLocale().toString(
        QDateTime.fromSecsSinceEpoch(int(leftover.when.timestamp())), QLocale.FormatType.ShortFormat
    )
    image, shapes = leftover.file.image, len(leftover.file.shapes)
    session = shortened(str(leftover.path), _PATH) if leftover.path else tr("never saved")
    return (
        tr("Last changed: {when}").format(when=when),
        tr("Image: {path}").format(path=shortened(image.path, _PATH) if image else "–"),
        tr("Session file: {path}").format(path=session),
        tr("Shapes drawn: {count}").format(count=shapes),
    )
