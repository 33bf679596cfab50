"""The files that were open lately."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtWidgets import QMenu

from app.model.text.language import tr
from app.session.storage.preferences import Preferences

MOST = 10
"""How many are remembered."""

_KEY = "files/recent"


class RecentFiles:
    """Their list, the newest first, and the menu that shows it.

    Parameters
    ----------
    preferences : Preferences
        Where the list is kept.
    open_file : callable
        Given the path of a file that was chosen.
    """

    def __init__(self, preferences: Preferences, open_file: Callable[[Path], None]) -> None:
        self._preferences = preferences
        self._open_file = open_file

    @property
    def paths(self) -> list[Path]:
        """The files."""
        return [Path(path) for path in self._preferences.get(_KEY, [""]) if path]

    def add(self, path: Path) -> None:
        """A file has been opened or saved."""
        path = path.absolute()
        others = [other for other in self.paths if other != path]
        self._preferences.put(_KEY, [str(each) for each in (path, *others)][:MOST])

    def fill(self, menu: QMenu) -> None:
        """One line a file; those that are gone are gray."""
        paths = self.paths
        for number, path in enumerate(paths, start=1):
            name = path.name.replace("&", "&&")
            key = f"&{number} " if number < 10 else f"{number} "
            action = menu.addAction(f"{key}{name}")
            there = path.is_file()
            action.setEnabled(there)
            told = str(path) if there else tr("{path} is not there any more.").format(path=path)
            action.setToolTip(told)
            action.setStatusTip(told)
            action.triggered.connect(lambda _=False, path=path: self._open_file(path))
        if not paths:
            menu.addAction(tr("Nothing yet")).setEnabled(False)
        menu.addSeparator()
        clear = menu.addAction(tr("&Clear this list"))
        clear.setEnabled(bool(paths))
        clear.triggered.connect(lambda: self._preferences.put(_KEY, [""]))
