"""The Qt actions made from their specifications; their state follows the situation."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from PySide6.QtGui import QAction, QActionGroup, QKeySequence
from PySide6.QtWidgets import QWidget

from app.model.state.situation import Situation, always
from app.model.state.volume_limits import ICONS_IN_VOLUMES, NOT_IN_VOLUMES, OTHERWISE_IN_VOLUMES, has_volume
from app.views.theme.icons import icon
from app.views.theme.theme import Theme
from app.views.widgets.action_spec import STATE, TOGGLE, ActionSpec
from app.views.widgets.key_text import native

PRIMARY = "run"
"""The action whose button has the accent color."""


class Actions:
    """One Qt action for each specification; their keys work in the window `parent`."""

    def __init__(self, parent: QWidget, specs: Iterable[ActionSpec]) -> None:
        self._theme: Theme | None = None
        self._limited = False
        self._groups: dict[str, QActionGroup] = {}
        self._actions: dict[str, QAction] = {}
        self._specs: dict[str, ActionSpec] = {}
        self._icons: dict[str, str] = {}
        for spec in specs:
            assert spec.name not in self._specs, spec.name
            self._specs[spec.name] = spec
            self._actions[spec.name] = self._make(spec, parent)
        self._changing = [spec for spec in self._specs.values() if spec.worded or spec.holds or spec.pictured]
        self._conditional = [
            (self._actions[name], spec.when) for name, spec in self._specs.items() if spec.when is not always
        ]

    def __getitem__(self, name: str) -> QAction:
        return self._actions[name]

    def __contains__(self, name: object) -> bool:
        return name in self._actions

    @property
    def specs(self) -> Iterator[ActionSpec]:
        """All of them, in the order of the features."""
        return iter(self._specs.values())

    def show(self, situation: Situation) -> None:
        """Update state, text and icon of all actions."""
        for action, allows in self._conditional:
            action.setEnabled(allows(situation))
        self._show_limits(has_volume(situation))
        for spec in self._changing:
            action = self._actions[spec.name]
            if spec.holds is not None:
                action.setChecked(spec.holds(situation))
            if spec.worded is not None and action.text() != (text := spec.worded(situation)):
                action.setText(text)
                action.setToolTip(tooltip(text, spec))
            if spec.pictured is not None and self._icons[spec.name] != (wanted := spec.pictured(situation)):
                self._icons[spec.name] = wanted
                self._tint(spec.name)

    def _show_limits(self, volume: bool) -> None:
        """Gray what volumes lack, with the reason in place of the tip; it returns with the next image."""
        if not (volume or self._limited):
            return
        for name, (text, tip) in OTHERWISE_IN_VOLUMES.items() if volume != self._limited else ():
            action, spec = self._actions[name], self._specs[name]
            told = replace(spec, text=text, tip=tip) if volume else spec
            action.setText(told.text)
            action.setStatusTip(told.tip)
            action.setToolTip(tooltip(told.text, told))
            if name in ICONS_IN_VOLUMES:
                self._icons[name] = ICONS_IN_VOLUMES[name] if volume else spec.icon
                self._tint(name)
        for name in NOT_IN_VOLUMES.keys() & self._actions.keys():
            action, spec = self._actions[name], self._specs[name]
            if volume:
                action.setEnabled(False)
            elif spec.when is always:
                action.setEnabled(True)
            if volume != self._limited:
                told = replace(spec, tip=NOT_IN_VOLUMES[name]) if volume else spec
                action.setStatusTip(told.tip)
                action.setToolTip(tooltip(action.text(), told))
        self._limited = volume

    def use_keys(self, name: str, keys: tuple[str, ...]) -> None:
        """Give an action other keys; menus and tooltips follow, and all that shows `specs`."""
        spec = self._specs[name] = replace(self._specs[name], shortcuts=keys)
        action = self._actions[name]
        action.setShortcuts([QKeySequence(key) for key in keys])
        action.setToolTip(tooltip(action.text(), spec))
        self._changing = [self._specs[known.name] for known in self._changing]

    def use_theme(self, theme: Theme) -> None:
        """Tint the icons."""
        self._theme = theme
        for name in self._icons:
            self._tint(name)

    def _make(self, spec: ActionSpec, parent: QWidget) -> QAction:
        action = QAction(spec.text, parent)
        action.setShortcuts([QKeySequence(keys) for keys in spec.shortcuts])
        if spec.group:
            action.setCheckable(True)
            action.setChecked(spec.checked)
            action.setAutoRepeat(False)  # a key that is held must not switch back and forth
        if spec.group and spec.group not in (TOGGLE, STATE):
            self._groups.setdefault(spec.group, QActionGroup(parent)).addAction(action)
        if spec.group == TOGGLE:
            action.toggled.connect(spec.do)
        else:
            action.triggered.connect(lambda checked=False: spec.do())
        if spec.short:
            action.setIconText(spec.short)
        if spec.icon:
            self._icons[spec.name] = spec.icon
        action.setStatusTip(spec.tip)
        action.setToolTip(tooltip(spec.text, spec))
        parent.addAction(action)
        return action

    def _tint(self, name: str) -> None:
        if self._theme is not None:
            color = self._theme.accent_text if name == PRIMARY else self._theme.text
            self._actions[name].setIcon(icon(self._icons[name], color, faded=self._theme.line))


def tooltip(text: str, spec: ActionSpec) -> str:
    """Name, key and tip of an action in one line."""
    keys = f" ({native(spec.shortcuts[0])})" if spec.shortcuts else ""
    return f"{text.replace('&', '').rstrip('…')}{keys}: {spec.tip}"
