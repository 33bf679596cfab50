"""The menus, filled with what the features add."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu, QMenuBar

from app.model.text.language import tr
from app.model.text.mnemonics import distinct
from app.views.widgets.action_spec import ActionSpec, Submenu
from app.views.widgets.actions import Actions
from app.views.window.menus.marks import keep_apart

MENUS = {
    "File": tr("&File"),
    "Edit": tr("&Edit"),
    "Draw": tr("&Draw"),
    "View": tr("&View"),
    "Run": tr("&Run"),
    "Contours": tr("&Contours"),
    "Objects": tr("&Objects"),
    "Help": tr("&Help"),
}
"""Titles of the menus by the names that the specifications use, in their order."""

QUIT = "quit"
"""The action that is always the last of its menu."""


class Menus:
    """The menus of a window, made from specifications and their actions."""

    def __init__(self, bar: QMenuBar, specs: Iterable[ActionSpec | Submenu], actions: Actions) -> None:
        self._menus: dict[str, QMenu] = {}
        listed = list(specs)
        filled = [name for name in MENUS if any(spec.menu.partition(">")[0] == name for spec in listed)]
        for name, title in zip(filled, distinct([MENUS[name] for name in filled]), strict=True):
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
        for menu in self._menus.values():
            keep_apart(menu)

    def __getitem__(self, path: str) -> QMenu:
        """A menu by its path; a missing submenu is created."""
        if path not in self._menus:
            outer, _, title = path.rpartition(">")
            self._menus[path] = self[outer].addMenu(title)
        return self._menus[path]

    def add_section(self, path: str, actions: Iterable[QAction]) -> None:
        """Add other actions at the end of a menu, below a separator."""
        self[path].addSeparator()
        self[path].addActions(list(actions))


def _refill(menu: QMenu, spec: Submenu) -> None:
    menu.clear()
    spec.fill(menu)
