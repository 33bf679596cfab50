"""Actions: their specifications, the Qt actions created from them, keys as text, and owners of context menus."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from typing import Protocol, runtime_checkable

from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QAction, QActionGroup, QKeySequence, QPalette
from PySide6.QtWidgets import QMenu, QSizePolicy, QToolButton, QWidget

from cpm_app.model.state.situation import (
    HIDDEN_IN_VOLUMES,
    ICONS_IN_VOLUMES,
    TEXTS_IN_VOLUMES,
    Condition,
    Situation,
    always,
    has_volume,
)
from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import translate_core_text
from cpm_app.views.theme.icons import load_icon
from cpm_core.numerics.types import Callback, Texts, frozen


def native_key_text(key: str) -> str:
    """Return a key as the desktop writes it."""
    return QKeySequence(key).toString(QKeySequence.SequenceFormat.NativeText)


LAYER_ACTION_PREFIX = "layer_"
"""Start of the names of the actions that show or hide a layer."""


@frozen
class ActionSpec:
    """One action.

    Attributes
    ----------
    name : str
        Name in code.
    menu : str
        Its menu; ``"File>Open sample"`` is a submenu, ``">Timeline"`` a group in the list of keys without a menu.
    text : str
        Text in the menu, in English or already translated.
    tip : str
        One sentence for the tooltip and the status bar; it may name keys of actions (see `insert_keys`).
    do : callable
        Function that performs the action.
    keys : str
        Keys separated by spaces; the first one is shown.
    icon : str
        Name of the icon, empty for none.
    group : str
        Actions of the same group are alternatives; empty for none.
    checked : bool
        Whether it is the initial action of its group.
    gap : bool
        Whether a separator is drawn above it.
    when : callable
        Situations in which it is enabled.
    visible_when : callable
        Situations in which it is in the menus, such as that a volume is open; otherwise it is hidden.
    checked_when : callable, optional
        Situations in which it has a check mark.
    text_for : callable, optional
        Returns its text in a situation, if that changes.
    icon_for : callable, optional
        Returns its icon in a situation, if that changes.
    short : str
        Text on a tool button if that of the menu is too long.
    shown_key : str
        Key shown in the menu that does the same on the canvas, where it may also mean something else.
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
    visible_when: Condition = always
    checked_when: Condition | None = None
    text_for: Callable[[Situation], str] | None = None
    icon_for: Callable[[Situation], str] | None = None
    short: str = ""
    shown_key: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "text", translate_core_text(self.text))
        object.__setattr__(self, "tip", translate_core_text(self.tip))

    @property
    def shortcuts(self) -> Texts:
        """Its keys, one by one."""
        return tuple(self.keys.split())

    @property
    def title(self) -> str:
        """Its text without mnemonic and ellipsis."""
        return self.text.replace("&", "").rstrip("…")


@frozen
class Submenu:
    """A submenu that `fill` fills whenever it opens; the other fields are those of `ActionSpec`."""

    name: str
    menu: str
    text: str
    fill: Callable[[QMenu], None]
    gap: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "text", translate_core_text(self.text))


PRIMARY_ACTION = "run"
"""Name of the action whose button has the accent color."""


