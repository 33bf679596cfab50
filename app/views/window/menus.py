"""The menus, filled with what the features add."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu, QMenuBar

from app.model.text.language import tr
from app.views.widgets.action_spec import ActionSpec, Submenu
from app.views.widgets.actions import Actions

MENUS = {
    "File": tr("&File"),
    "Edit": tr("&Edit"),
    "Draw": tr("&Draw"),
    "View": tr("&View"),
    "Run": tr("&Run"),
    "Contours": tr("&Contours"),
    "Help": tr("&Help"),
}
"""Menus by the names that the specifications use, in the order in which they stand."""

QUIT = "quit"
"""The action that stands last in its menu, whatever features add more to it."""


class Menus:
    """The menus of a window.

    Parameters
    ----------
    bar : QMenuBar
        Where they hang.
    specs : iterable of ActionSpec or Submenu
        What stands in them.
    actions : Actions
        The actions of these specifications.
    """

    def __init__(self, bar: QMenuBar, specs: Iterable[ActionSpec | Submenu], actions: Actions) -> None:
        self._menus: dict[str, QMenu] = {}
        listed = list(specs)
        for name, title in MENUS.items():
            if any(spec.menu.partition(">")[0] == name for spec in listed):
                self._menus[name] = bar.addMenu(title)
        for spec in sorted(listed, key=lambda spec: spec.name == QUIT):
            menu = self[spec.menu]
            if spec.gap and not menu.isEmpty():
                menu.addSeparator()
            if isinstance(spec, Submenu):
                inner = menu.addMenu(spec.text)
                inner.setToolTipsVisible(True)
                inner.aboutToShow.connect(partial(_refill, inner, spec))
            else:
                menu.addAction(actions[spec.name])

    def __getitem__(self, path: str) -> QMenu:
        """A menu by its name, made when it is not there and lies within another."""
        if path not in self._menus:
            outer, _, title = path.rpartition(">")
            self._menus[path] = self[outer].addMenu(title)
        return self._menus[path]

    def add_section(self, path: str, actions: Iterable[QAction]) -> None:
        """Add actions of another origin at the end of a menu, below a line."""
        self[path].addSeparator()
        self[path].addActions(list(actions))


def _refill(menu: QMenu, spec: Submenu) -> None:
    menu.clear()
    spec.fill(menu)
