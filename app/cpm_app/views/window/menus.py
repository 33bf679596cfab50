"""The menu bar, and the menus of what lies under the pointer or has the keyboard."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import partial

from PySide6.QtCore import QEvent, QObject, QPoint
from PySide6.QtGui import QAction, QContextMenuEvent
from PySide6.QtWidgets import QApplication, QMenu, QMenuBar, QWidget

from cpm_app.model.text.keys import distinct
from cpm_app.model.text.language import tr
from cpm_app.views.widgets.actions import Actions, ActionSpec, MenuOwner, Submenu
from cpm_core.numerics.types import Texts


def keep_apart(menu: QMenu) -> None:
    """Let no letter choose two of the visible entries, each time the menu opens: other ones may be visible then."""

    def tell_apart() -> None:
        visible = [action for action in menu.actions() if action.isVisible() and not action.isSeparator()]
        for action, text in zip(visible, distinct([action.text() for action in visible]), strict=True):
            if text != action.text():
                action.setText(text)

    menu.aboutToShow.connect(tell_apart)


MENUS = {
    "File": tr("&File"),
    "Edit": tr("&Edit"),
    "Tools": tr("&Tools"),
    "View": tr("&View"),
    "Run": tr("&Run"),
    "Objects": tr("&Objects"),
    "Help": tr("&Help"),
}
"""Titles of the menus by the names that the specifications use, in their order."""

QUIT = "quit"
"""The action that is always the last of its menu."""


def refill(menu: QMenu, spec: Submenu) -> None:
    """Fill a submenu in place of what it had."""
    menu.clear()
    spec.fill(menu)


class Menus:
    """The menus of a window, made from specifications and their actions."""

    def __init__(self, bar: QMenuBar, specs: Iterable[ActionSpec | Submenu], actions: Actions) -> None:
        self._menus: dict[str, QMenu] = {}
        for name, title in zip(MENUS, distinct([*MENUS.values()]), strict=True):
            self._menus[name] = bar.addMenu(title)
        for spec in sorted(specs, key=lambda spec: spec.name == QUIT):
            if not spec.menu or spec.menu.startswith(">"):
                continue
            menu = self[spec.menu]
            if spec.gap and not menu.isEmpty():
                menu.addSeparator()
            if isinstance(spec, Submenu):
                inner = menu.addMenu(spec.text)
                inner.setToolTipsVisible(True)
                inner.aboutToShow.connect(partial(refill, inner, spec))
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


_RUN = ("run", "step", "reset")

THINGS: Mapping[str, Texts] = {
    "image": (*_RUN, "", "undo", "redo", "", "fit", "copy_view", "export", "", "layer_particles", "layer_forces"),
    "shape": ("enlarge", "shrink", "delete", "", *_RUN),
    "charge": ("enlarge", "shrink", "delete", "", "layer_potential", "layer_field"),
    "object": ("accept", "reject", "name_object", "object_class", "object_color", "", "merge_objects", "close_contours",
               "objects_alike", "change_object", "", "freeze_object", "hide_object", "use_as", "skeleton", "",
               "delete_object"),
    "step": ("timeline_parameters", "timeline_delete", "", "export"),
    "space": ("space_whole", "space_along_0", "space_along_1", "space_along_2", "", "space_particles", "space_surface",
              "space_objects", "space_slices", "space_projection", "space_box", "", "copy_space", "export"),
    "parameter": (),
}  # fmt: skip
"""Names of actions and submenus by thing; an empty name is a line between groups. An action is a thing, too."""


class ContextMenus(QObject):
    """Opens the menu of a thing; `general` are the actions where nothing is known of a thing."""

    def __init__(
        self, parent: QWidget, specs: Iterable[ActionSpec | Submenu], actions: Actions, general: Sequence[QAction]
    ) -> None:
        super().__init__(parent)
        self._parent = parent
        self._actions = actions
        self._submenus = {spec.name: spec for spec in specs if isinstance(spec, Submenu)}
        self._general = general
        self.menu: QMenu | None = None

    def watch(self, *widgets: QWidget) -> None:
        """Open menus on these widgets and all within them."""
        for widget in widgets:
            widget.installEventFilter(self)

    def open_at(self, widget: QWidget | None, place: QPoint | None = None) -> None:
        """Open the menu of what lies in a widget at a point of the screen, or of what is chosen in it."""
        while widget is not None:
            if isinstance(widget, MenuOwner):
                thing, at = widget.menu_at(None if place is None else widget.mapFromGlobal(place))
                if thing:
                    self._show(thing, widget, widget.mapToGlobal(at) if place is None else place)
                    return
            widget = widget.parentWidget()
        if place is not None:
            self._show("", self._parent, place)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Open the menu that no widget below has opened."""
        if not isinstance(event, QContextMenuEvent) or not isinstance(watched, QWidget):
            return False
        if event.reason() == QContextMenuEvent.Reason.Keyboard:
            self.open_at(QApplication.focusWidget())
        else:
            self.open_at(watched.childAt(event.pos()) or watched, event.globalPos())
        event.accept()
        return True

    def _show(self, thing: str, owner: QWidget, place: QPoint) -> None:
        menu = QMenu(self._parent, toolTipsVisible=True)
        own = owner.actions() if thing else self._general
        menu.addActions(list(own))
        menu.addSeparator()
        for name in THINGS.get(thing, (thing,)):
            if name in self._actions:
                menu.addAction(self._actions[name])
            elif name in self._submenus:
                self._submenus[name].fill(menu.addMenu(self._submenus[name].text))
            else:
                menu.addSeparator()
        menu.aboutToHide.connect(menu.deleteLater)
        keep_apart(menu)
        self.menu = menu
        menu.popup(place)
