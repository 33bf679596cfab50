"""The dialogs that ask for names and files, and questions whose buttons are named by what they do."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Literal, cast

from PySide6.QtWidgets import QAbstractButton, QFileDialog, QInputDialog, QMessageBox, QPushButton, QWidget

from cpm_app.model.text.language import tr
from cpm_app.session.session import Session
from cpm_app.session.storage.folders import Purpose, first_folder, remember_folder
from cpm_app.session.storage.preferences import Preferences
from cpm_core.formats import SUFFIX
from cpm_core.numerics.types import Texts, frozen

Answer = Literal["save", "discard", "cancel"]

_ROLES = {
    "accept": QMessageBox.ButtonRole.AcceptRole,
    "discard": QMessageBox.ButtonRole.DestructiveRole,
    "cancel": QMessageBox.ButtonRole.RejectRole,
}

_LEAST_WIDTH, _BESIDE_TITLE = 360, 180
"""Least width of a dialog, and what its frame needs next to its title, so that the title is not cut off [px]."""


@frozen
class Button:
    """A button of a question: the answer it gives, its text, and what it does."""

    answer: str
    text: str
    role: Literal["accept", "discard", "cancel"]


class Question(QMessageBox):
    """A question with a sentence that explains it.

    The first button that accepts is the default, or else the one that cancels; Escape is the one that cancels. There is
    no icon: the question is what counts, and the icons of Qt are of another style.
    """

    def __init__(self, parent: QWidget, title: str, text: str, more: str, buttons: Sequence[Button]) -> None:
        super().__init__(QMessageBox.Icon.NoIcon, title, text)
        self.setParent(parent, self.windowFlags())
        self.setInformativeText(more)
        self._answers: dict[QAbstractButton, str] = {}
        for button in buttons:
            made = self.addButton(button.text, _ROLES[button.role])
            self._answers[made] = button.answer
            if button.role == "accept" and self.defaultButton() is None:
                self.setDefaultButton(made)
            elif button.role == "cancel":
                self.setEscapeButton(made)
        if self.defaultButton() is None:
            self.setDefaultButton(cast("QPushButton", self.escapeButton()))

    def given(self) -> str:
        """The answer."""
        return self._answers[self.clickedButton() or self.escapeButton()]

    def ask(self) -> str:
        """Show the question and wait for the answer."""
        self.exec()
        self.deleteLater()
        return self.given()


def ask_about_unsaved(parent: QWidget, name: str, lost: Sequence[str]) -> Answer:
    """What to do with unsaved work called `name`; `lost` names what is not saved."""
    buttons = (
        Button("save", tr("&Save"), "accept"),
        Button("discard", tr("&Discard changes"), "discard"),
        Button("cancel", tr("&Keep editing"), "cancel"),
    )
    text = tr("Save the work on “{name}”?", name=name)
    parts = "".join(lost)
    more = tr("{parts} is not saved.") if parts.startswith("1 ") else tr("{parts} are not saved.")
    if len(lost) > 1:
        parts = tr("{parts} and {last}", parts=", ".join(lost[:-1]), last=lost[-1])
        more = tr("{parts} are not saved.")
    more = more.format(parts=f"{parts[:1].upper()}{parts[1:]}")
    return cast("Answer", Question(parent, tr("Unsaved work"), text, more, buttons).ask())


def ask_to_replace(parent: QWidget, name: str) -> bool:
    """Whether the file of this name may be replaced."""
    buttons = Button("keep", tr("&Keep it"), "cancel"), Button("replace", tr("&Replace"), "discard")
    more = tr("A file with this name exists; its contents would be lost.")
    return Question(parent, tr("Replace file"), tr("Replace “{name}”?", name=name), more, buttons).ask() == "replace"


def ask_for_text(parent: QWidget, title: str, label: str, button: str, text: str) -> str | None:
    """A text that is typed, None when the user cancels; `button` says what is done with it."""
    dialog = QInputDialog(parent)
    dialog.setWindowTitle(title)
    dialog.setLabelText(label)
    dialog.setOkButtonText(button)
    dialog.setCancelButtonText(tr("Cancel"))
    dialog.setMinimumWidth(max(_LEAST_WIDTH, dialog.fontMetrics().horizontalAdvance(title) + _BESIDE_TITLE))
    dialog.setTextValue(text)
    accepted = dialog.exec()
    dialog.deleteLater()
    return dialog.textValue() if accepted else None


_SHORT = QFileDialog.Option.HideNameFilterDetails
"""Kinds of files are shown by their names, without a list of suffixes."""


@frozen
class Files:
    """A kind of files that a dialog shows: its name and its suffixes; all files have none."""

    name: str
    suffixes: Texts

    @property
    def filter(self) -> str:
        """It in the words of Qt."""
        return f"{self.name} ({' '.join(f'*{suffix}' for suffix in self.suffixes) or '*'})"


SESSIONS = Files(tr("Sessions"), (SUFFIX,))
ALL_FILES = Files(tr("All files"), ())


class FileDialogs:
    """Asks for files of a session; `window` is the parent unless another one is given."""

    def __init__(self, window: QWidget, session: Session, preferences: Preferences) -> None:
        self._window = window
        self._session = session
        self._preferences = preferences

    def begin(self, purpose: Purpose) -> Path:
        """Folder that a dialog begins with."""
        return first_folder(self._preferences, self._session.document, purpose)

    def remember(self, purpose: Purpose, path: Path) -> None:
        """A file has been chosen."""
        remember_folder(self._preferences, self._session.document, purpose, path)

    def ask_for_file(self, purpose: Purpose, title: str, kinds: Iterable[Files]) -> Path | None:
        """A file that exists; None when the user cancels."""
        filters = ";;".join(kind.filter for kind in kinds)
        chosen, _ = QFileDialog.getOpenFileName(self._window, title, str(self.begin(purpose)), filters, "", _SHORT)
        if not chosen:
            return None
        self.remember(purpose, Path(chosen))
        return Path(chosen)

    def ask_where_to_save(
        self,
        purpose: Purpose,
        title: str,
        name: str,
        kinds: Sequence[Files],
        folder: Path | None = None,
    ) -> Path | None:
        """A file to write, which has a suffix of these kinds; None when the user cancels.

        `name` is suggested, its suffix is added to a name without one, and `folder` is where the dialog begins, by
        default next to the image.
        """
        known = [known for kind in kinds for known in kind.suffixes]
        suffix = max((known for known in known if name.endswith(known)), key=len, default=Path(name).suffix)
        first = next((kind.filter for kind in kinds if suffix in kind.suffixes), "")
        begin, filters = str((folder or self.begin(purpose)) / name), ";;".join(kind.filter for kind in kinds)
        chosen, _ = QFileDialog.getSaveFileName(self._window, title, begin, filters, first, _SHORT)
        if not chosen:
            return None
        path = Path(chosen)
        if not path.name.lower().endswith(tuple(known)) and (not path.suffix or len(known) == 1):
            path = path.with_name(path.name + suffix)
            # The desktop has asked only about the name as it was typed.
            if path.exists() and not ask_to_replace(self._window, path.name):
                return None
        self.remember(purpose, path)
        return path

    def ask_where_to_export(self, title: str, ending: str, kinds: Mapping[str, str]) -> Path | None:
        """A file to export to, named after the image with an ending; `kinds` are the names of suffixes."""
        image, stem = self._session.document.image, "cpm"
        if image is not None:
            in_volume = self._session.scene.slices is not None
            stem = image.name.partition(".")[0] if in_volume else Path(image.name).stem
        files = [Files(name, (suffix,)) for suffix, name in kinds.items()]
        return self.ask_where_to_save("export", title, f"{stem}{ending}", files)

    def ask_for_folder(self, title: str, purpose: Purpose = "open", parent: QWidget | None = None) -> str:
        """A folder, empty when the user cancels."""
        return QFileDialog.getExistingDirectory(parent or self._window, title, str(self.begin(purpose)))
