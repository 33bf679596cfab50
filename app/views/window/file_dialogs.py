"""The dialogs that ask for files: the desktop's own, where it has some, each beginning in the folder that suits."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtWidgets import QFileDialog, QWidget

from app.model.text.language import tr
from app.session.session import Session
from app.session.storage.folders import Purpose, first_folder, remember_folder
from app.session.storage.preferences import Preferences
from app.views.window import dialogs
from cpm_core.formats import READABLE
from cpm_core.formats.sessions.session_file import SUFFIX

_SHORT = QFileDialog.Option.HideNameFilterDetails
"""Kinds of files are shown by their names, without a list of suffixes."""


@dataclass(frozen=True, slots=True)
class Files:
    """A kind of files that a dialog shows: its name and its suffixes; all files have none."""

    name: str
    suffixes: tuple[str, ...]

    @property
    def filter(self) -> str:
        """It in the words of Qt."""
        return f"{self.name} ({' '.join(f'*{suffix}' for suffix in self.suffixes) or '*'})"


def images() -> Files:
    """Images that can be read."""
    return Files(tr("Images"), tuple(READABLE))


def sessions() -> Files:
    """Sessions."""
    return Files(tr("Sessions"), (SUFFIX,))


def all_files() -> Files:
    """Files of any kind."""
    return Files(tr("All files"), ())


def images_and_sessions() -> Sequence[Files]:
    """What can be opened: both together first, then each kind."""
    both = Files(tr("Images and sessions"), (*READABLE, SUFFIX))
    return (both, images(), sessions(), all_files())


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
        return self._chosen(purpose, chosen)

    def ask_where_to_save(
        self,
        purpose: Purpose,
        title: str,
        name: str,
        kinds: Sequence[Files],
        folder: Path | None = None,
        parent: QWidget | None = None,
    ) -> Path | None:
        """A file to write, which has a suffix of these kinds; None when the user cancels.

        `name` is suggested, its suffix is added to a name without one, and `folder` is where the dialog begins, by
        default beside the image.
        """
        parent, suffix = parent or self._window, Path(name).suffix
        first = next((kind.filter for kind in kinds if suffix in kind.suffixes), "")
        begin, filters = str((folder or self.begin(purpose)) / name), ";;".join(kind.filter for kind in kinds)
        chosen, _ = QFileDialog.getSaveFileName(parent, title, begin, filters, first, _SHORT)
        if not chosen:
            return None
        path = Path(chosen)
        known = [known for kind in kinds for known in kind.suffixes]
        if path.suffix.lower() not in known and (not path.suffix or len(known) == 1):
            path = path.with_name(path.name + suffix)
            # The desktop has asked only about the name as it was typed.
            if path.exists() and not dialogs.ask_to_replace(parent, path.name):
                return None
        return self._chosen(purpose, str(path))

    def _chosen(self, purpose: Purpose, chosen: str) -> Path | None:
        if not chosen:
            return None
        path = Path(chosen)
        self.remember(purpose, path)
        return path


def ask_for_folder(parent: QWidget, title: str, folder: str) -> str:
    """A folder, empty when the user cancels."""
    return QFileDialog.getExistingDirectory(parent, title, folder)


def ask_for_images(parent: QWidget, title: str, folder: str) -> list[Path]:
    """Images that exist, none when the user cancels."""
    chosen, _ = QFileDialog.getOpenFileNames(parent, title, folder, images().filter, "", _SHORT)
    return [Path(name) for name in chosen]
