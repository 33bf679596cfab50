"""Actions: their specifications, the Qt actions made from them, keys as text, and what menus need of widgets."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from functools import partial
from typing import Protocol, runtime_checkable

from PySide6.QtCore import QPoint
from PySide6.QtGui import QAction, QActionGroup, QKeySequence
from PySide6.QtWidgets import QMenu, QToolBar, QToolButton, QWidget

from cpm_app.model.state.situation import (
    ICONS_IN_VOLUMES,
    NOT_IN_VOLUMES,
    OTHERWISE_IN_VOLUMES,
    Condition,
    Situation,
    always,
    has_volume,
)
from cpm_app.model.text.keys import with_keys
from cpm_app.model.text.language import from_core
from cpm_app.views.theme.icons import icon
from cpm_app.views.theme.theme import Theme
from cpm_app.views.widgets.turns import Turns
from cpm_core.numerics.types import Callback, Texts, frozen


def native(key: str) -> str:
    """A key as people call it here."""
    return QKeySequence(key).toString(QKeySequence.SequenceFormat.NativeText)


LAYER = "layer_"
"""What the names of the actions that show or hide a layer begin with."""


@frozen
class ActionSpec:
    """One action.

    Attributes
    ----------
    name : str
        Name in code.
    menu : str
        Its menu; ``"File>Open sample"`` names a submenu, ``">Timeline"`` a group in the list of keys, without a menu.
    text : str
        Text in the menu; in English, or in the language of the window already.
    tip : str
        One sentence for the tooltip and the status bar; it may name keys of actions (see `with_keys`).
    do : callable
        Its effect.
    keys : str
        Keys with spaces between them; the first one is shown.
    icon : str
        Name of the icon, empty for none.
    group : str
        Actions of the same group are alternatives; empty for none.
    checked : bool
        Whether it is the initial one of its group.
    gap : bool
        Whether a separator is drawn above it.
    when : callable
        Situations in which it is enabled.
    there : callable
        Situations in which it is in the menus, such as that a volume is open; else it is hidden.
    holds : callable, optional
        Situations in which it has a check mark.
    worded : callable, optional
        Its text in a situation, where it changes.
    pictured : callable, optional
        Its icon in a situation, where it changes.
    short : str
        Text on a tool button where that of the menu is too long.
    """

    name: str
    menu: str
    text: str
    tip: str
    do: Callback
    keys: str = ""
    icon: str = ""
    group: str = ""
    checked: bool = False
    gap: bool = False
    when: Condition = always
    there: Condition = always
    holds: Condition | None = None
    worded: Callable[[Situation], str] | None = None
    pictured: Callable[[Situation], str] | None = None
    short: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "text", from_core(self.text))
        object.__setattr__(self, "tip", from_core(self.tip))

    @property
    def shortcuts(self) -> Texts:
        """Its keys, one by one."""
        return tuple(self.keys.split())

    @property
    def title(self) -> str:
        """Its text without the marks of menus."""
        return self.text.replace("&", "").rstrip("…")


@frozen
class Submenu:
    """A submenu that `fill` fills each time before it opens; the rest is as in `ActionSpec`."""

    name: str
    menu: str
    text: str
    fill: Callable[[QMenu], None]
    gap: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "text", from_core(self.text))


PRIMARY = "run"
"""The action whose button has the accent color."""


class Actions(dict[str, QAction]):
    """One Qt action for each specification; their keys work in the window `parent`."""

    def __init__(self, parent: QWidget, specs: Iterable[ActionSpec]) -> None:
        super().__init__()
        self._theme: Theme | None = None
        self._limited = False
        self._groups: dict[str, QActionGroup] = {}
        self.specs: dict[str, ActionSpec] = {}
        """All of them by their names, in the order of the features."""
        self._icons: dict[str, str] = {}
        for spec in specs:
            assert spec.name not in self.specs, spec.name
            self.specs[spec.name] = spec
            self[spec.name] = self._make(spec, parent)

    def show(self, situation: Situation) -> None:
        """Update state, text and icon of all actions."""
        volume = has_volume(situation)
        self._show_limits(volume)
        for name, spec in self.specs.items():
            action = self[name]
            action.setVisible(spec.there(situation) and not (volume and name in NOT_IN_VOLUMES))
            action.setEnabled(spec.when(situation))
            if spec.holds is not None:
                action.setChecked(spec.holds(situation))
            if spec.worded is not None and _plain(action.text()) != _plain(text := spec.worded(situation)):
                action.setText(text)
                self._tell(name)
            if spec.pictured is not None and self._icons[name] != (wanted := spec.pictured(situation)):
                self._icons[name] = wanted
                self._tint(name)

    def _show_limits(self, volume: bool) -> None:
        """Name what does something else in volumes; it returns with the next image."""
        if volume == self._limited:
            return
        self._limited = volume
        for name, (in_volume, _) in OTHERWISE_IN_VOLUMES.items():
            action, text = self[name], in_volume if volume else self.specs[name].text
            on_button = _plain(text) if action.iconText() == _plain(action.text()) else action.iconText()
            action.setText(text)
            action.setIconText(on_button)
            if name in ICONS_IN_VOLUMES:
                self._icons[name] = ICONS_IN_VOLUMES[name] if volume else self.specs[name].icon
                self._tint(name)
            self._tell(name)

    def show_keys(self) -> None:
        """Say the keys as they are now in all tips, which may name those of other actions."""
        for name in self.specs:
            self._tell(name)

    def use_theme(self, theme: Theme, turns: Turns) -> None:
        """Tint the icons in later turns, those on buttons first; in a new window these are tinted immediately."""
        begins, self._theme = self._theme is None, theme

        def later(name: str) -> bool:
            return not any(isinstance(it, QToolBar | QToolButton) for it in self[name].associatedObjects())

        for name in sorted(self._icons, key=later):
            if begins and not later(name):
                self._tint(name)
            else:
                turns.ask(partial(self._tint, name))

    def _make(self, spec: ActionSpec, parent: QWidget) -> QAction:
        action = QAction(spec.text, parent)
        action.setShortcuts([QKeySequence(keys) for keys in spec.shortcuts])
        if spec.group or spec.holds:
            action.setCheckable(True)
            action.setChecked(spec.checked)
            action.setAutoRepeat(False)  # a key that is held must not switch back and forth
        if spec.group:
            self._groups.setdefault(spec.group, QActionGroup(parent)).addAction(action)
        action.triggered.connect(lambda checked=False: spec.do())
        if spec.short:
            action.setIconText(spec.short)
        if spec.icon:
            self._icons[spec.name] = spec.icon
        parent.addAction(action)
        return action

    def _tell(self, name: str) -> None:
        """Set the tips of an action, in a volume those that hold there."""
        action, tip = self[name], self.specs[name].tip
        if self._limited:
            tip = OTHERWISE_IN_VOLUMES.get(name, ("", tip))[1]
        said, key = with_keys(tip), action.shortcut().toString(QKeySequence.SequenceFormat.NativeText)
        action.setStatusTip(said)
        action.setToolTip(f"{_plain(action.text()).rstrip('…')}{f' ({key})' if key else ''}: {said}")

    def _tint(self, name: str) -> None:
        if self._theme is not None:
            color = self._theme.accent_text if name == PRIMARY else self._theme.text
            self[name].setIcon(icon(self._icons[name], color, faded=self._theme.line))


def _plain(text: str) -> str:
    """A text without its mnemonic, which a menu may have moved, and which Chinese and Japanese have in parentheses."""
    return re.sub(r"\(&\w\)", "", text).replace("&", "")


def add_choice(menu: QWidget, text: str, do: Callback, tip: str = "", checked: bool | None = None) -> QAction:
    """Add something to a menu that is filled whenever it opens, or to what comes first in the menu of a widget.

    There is room for a check mark unless `checked` is None.
    """
    action = menu.addAction(text)
    action.setToolTip(tip)
    action.setStatusTip(tip)
    action.setCheckable(checked is not None)
    action.setChecked(bool(checked))
    action.triggered.connect(lambda _=False: do())
    return action


@runtime_checkable
class MenuOwner(Protocol):
    """A widget with a menu; its own actions (`QWidget.actions`) come first in it."""

    def menu_at(self, point: QPoint | None) -> tuple[str, QPoint]:
        """Choose what lies at a point of the widget, or tell what is chosen for None, as keys ask.

        Returns the name of the thing, of which the menu knows the actions, or an empty text for nothing; and where
        the menu opens.
        """
