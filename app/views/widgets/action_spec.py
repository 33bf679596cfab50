"""The specification of an action: its words and keys, what it does, and where it stands in the menus."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtWidgets import QMenu

from app.model.state.situation import Condition, Situation, always

TOGGLE, STATE = "toggle", "state"
"""Groups of actions that are checkable by themselves, and of those that are checked as `ActionSpec.holds` says."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ActionSpec:
    """One action.

    Attributes
    ----------
    name : str
        What it is called in code.
    menu : str
        Menu that it stands in; ``"File>Open sample"`` names a menu within a menu.
    text : str
        Text in the menu.
    do : callable
        What it does; a toggle is given whether it is checked.
    shortcuts : tuple of str
        Keys, the first of which is shown.
    tip : str
        One sentence for the tooltip and the status bar.
    icon : str
        Name of the icon, empty for none.
    group : str
        Actions of the same group are alternatives; `TOGGLE` makes it checkable by itself, `STATE` checked as `holds`
        says.
    checked : bool
        Whether it is checked at first.
    gap : bool
        Whether a line is drawn above it.
    when : callable
        Situations in which it makes sense.
    holds : callable, optional
        Situations in which it is checked, for the group `STATE`.
    worded : callable, optional
        Its text in a situation, where that changes.
    pictured : callable, optional
        Its icon in a situation, where that changes.
    short : str
        Text on a button of a tool bar where that of the menu is too long.
    """

    name: str
    menu: str
    text: str
    do: Callable[..., object]
    shortcuts: tuple[str, ...] = ()
    tip: str = ""
    icon: str = ""
    group: str = ""
    checked: bool = False
    gap: bool = False
    when: Condition = always
    holds: Condition | None = None
    worded: Callable[[Situation], str] | None = None
    pictured: Callable[[Situation], str] | None = None
    short: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Submenu:
    """A menu within a menu whose content is only known when it is opened.

    Attributes
    ----------
    name : str
        What it is called in code.
    menu, text : str
        Menu that it stands in, and its title.
    fill : callable
        Given the empty menu before it is shown.
    gap : bool
        Whether a line is drawn above it.
    """

    name: str
    menu: str
    text: str
    fill: Callable[[QMenu], None]
    gap: bool = False
