"""Preferences of the user, kept in a small file between starts of the program."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, TypeVar

from PySide6.QtCore import QByteArray, QObject, QSettings, Signal

from cpm_core.numerics.types import Callback

if TYPE_CHECKING:  # its sentences are translated while it is imported, and the language is read from here
    from cpm_app.model.preferences.table import Preference

Value = TypeVar("Value", bool, int, float, str, list[str], QByteArray)
PreferenceValue = TypeVar("PreferenceValue")


def open_settings() -> QSettings:
    """Open the file of the preferences; other files of the user are in its folder."""
    return QSettings(QSettings.Format.IniFormat, QSettings.Scope.UserScope, "cpm", "cpm")


class Preferences(QObject):
    """Values of preferences, and values that the window keeps by key, whose default is given where they are read."""

    changed = Signal(str)
    """Key of a value that has changed."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._settings = open_settings()

    def read_preference(self, preference: Preference[PreferenceValue]) -> PreferenceValue:
        """Return the value of a preference; its default if none is stored or the stored one is invalid."""
        stored = self._settings.value(preference.name)
        taken = None if stored is None else preference.parse_stored(stored)
        return preference.default if taken is None else taken

    def store_preference(self, preference: Preference[PreferenceValue], value: PreferenceValue) -> None:
        """Store a value; the default is not stored."""
        if value != self.read_preference(preference):
            if value == preference.default:
                self._settings.remove(preference.name)
            else:
                self._settings.setValue(preference.name, value)
            self.changed.emit(preference.name)

    def call_on_change(self, preference: Preference[PreferenceValue], callback: Callback) -> None:
        """Call a function now and whenever the value changes, as long as these preferences exist."""
        self.changed.connect(lambda key: callback() if key == preference.name else None)
        callback()

    def read_key(self, key: str, default: Value) -> Value:
        """Return the value of a key, of the default's type; the default if there is none or it is invalid."""
        value = self._settings.value(key)
        if value is None:
            return default
        if isinstance(default, bool):
            return value in (True, "true")
        if isinstance(default, list):
            return [str(item) for item in value] if isinstance(value, list) else [str(value)]
        try:
            return type(default)(value)
        except (TypeError, ValueError):
            return default

    def store_key(self, key: str, value: Value) -> None:
        """Store a value if it has changed."""
        if self._settings.value(key) != value:
            self._settings.setValue(key, value)
            self.changed.emit(key)

    def read_json(self, key: str) -> dict[str, Any]:
        """Return the JSON object stored by a key; empty if it cannot be read."""
        try:
            return dict(json.loads(self.read_key(key, "{}")))
        except (TypeError, ValueError, RecursionError):
            return {}

    def flush(self) -> None:
        """Write all values to the file now."""
        self._settings.sync()
