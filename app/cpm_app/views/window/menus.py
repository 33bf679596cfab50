"""Menu bar, and context menus of the item under the pointer or with the keyboard focus."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import partial

from PySide6.QtCore import QEvent, QObject, QPoint
from PySide6.QtGui import QAction, QContextMenuEvent
from PySide6.QtWidgets import QApplication, QMenu, QMenuBar, QWidget

from cpm_app.model.text.language import tr
from cpm_app.views.widgets.actions import Actions, ActionSpec, MenuOwner, Submenu
from cpm_core.numerics.types import Texts

MENU_TITLES = {
    "File": tr("&File"),
    "Edit": tr("&Edit"),
    "Tools": tr("&Tools"),
    "View": tr("&View"),
    "Run": tr("&Run"),
    "Objects": tr("&Objects"),
    "Help": tr("&Help"),
}
"""Titles of the menus, in their order, by the names that the specifications use."""

QUIT_ACTION = "quit"
"""Name of the action that is always the last of its menu."""


def refill_submenu(menu: QMenu, spec: Submenu) -> None:
    """Clear a submenu and fill it again."""
    menu.clear()
    spec.fill(menu)


class Menus:
    """Menus of a window, created from specifications and their actions."""

    def __init__(self, bar: QMenuBar, specs: Iterable[ActionSpec | Submenu], actions: Actions) -> None:
        self._menus: dict[str, QMenu] = {}
        for name, title in MENU_TITLES.items():
            self._menus[name] = bar.addMenu(title)
        for spec in sorted(specs, key=lambda spec: spec.name == QUIT_ACTION):
            if not spec.menu or spec.menu.startswith(">"):
                continue
            menu = self[spec.menu]
            if spec.gap and not menu.isEmpty():
                menu.addSeparator()
            if isinstance(spec, Submenu):
                inner = menu.addMenu(spec.text)
                inner.setToolTipsVisible(True)
                inner.aboutToShow.connect(partial(refill_submenu, inner, spec))
            else:
                menu.addAction(actions[spec.name])

    def __getitem__(self, path: str) -> QMenu:
        """Return a menu by its path; create a missing submenu."""
        if path not in self._menus:
            outer, _, title = path.rpartition(">")
            self._menus[path] = self[outer].addMenu(title)
        return self._menus[path]


_RUN_MENU_ACTIONS = ("run", "step", "reset")
"""Actions of the run in the menus of several items."""

CONTEXT_MENU_ACTIONS: Mapping[str, Texts] = {
    "image": (*_RUN_MENU_ACTIONS, "", "undo", "redo", "", "fit", "copy_view", "export", "",
              "layer_particles", "layer_forces"),
    "shape": ("enlarge", "shrink", "delete", "", *_RUN_MENU_ACTIONS),
    "charge": ("enlarge", "shrink", "delete", "", "layer_potential", "layer_field"),
    "object": ("accept", "reject", "name_object", "object_class", "object_color", "", "merge_objects",
               "objects_alike", "", "freeze_object", "hide_object", "use_as", "skeleton", "",
               "delete_object"),
    "step": ("timeline_rename", "timeline_parameters", "timeline_delete", "", "export"),
    "space": ("space_whole", "space_along_0", "space_along_1", "space_along_2", "", "space_particles", "space_surface",
              "space_objects", "space_slices", "space_projection", "space_box", "", "copy_space", "export"),
}  # fmt: skip
"""Names of the actions and submenus for each kind of item; an empty name is a separator."""


class ContextMenus(QObject):
    """Opens the context menu of an item; `general` are the actions where there is no item."""

    def __init__(
        self, parent: QWidget, specs: Iterable[ActionSpec | Submenu], actions: Actions, general: Sequence[QAction]
    ) -> None:
        super().__init__(parent)
        self._parent = parent
        self._actions = actions
        self._submenus = {spec.name: spec for spec in specs if isinstance(spec, Submenu)}
        self._general = general
        self.menu: QMenu | None = None

    def watch_widgets(self, *widgets: QWidget) -> None:
        """Open menus on these widgets and on all widgets inside them."""
        for widget in widgets:
            widget.installEventFilter(self)

    def open_menu_at(self, widget: QWidget | None, place: QPoint | None = None) -> None:
        """Open the menu of the item at a point of the screen in a widget, or of the selected item."""
        owner = widget
        while owner is not None:
            if isinstance(owner, MenuOwner):
                item, at = owner.menu_at(None if place is None else owner.mapFromGlobal(place))
                if item:
                    self._show_menu(item, owner, owner.mapToGlobal(at) if place is None else place)
                    return
            owner = owner.parentWidget()
        if widget is not None:
            middle = widget.mapToGlobal(widget.rect().center())
            self._show_menu("", self._parent, middle if place is None else place)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Open the menu unless a widget below has opened one."""
        if not isinstance(event, QContextMenuEvent) or not isinstance(watched, QWidget):
            return False
        if event.reason() == QContextMenuEvent.Reason.Keyboard:
            self.open_menu_at(QApplication.focusWidget())
        else:
            self.open_menu_at(watched.childAt(event.pos()) or watched, event.globalPos())
        event.accept()
        return True

    def _show_menu(self, item: str, owner: QWidget, place: QPoint) -> None:
        menu = QMenu(self._parent, toolTipsVisible=True)
        own = owner.actions() if item else self._general
        menu.addActions(list(own))
        menu.addSeparator()
        for name in CONTEXT_MENU_ACTIONS.get(item, ()):
            if name in self._actions:
                menu.addAction(self._actions[name])
            elif name in self._submenus:
                self._submenus[name].fill(menu.addMenu(self._submenus[name].text))
            else:
                menu.addSeparator()
        menu.aboutToHide.connect(menu.deleteLater)
        self.menu = menu
        menu.popup(place)