class Actions(dict[str, QAction]):
    """Qt actions by the names of their specifications; their keys work in the window `parent`."""

    def __init__(self, parent: QWidget, specs: Iterable[ActionSpec]) -> None:
        super().__init__()
        self._groups: dict[str, QActionGroup] = {}
        self.specs: dict[str, ActionSpec] = {}
        """Specifications by name, in the order of the features."""
        self._looks: dict[str, tuple[str, str, str]] = {}
        """Text, tip and icon of each action in the current situation."""
        for spec in specs:
            assert spec.name not in self.specs, spec.name
            self.specs[spec.name] = spec
            self[spec.name] = self._create_action(spec, parent)
            if spec.icon:
                self._show_icon(spec.name)

    def show_situation(self, situation: Situation) -> None:
        """Update state, text and icon of all actions, some of which are others in volumes."""
        in_volume = has_volume(situation)
        for name, spec in self.specs.items():
            action = self[name]
            action.setVisible(spec.visible_when(situation) and not (in_volume and name in HIDDEN_IN_VOLUMES))
            action.setEnabled(spec.when(situation))
            if spec.checked_when is not None:
                action.setChecked(spec.checked_when(situation))
            text, tip, icon = spec.text, spec.tip, spec.icon
            if in_volume:
                text, tip = TEXTS_IN_VOLUMES.get(name, (text, tip))
                icon = ICONS_IN_VOLUMES.get(name, icon)
            if spec.text_for is not None:
                text = spec.text_for(situation)
            if spec.icon_for is not None:
                icon = spec.icon_for(situation)
            before, self._looks[name] = self._looks[name], (text, tip, icon)
            if text != before[0]:
                titled = action.iconText() == _without_mnemonic(before[0])
                action.setText(text)
                if titled:  # and not given another text for its button
                    action.setIconText(_without_mnemonic(text))
            if icon != before[2]:
                self._show_icon(name)
            if (text, tip) != before[:2]:
                self._update_tips(name)

    def show_keys(self) -> None:
        """Name the current keys in all tips, which may refer to other actions."""
        for name in self.specs:
            self._update_tips(name)

    def _create_action(self, spec: ActionSpec, parent: QWidget) -> QAction:
        shown = f"\t{native_key_text(spec.shown_key)}" if spec.shown_key else ""
        action = QAction(spec.text + shown, parent)
        action.setShortcuts([QKeySequence(keys) for keys in spec.shortcuts])
        if spec.group or spec.checked_when:
            action.setCheckable(True)
            action.setChecked(spec.checked)
            action.setAutoRepeat(False)  # holding the key must not switch back and forth
        if spec.group:
            self._groups.setdefault(spec.group, QActionGroup(parent)).addAction(action)
        action.triggered.connect(lambda checked=False: spec.do())
        if spec.short:
            action.setIconText(spec.short)
        self._looks[spec.name] = spec.text, spec.tip, spec.icon
        parent.addAction(action)
        return action

    def _update_tips(self, name: str) -> None:
        """Set the tips of an action."""
        action, (text, tip, _) = self[name], self._looks[name]
        words, key = insert_keys(tip), action.shortcut().toString(QKeySequence.SequenceFormat.NativeText)
        action.setStatusTip(words)
        action.setToolTip(f"{_without_mnemonic(text).rstrip('…')}{f' ({key})' if key else ''}: {words}")

    def _show_icon(self, name: str) -> None:
        role = QPalette.ColorRole.HighlightedText if name == PRIMARY_ACTION else QPalette.ColorRole.WindowText
        self[name].setIcon(load_icon(self._looks[name][2], role))


def _without_mnemonic(text: str) -> str:
    """Return a text without its mnemonic, which Chinese and Japanese put in parentheses."""
    return re.sub(r"\(&\w\)", "", text).replace("&", "")


class ActionButton(QToolButton):
    """Button of an action of the window, by its name; the window connects it when it has all actions."""

    def __init__(self, name: str, style: Qt.ToolButtonStyle = Qt.ToolButtonStyle.ToolButtonTextOnly) -> None:
        super().__init__(toolButtonStyle=style, autoRaise=style == Qt.ToolButtonStyle.ToolButtonIconOnly)
        self.setObjectName(name)
        if not self.autoRaise():
            self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)

    def use_action(self, action: QAction) -> None:
        """Perform an action, and be there while it is available."""
        self.setDefaultAction(action)
        action.visibleChanged.connect(lambda: self.setVisible(action.isVisible()))


def add_menu_action(menu: QWidget, text: str, do: Callback, tip: str = "", checked: bool | None = None) -> QAction:
    """Add an action to a menu, or to the start of the context menu of a widget.

    It has a check mark unless `checked` is None.
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
    """A widget with a context menu that begins with its own actions (`QWidget.actions`)."""

    def menu_at(self, point: QPoint | None) -> tuple[str, QPoint]:
        """Select the item at a point of the widget, or keep the selection for None, as when a key opens the menu.

        Returns
        -------
        name : str
            Name of the item in the table of context menus; empty for no item.
        point : QPoint
            Point of the widget at which the menu opens.
        """
