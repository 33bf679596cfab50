"""The specification of an action: texts, keys, effect, and place in the menus."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtWidgets import QMenu

from app.model.state.situation import Condition, Situation, always
from app.model.text.keys import with_keys

TOGGLE, STATE = "toggle", "state"
"""Groups of actions that the user checks, and of those whose check mark follows `ActionSpec.holds`."""

LAYER = "layer_"
"""What the names of the actions that show or hide a layer begin with."""


@dataclass(frozen=True, slots=True, kw_only=True)
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
    do : callable
        Its effect; a toggle passes whether it is checked.
    shortcuts : tuple of str
        Keys; the first one is shown.
    tip : str
        One sentence for the tooltip and the status bar; it may name keys of actions (see `with_keys`).
    icon : str
        Name of the icon, empty for none.
    group : str
        Actions of the same group are alternatives; `TOGGLE` and `STATE` are independent check marks.
    checked : bool
        Whether it is initially checked.
    gap : bool
        Whether a separator is drawn above it.
    when : callable
        Situations in which it is enabled.
    holds : callable, optional
        Situations in which it is checked, for the group `STATE`.
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
