"""Dialogs that ask for names and files, and questions whose buttons say what they do."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Literal, cast

from PySide6.QtWidgets import QAbstractButton, QFileDialog, QInputDialog, QMessageBox, QWidget

from cpm_app.model.text.language import tr
from cpm_app.session.session import Session
from cpm_app.session.storage.folders import Purpose, initial_folder, remember_folder
from cpm_app.session.storage.preferences import Preferences
from cpm_core.formats import SESSION_SUFFIX
from cpm_core.numerics.types import Texts, frozen

UnsavedAnswer = Literal["save", "discard", "cancel"]

_MIN_DIALOG_WIDTH = 360
"""Smallest width of a dialog [px]."""

_TITLE_BAR_SPACE = 180
"""Width that the frame needs next to the title, so that the title is not cut off [px]."""


class QuestionDialog(QMessageBox):
    """Dialog with a question and a sentence that explains it.

    The default is the first button that loses nothing. There is no icon, as those of Qt have another style.

    Parameters
    ----------
    parent : QWidget
        Window that the question belongs to.
    title, text, more : str
        Title, question and explanation.
    answers : mapping
        Answers and the texts of their buttons; the last one is that of Escape, too.
    losing : collection of str
        Answers that lose something.
    """

    def __init__(
        self,
        parent: QWidget,
        title: str,
        text: str,
        more: str,
        answers: Mapping[str, str],
        losing: Collection[str] = (),
    ) -> None:
        super().__init__(QMessageBox.Icon.NoIcon, title, text)
        self.setParent(parent, self.windowFlags())
        self.setInformativeText(more)
        role, last = QMessageBox.ButtonRole, [*answers][-1]
        self._answers: dict[QAbstractButton, str] = {}
        for answer, words in answers.items():
            fits = role.RejectRole if answer == last else role.DestructiveRole if answer in losing else role.AcceptRole
            button = self.addButton(words, fits)
            self._answers[button] = answer
            if self.defaultButton() is None and answer not in losing:
                self.setDefaultButton(button)
        self.setEscapeButton(button)

    def read_answer(self) -> str:
        """Return the answer of the button that was pressed."""
        return self._answers[self.clickedButton() or self.escapeButton()]

    def wait_for_answer(self) -> str:
        """Show the question and wait for the answer."""
        self.exec()
        self.deleteLater()
        return self.read_answer()


def ask_about_unsaved(parent: QWidget, name: str, lost: Sequence[str]) -> UnsavedAnswer:
    """Ask what to do with the unsaved work on `name`; `lost` lists what is not saved."""
    answers = {"save": tr("&Save"), "discard": tr("&Discard changes"), "cancel": tr("&Keep editing")}
    text = tr("Save the work on “{name}”?", name=name)
    parts = "".join(lost)
    more = tr("{parts} is not saved.") if parts.startswith("1 ") else tr("{parts} are not saved.")
    if len(lost) > 1:
        parts = tr("{parts} and {last}", parts=", ".join(lost[:-1]), last=lost[-1])
        more = tr("{parts} are not saved.")
    more = more.format(parts=f"{parts[:1].upper()}{parts[1:]}")
    question = QuestionDialog(parent, tr("Unsaved work"), text, more, answers, ("discard",))
    return cast("UnsavedAnswer", question.wait_for_answer())


def ask_to_replace(parent: QWidget, name: str, others: int = 0) -> bool:
    """Ask whether the file of this name, and so many others, may be replaced."""
    answers = {"replace": tr("&Replace"), "keep": tr("&Keep")}
    more, text = tr("A file with this name exists; its contents would be lost."), tr("Replace “{name}”?", name=name)
    if others:
        more = tr("These files exist; their contents would be lost.")
        text = tr("Replace “{name}” and {count} more?", name=name, count=others)
    return QuestionDialog(parent, tr("Replace file"), text, more, answers, ("replace",)).wait_for_answer() == "replace"


def ask_for_text(parent: QWidget, title: str, label: str, button: str, text: str) -> str | None:
    """Ask for a text; return None if the user cancels. `button` says what the text is for."""
    dialog = QInputDialog(parent)
    dialog.setWindowTitle(title)
    dialog.setLabelText(label)
    dialog.setOkButtonText(button)
    dialog.setCancelButtonText(tr("Cancel"))
    dialog.setMinimumWidth(max(_MIN_DIALOG_WIDTH, dialog.fontMetrics().horizontalAdvance(title) + _TITLE_BAR_SPACE))
    dialog.setTextValue(text)
    accepted = dialog.exec()
    dialog.deleteLater()
    return dialog.textValue() if accepted else None


_HIDE_SUFFIXES = QFileDialog.Option.HideNameFilterDetails
"""Option that shows kinds of files by name, without a list of suffixes."""


@frozen
class FileKind:
    """Kind of files that a dialog shows: its name and suffixes, which are empty for all files."""

    name: str
    suffixes: Texts

    @property
    def qt_filter(self) -> str:
        """Name filter of Qt for these files."""
        return f"{self.name} ({' '.join(f'*{suffix}' for suffix in self.suffixes) or '*'})"


SESSION_FILES = FileKind(tr("Sessions"), (SESSION_SUFFIX,))
"""Session files."""

ALL_FILES = FileKind(tr("All files"), ())
"""Files of any kind."""


class FileDialogs:
    """Dialogs that ask for the files of a session; `window` is their parent unless another one is given."""

    def __init__(self, window: QWidget, session: Session, preferences: Preferences) -> None:
        self._window = window
        self._session = session
        self._preferences = preferences

    def find_starting_folder(self, purpose: Purpose) -> Path:
        """Return the folder in which a dialog starts."""
        return initial_folder(self._preferences, self._session.document, purpose)

    def remember_path(self, purpose: Purpose, path: Path) -> None:
        """Remember the folder of a selected file."""
        remember_folder(self._preferences, self._session.document, purpose, path)

    def ask_for_file(self, purpose: Purpose, title: str, kinds: Iterable[FileKind]) -> Path | None:
        """Ask for an existing file; return None if the user cancels."""
        filters = ";;".join(kind.qt_filter for kind in kinds)
        chosen, _ = QFileDialog.getOpenFileName(
            self._window, title, str(self.find_starting_folder(purpose)), filters, "", _HIDE_SUFFIXES
        )
        if not chosen:
            return None
        self.remember_path(purpose, Path(chosen))
        return Path(chosen)

    def ask_where_to_save(
        self,
        purpose: Purpose,
        title: str,
        name: str,
        kinds: Sequence[FileKind],
        folder: Path | None = None,
    ) -> Path | None:
        """Ask for a file to write, with a suffix of these kinds; return None if the user cancels.

        `name` is suggested, its suffix is added to a name without one, and the dialog starts in `folder`, by default
        the one of the image.
        """
        known = [known for kind in kinds for known in kind.suffixes]
        suffix = max((known for known in known if name.endswith(known)), key=len, default=Path(name).suffix)
        first = next((kind.qt_filter for kind in kinds if suffix in kind.suffixes), "")
        begin, filters = (
            str((folder or self.find_starting_folder(purpose)) / name),
            ";;".join(kind.qt_filter for kind in kinds),
        )
        chosen, _ = QFileDialog.getSaveFileName(self._window, title, begin, filters, first, _HIDE_SUFFIXES)
        if not chosen:
            return None
        path = Path(chosen)
        if not path.name.lower().endswith(tuple(known)) and (not path.suffix or len(known) == 1):
            path = path.with_name(path.name + suffix)
            # The file dialog has asked only about the name as typed.
            if path.exists() and not ask_to_replace(self._window, path.name):
                return None
        self.remember_path(purpose, path)
        return path

    def ask_where_to_export(self, title: str, ending: str, kinds: Mapping[str, str]) -> Path | None:
        """Ask for a file to export to, named after the image with an ending; `kinds` maps suffixes to names."""
        image, stem = self._session.document.image, "cpm"
        if image is not None:
            in_volume = self._session.scene.slices is not None
            stem = image.name.partition(".")[0] if in_volume else Path(image.name).stem
        files = [FileKind(name, (suffix,)) for suffix, name in kinds.items()]
        return self.ask_where_to_save("export", title, f"{stem}{ending}", files)

    def ask_for_folder(self, title: str, purpose: Purpose = "open", parent: QWidget | None = None) -> str:
        """Ask for a folder; return an empty text if the user cancels."""
        return QFileDialog.getExistingDirectory(parent or self._window, title, str(self.find_starting_folder(purpose)))
