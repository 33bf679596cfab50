"""The menus of what lies under the pointer, or has the keyboard: one list says which actions belong to which thing."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from PySide6.QtCore import QEvent, QObject, QPoint
from PySide6.QtGui import QAction, QContextMenuEvent
from PySide6.QtWidgets import QApplication, QMenu, QWidget

from app.views.widgets.action_spec import ActionSpec, Submenu
from app.views.widgets.actions import Actions
from app.views.widgets.menu_owner import MenuOwner
from app.views.window.menus.marks import keep_apart

_RUN = ("run", "step", "reset")

THINGS: Mapping[str, tuple[str, ...]] = {
    "image": (*_RUN, "", "undo", "redo", "", "add_circle", "cross_hair", "clear", "", "fit", "zoom_in", "zoom_out", "",
              "copy_view", "export"),
    "shape": ("enlarge", "shrink", "delete", "", "select_next", "clear", "", *_RUN),
    "charge": ("enlarge", "shrink", "delete", "", "layer_potential", "layer_field", "", *_RUN),
    "particles": (*_RUN, "", "timeline_back", "timeline_forward", "timeline_first", "timeline_last", "",
                  "layer_particles", "layer_trails", "layer_forces"),
    "contour": ("keep", "reject", "name_contour", "colors", "", "close_contours", "join_contours", "cut_contour",
                "delete_stretch", "", "contour_skeleton", "", "contour_table", "export"),
    "object": ("name_object", "object_class", "object_color", "", "change_object", "fit_objects", "objects_alike",
               "merge_objects", "", "freeze_object", "hide_object", "", "object_start", "object_region",
               "object_barrier", "object_skeleton", "", "delete_object", "object_table", "export"),
    "proposal": ("take_object", "escape"),
    "step": ("timeline_parameters", "timeline_delete", "", "timeline_first", "timeline_back", "timeline_forward",
             "timeline_last", "timeline_play", "", "export_animation", "export_strip"),
    "space": ("space_whole", "space_along_0", "space_along_1", "space_along_2", "", "space_particles", "space_surface",
              "space_objects", "space_slices", "space_projection", "space_box", "", "copy_space", "export_space",
              "export_turntable"),
    "history": ("undo", "redo"),
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

    def open_at(self, widget: QWidget | None, place: QPoint) -> None:
        """Open the menu of what lies in a widget at a point of the screen."""
        while widget is not None:
            if isinstance(widget, MenuOwner):
                thing, _ = widget.menu_at(widget.mapFromGlobal(place))
                if thing:
                    self._show(thing, widget, place)
                    return
            widget = widget.parentWidget()
        self._show("", self._parent, place)

    def open_by_key(self) -> None:
        """Open the menu of what is chosen in the widget with the keyboard."""
        widget = QApplication.focusWidget()
        while widget is not None:
            if isinstance(widget, MenuOwner):
                thing, place = widget.menu_at(None)
                if thing:
                    self._show(thing, widget, widget.mapToGlobal(place))
                    return
            widget = widget.parentWidget()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Open the menu that no widget below has opened."""
        if not isinstance(event, QContextMenuEvent) or not isinstance(watched, QWidget):
            return False
        if event.reason() == QContextMenuEvent.Reason.Keyboard:
            self.open_by_key()
        else:
            self.open_at(watched.childAt(event.pos()) or watched, event.globalPos())
        event.accept()
        return True

    def _show(self, thing: str, owner: QWidget, place: QPoint) -> None:
        menu = QMenu(self._parent)
        menu.setToolTipsVisible(True)
        own = owner.actions() if thing else self._general
        menu.addActions(list(own))
        names = THINGS.get(thing, (thing,))
        if own and any(names):
            menu.addSeparator()
        for name in names:
            self._add(menu, name)
        menu.aboutToHide.connect(menu.deleteLater)
        keep_apart(menu)
        self.menu = menu
        menu.popup(place)

    def _add(self, menu: QMenu, name: str) -> None:
        if name in self._actions:
            menu.addAction(self._actions[name])
        elif name in self._submenus:
            inner = menu.addMenu(self._submenus[name].text)
            self._submenus[name].fill(inner)
        else:
            menu.addSeparator()
