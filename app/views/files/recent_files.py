"""The recent files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtWidgets import QMenu

from app.model.preferences.preference import LONGEST_PATH
from app.model.text.language import tr
from app.session.storage.preferences import Preferences

MOST = 12
"""Largest number of files in the list."""

_KEY = "files/recent"


class RecentFiles:
    """Their list in the preferences, the newest first, and its menu; `open_file` is called with a chosen path."""

    def __init__(self, preferences: Preferences, open_file: Callable[[Path], None]) -> None:
        self._preferences = preferences
        self._open_file = open_file
        self.cleared: list[Callable[[], None]] = []
        """Called when the list has been cleared."""

    @property
    def paths(self) -> list[Path]:
        """The files."""
        return [Path(path) for path in self._preferences.get(_KEY, [""]) if 0 < len(path) <= LONGEST_PATH]

    def add(self, path: Path) -> None:
        """Put a file first that has been opened or saved."""
        path = path.absolute()
        others = [other for other in self.paths if other != path]
        self._preferences.put(_KEY, [str(each) for each in (path, *others)][:MOST])

    def fill(self, menu: QMenu) -> None:
        """Fill a menu with the files; missing ones are disabled."""
        paths = self.paths
        for number, path in enumerate(paths, start=1):
            name = path.name.replace("&", "&&")
            key = f"&{number} " if number < 10 else f"{number} "
            action = menu.addAction(f"{key}{name}")
            action.setEnabled(path.is_file())
            tip = str(path) if action.isEnabled() else tr("{path} does not exist any more.").format(path=path)
            action.setToolTip(tip)
            action.setStatusTip(tip)
            action.triggered.connect(lambda _=False, path=path: self._open_file(path))
        if not paths:
            menu.addAction(tr("Nothing yet")).setEnabled(False)
        menu.addSeparator()
        clear = menu.addAction(tr("&Clear this list"))
        clear.setEnabled(bool(paths))
        clear.triggered.connect(self._clear)

    def _clear(self) -> None:
        self._preferences.put(_KEY, [""])
        for follow in self.cleared:
            follow()
