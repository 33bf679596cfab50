"""Preferences of the user, kept in a small file between starts of the program."""

from __future__ import annotations

from typing import TypeVar

from PySide6.QtCore import QByteArray, QObject, QSettings, Signal

Value = TypeVar("Value", bool, int, float, str, list[str], QByteArray)


class Preferences(QObject):
    """Values by key; each key has its only default where it is read."""

    changed = Signal(str)
    """Key of a value that has changed."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._settings = QSettings(QSettings.Format.IniFormat, QSettings.Scope.UserScope, "cpm", "cpm")

    def get(self, key: str, default: Value) -> Value:
        """The value of a key, of the default's type; the default when there is none or it is invalid."""
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

    def put(self, key: str, value: Value) -> None:
        """Store a value if it has changed."""
        if self._settings.value(key) != value:
            self._settings.setValue(key, value)
            self.changed.emit(key)

    def flush(self) -> None:
        """Write to the file now."""
        self._settings.sync()
