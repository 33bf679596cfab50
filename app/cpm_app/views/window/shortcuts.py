"""Keys of all actions and panels: the defaults, or those that the user has set in the preferences."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QAction, QKeySequence

from cpm_app.model.preferences import shortcuts
from cpm_app.model.preferences.shortcuts import Keyed
from cpm_app.model.text.keys import Named
from cpm_app.session.storage.preferences import Preferences
from cpm_app.views.widgets.actions import native
from cpm_core.numerics.types import Texts


class Shortcuts(QObject):
    """Keys of the actions, which follow the preference."""

    changed = Signal()

    def __init__(self, preferences: Preferences, parent: QObject) -> None:
        super().__init__(parent)
        self._preferences = preferences
        self._actions: dict[str, tuple[Keyed, QAction]] = {}
        self._chosen = self._read()
        preferences.changed.connect(self._follow)

    @property
    def actions(self) -> Sequence[Keyed]:
        """All actions that can have keys."""
        return [action for action, _ in self._actions.values()]

    def add(self, action: QAction, name: str, title: str, group: str) -> None:
        """Add an action that has its default keys."""
        self._actions[name] = Keyed(name, title, group, tuple(key.toString() for key in action.shortcuts())), action
        action.setShortcuts([QKeySequence(key) for key in self.keys(name)])

    def keys(self, name: str) -> Texts:
        """Return the keys of an action."""
        return shortcuts.keys_of(self._actions[name][0], self._chosen)

    def names(self) -> dict[str, Named]:
        """Return titles and keys of the actions, as sentences mention them."""
        return {
            name: Named(native(next(iter(self.keys(name)), "")), action.title)
            for name, (action, _) in self._actions.items()
        }

    def holder(self, key: str, besides: str) -> Keyed | None:
        """Find the action with a key, other than the one named `excluded`."""
        return shortcuts.holder(key, self.actions, self._chosen, besides)

    def choose(self, name: str, key: str) -> None:
        """Give an action one key, or none if `key` is empty; another action with this key loses it."""
        self._store(shortcuts.with_key(key, self._actions[name][0], self.actions, self._chosen))

    def restore(self, name: str) -> None:
        """Give an action its default keys; other actions with these keys lose them."""
        changed = {**self._chosen}
        changed.pop(name, None)
        default = self._actions[name][0].default
        for other in self.actions:
            kept = tuple(key for key in shortcuts.keys_of(other, changed) if key not in default)
            if other.name != name and kept != shortcuts.keys_of(other, changed):
                changed[other.name] = kept
        self._store(changed)

    def reset(self) -> None:
        """Give all actions their default keys."""
        self._store({})

    def _store(self, chosen: shortcuts.Chosen) -> None:
        self._preferences.put(shortcuts.KEY, shortcuts.written(chosen))

    def _read(self) -> dict[str, Texts]:
        return shortcuts.read(self._preferences.get(shortcuts.KEY, "{}"))

    def _follow(self, key: str) -> None:
        if key == shortcuts.KEY:
            before, self._chosen = self._chosen, self._read()
            for name in before.keys() | self._chosen.keys():
                if name in self._actions:
                    self._actions[name][1].setShortcuts([QKeySequence(key) for key in self.keys(name)])
            self.changed.emit()
