"""Recent files."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path

from PySide6.QtWidgets import QMenu

from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import ImageOpened
from cpm_app.session.storage.preferences import Preferences
from cpm_app.views.widgets.actions import add_menu_action
from cpm_core.formats import Reading, from_json
from cpm_core.formats.images.reading import DEFAULT_READING
from cpm_core.numerics.types import Callback

MAX_RECENT_FILES = 12
"""Largest number of files in the list."""

_RECENT_FILES_KEY = "files/recent"
"""Preference: the paths, the newest first."""

_MAX_PATH_LENGTH = 4096
"""Largest number of characters of a stored path; longer ones are ignored."""

_FILE_PARTS_KEY = "files/parts"
"""Preference: for each file of which a part was selected, whether it is a volume and how it is read, as JSON."""


class RecentFiles:
    """Recent files in the preferences, the newest first, and their menu; `open_file` opens a selected path."""

    def __init__(self, preferences: Preferences, open_file: Callable[[Path], None]) -> None:
        self._preferences = preferences
        self._open_file = open_file
        self.cleared: list[Callback] = []
        """Called when the list has been cleared."""

    @property
    def paths(self) -> list[Path]:
        """Recent files, the newest first."""
        return [
            Path(path)
            for path in self._preferences.read_key(_RECENT_FILES_KEY, [""])
            if 0 < len(path) <= _MAX_PATH_LENGTH
        ]

    def add_path(self, path: Path) -> None:
        """Put a file that was opened or saved first."""
        path = path.absolute()
        others = [other for other in self.paths if other != path]
        self._preferences.store_key(_RECENT_FILES_KEY, [str(each) for each in (path, *others)][:MAX_RECENT_FILES])

    def remember_part(self, opened: ImageOpened) -> None:
        """Remember which part of a file was opened, if it holds several."""
        if opened.saved is not None or opened.parts is None or not opened.parts.has_choice:
            return
        opened_as = opened.image.ndim == 3, opened.reading.arguments
        parts = self._preferences.read_json(_FILE_PARTS_KEY) | {str(opened.path.absolute()): opened_as}
        self._preferences.store_key(
            _FILE_PARTS_KEY, json.dumps({path: parts[path] for path in map(str, self.paths) if path in parts})
        )

    def find_part(self, path: Path) -> tuple[bool | None, Reading]:
        """Return whether a file was last opened as a volume, or None if unknown, and its reading."""
        try:
            as_volume, reading = self._preferences.read_json(_FILE_PARTS_KEY)[str(path.absolute())]
            return bool(as_volume), from_json(Reading, reading, "reading")
        except (KeyError, TypeError, ValueError):
            return None, DEFAULT_READING

    def fill_menu(self, menu: QMenu) -> None:
        """Fill a menu with the files; missing ones are disabled."""
        paths = self.paths
        for number, path in enumerate(paths, start=1):
            name = path.name.replace("&", "&&")
            key = f"&{number} " if number < 10 else f"{number} "
            exists = path.exists()
            tip = str(path) if exists else tr("{path} no longer exists.", path=path)
            add_menu_action(menu, f"{key}{name}", partial(self._open_file, path), tip).setEnabled(exists)
        menu.addSeparator()
        add_menu_action(menu, tr("&Clear this list"), self.clear).setEnabled(bool(paths))

    def clear(self) -> None:
        """Forget all files."""
        self._preferences.store_key(_RECENT_FILES_KEY, [""])
        self._preferences.store_key(_FILE_PARTS_KEY, "{}")
        for notify in self.cleared:
            notify()
