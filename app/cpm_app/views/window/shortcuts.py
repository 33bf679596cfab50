"""Keys of all actions and panels: the defaults, or those that the user has set in the preferences."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QAction, QKeySequence

from cpm_app.model.preferences import shortcuts
from cpm_app.model.preferences.shortcuts import ActionKeys
from cpm_app.model.text.keys import ActionName
from cpm_app.session.storage.preferences import Preferences
from cpm_app.views.widgets.actions import native_key_text
from cpm_core.numerics.types import Texts


class Shortcuts(QObject):
    """Keys of the actions, which follow the preference."""

    changed = Signal()

    def __init__(self, preferences: Preferences, parent: QObject) -> None:
        super().__init__(parent)
        self._preferences = preferences
        self._actions: dict[str, tuple[ActionKeys, QAction]] = {}
        self._chosen = self._read_keys()
        preferences.changed.connect(self._on_preference_changed)

    @property
    def actions(self) -> Sequence[ActionKeys]:
        """All actions that can have keys."""
        return [action for action, _ in self._actions.values()]

    def add_action(self, action: QAction, name: str, title: str, group: str) -> None:
        """Add an action that has its default keys."""
        self._actions[name] = (
            ActionKeys(name, title, group, tuple(key.toString() for key in action.shortcuts())),
            action,
        )
        action.setShortcuts([QKeySequence(key) for key in self.find_keys(name)])

    def find_keys(self, name: str) -> Texts:
        """Return the keys of an action."""
        return shortcuts.find_action_keys(self._actions[name][0], self._chosen)

    def describe_actions(self) -> dict[str, ActionName]:
        """Return titles and keys of the actions, as sentences mention them."""
        return {
            name: ActionName(native_key_text(next(iter(self.find_keys(name)), "")), action.title)
            for name, (action, _) in self._actions.items()
        }

    def find_holder(self, key: str, excluded: str) -> ActionKeys | None:
        """Find the action with a key, other than the one named `excluded`."""
        return shortcuts.find_key_holder(key, self.actions, self._chosen, excluded)

    def assign_key(self, name: str, key: str) -> None:
        """Give an action one key, or none if `key` is empty; another action with this key loses it."""
        self._store_keys(shortcuts.assign_key(key, self._actions[name][0], self.actions, self._chosen))

    def restore_default_keys(self, name: str) -> None:
        """Give an action its default keys; other actions with these keys lose them."""
        changed = {**self._chosen}
        changed.pop(name, None)
        default = self._actions[name][0].default
        for other in self.actions:
            kept = tuple(key for key in shortcuts.find_action_keys(other, changed) if key not in default)
            if other.name != name and kept != shortcuts.find_action_keys(other, changed):
                changed[other.name] = kept
        self._store_keys(changed)

    def reset(self) -> None:
        """Give all actions their default keys."""
        self._store_keys({})

    def _store_keys(self, chosen: shortcuts.CustomKeys) -> None:
        self._preferences.store_key(shortcuts.SHORTCUTS_KEY, shortcuts.encode_shortcuts(chosen))

    def _read_keys(self) -> dict[str, Texts]:
        return shortcuts.parse_shortcuts(self._preferences.read_key(shortcuts.SHORTCUTS_KEY, "{}"))

    def _on_preference_changed(self, key: str) -> None:
        if key == shortcuts.SHORTCUTS_KEY:
            before, self._chosen = self._chosen, self._read_keys()
            for name in before.keys() | self._chosen.keys():
                if name in self._actions:
                    self._actions[name][1].setShortcuts([QKeySequence(key) for key in self.find_keys(name)])
            self.changed.emit()
