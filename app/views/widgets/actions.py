"""The Qt actions made from entries, shown as the situation demands."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from PySide6.QtGui import QAction, QActionGroup, QKeySequence
from PySide6.QtWidgets import QWidget

from app.model.state.situation import Situation
from app.views.theme.icons import icon
from app.views.theme.theme import Theme
from app.views.widgets.action_spec import STATE, TOGGLE, ActionSpec

PRIMARY = "run"
"""The action whose icon lies on the accent colour."""


class Actions:
    """One Qt action an entry.

    Parameters
    ----------
    parent : QWidget
        Window in which their keys work.
    entries : iterable of ActionSpec
        What there is.
    """

    def __init__(self, parent: QWidget, entries: Iterable[ActionSpec]) -> None:
        self._theme: Theme | None = None
        self._groups: dict[str, QActionGroup] = {}
        self._actions: dict[str, QAction] = {}
        self._entries: dict[str, ActionSpec] = {}
        self._icons: dict[str, str] = {}
        for entry in entries:
            assert entry.name not in self._entries, entry.name
            self._entries[entry.name] = entry
            self._actions[entry.name] = self._make(entry, parent)
        self._changing = [entry for entry in self._entries.values() if entry.worded or entry.holds or entry.pictured]

    def __getitem__(self, name: str) -> QAction:
        return self._actions[name]

    def __contains__(self, name: object) -> bool:
        return name in self._actions

    @property
    def entries(self) -> Iterator[ActionSpec]:
        """All entries in the order of the parts."""
        return iter(self._entries.values())

    def show(self, situation: Situation) -> None:
        """Enable what makes sense and word it accordingly."""
        for name, entry in self._entries.items():
            self._actions[name].setEnabled(entry.when(situation))
        for entry in self._changing:
            action = self._actions[entry.name]
            if entry.holds is not None:
                action.setChecked(entry.holds(situation))
            if entry.worded is not None and action.text() != (text := entry.worded(situation)):
                action.setText(text)
                action.setToolTip(tooltip(text, entry))
            if entry.pictured is not None and self._icons[entry.name] != (wanted := entry.pictured(situation)):
                self._icons[entry.name] = wanted
                self._tint(entry.name)

    def use_theme(self, theme: Theme) -> None:
        """Tint the icons."""
        self._theme = theme
        for name in self._icons:
            self._tint(name)

    def _make(self, entry: ActionSpec, parent: QWidget) -> QAction:
        action = QAction(entry.text, parent)
        action.setShortcuts([QKeySequence(keys) for keys in entry.shortcuts])
        if entry.group:
            action.setCheckable(True)
            action.setChecked(entry.checked)
        if entry.group and entry.group not in (TOGGLE, STATE):
            self._groups.setdefault(entry.group, QActionGroup(parent)).addAction(action)
        if entry.group == TOGGLE:
            action.toggled.connect(entry.do)
        else:
            action.triggered.connect(lambda checked=False: entry.do())
        if entry.short:
            action.setIconText(entry.short)
        if entry.icon:
            self._icons[entry.name] = entry.icon
        action.setStatusTip(entry.tip)
        action.setToolTip(tooltip(entry.text, entry))
        parent.addAction(action)
        return action

    def _tint(self, name: str) -> None:
        if self._theme is not None:
            colour = self._theme.accent_text if name == PRIMARY else self._theme.text
            self._actions[name].setIcon(icon(self._icons[name], colour, faded=self._theme.line))


def tooltip(text: str, entry: ActionSpec) -> str:
    """Name, key and meaning of an entry in one line."""
    keys = f" ({entry.shortcuts[0]})" if entry.shortcuts else ""
    return f"{text.replace('&', '').rstrip('…')}{keys}: {entry.tip}"
