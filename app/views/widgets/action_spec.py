"""The specification of an action: texts, keys, effect, and place in the menus."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtWidgets import QMenu

from app.model.state.situation import Condition, Situation, always
from app.model.text.keys import with_keys

LAYER = "layer_"
"""What the names of the actions that show or hide a layer begin with."""


@dataclass(frozen=True, slots=True)
class ActionSpec:
    """One action.

    Attributes
    ----------
    name : str
        Name in code.
    menu : str
        Its menu; ``"File>Open sample"`` names a submenu.
    text : str
        Text in the menu.
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
    do: Callable[[], object]
    keys: str = ""
    icon: str = ""
    group: str = ""
    checked: bool = False
    gap: bool = False
    when: Condition = always
    holds: Condition | None = None
    worded: Callable[[Situation], str] | None = None
    pictured: Callable[[Situation], str] | None = None
    short: str = ""

    @property
    def shortcuts(self) -> tuple[str, ...]:
        """Its keys, one by one."""
        return tuple(self.keys.split())

    @property
    def title(self) -> str:
        """Its text without the marks of menus."""
        return self.text.replace("&", "").rstrip("…")

    @property
    def said(self) -> str:
        """Its tip with the keys of actions as they are now."""
        return with_keys(self.tip)


@dataclass(frozen=True, slots=True, kw_only=True)
class Submenu:
    """A submenu that `fill` fills each time before it opens; the rest is as in `ActionSpec`."""

    name: str
    menu: str
    text: str
    fill: Callable[[QMenu], None]
    gap: bool = False
