"""The main window, and what a feature of it is: related actions and panels.

A new feature is a module in `cpm_app.views.features` and an entry in its list.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TypeVar, cast

from PySide6.QtCore import QByteArray, QSize, Qt, Signal
from PySide6.QtGui import QCloseEvent, QDragEnterEvent, QDropEvent, QGuiApplication
from PySide6.QtWidgets import QMainWindow, QWidget

from cpm_app.model.display.lengths import prefer_unit
from cpm_app.model.preferences.table import CONTOUR_WIDTH, INKS, POINT_SIZE, SHAPE_WIDTH, THEME, UNIT
from cpm_app.model.state.situation import NOT_IN_VOLUMES
from cpm_app.model.text.keys import use_names
from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import Opened
from cpm_app.session.features.workspace import Workspace
from cpm_app.session.storage.preferences import Preferences
from cpm_app.session.storage.session_file import DocumentFile
from cpm_app.views.canvas.canvas_area import FIRST_TOOL, CanvasArea
from cpm_app.views.canvas.status_fields import PointerReadout, ZoomReadout
from cpm_app.views.theme import theme
from cpm_app.views.widgets.actions import Actions, ActionSpec, Submenu
from cpm_app.views.widgets.fields import SpeedControl
from cpm_app.views.widgets.turns import Turns
from cpm_app.views.window.bars import ToolBar, ToolPalette
from cpm_app.views.window.dialogs import FileDialogs
from cpm_app.views.window.docks import Docks, Panel
from cpm_app.views.window.keyboard import Keyboard
from cpm_app.views.window.menus import MENUS, ContextMenus, Menus
from cpm_app.views.window.python_hooks import GarbageCollector
from cpm_app.views.window.shortcuts import Shortcuts

_SIZE, _FRAME = QSize(1400, 880), QSize(16, 40)
"""Preferred size of the window, and space on the screen for its frame."""

_GEOMETRY, _LAYOUT = "window/geometry", "window/panels"
"""Keys of the preferences for the geometry of the window and the layout of its panels."""

_THEMES = {"light": theme.LIGHT, "dark": theme.DARK}
_LOOK = {CONTOUR_WIDTH.name, SHAPE_WIDTH.name, POINT_SIZE.name, *(ink.name for ink in INKS.values())}
"""Preferences that change what the canvas looks like."""


class Feature:
    """Base class of features; each is made once for a window, before the menus and the docks of it.

    Attributes
    ----------
    window : MainWindow
        The window.
    session, canvas : Session, Canvas
        Those of the window.
    actions : sequence of ActionSpec or Submenu
        Its actions, in the order of the menus.
    panels : sequence of Panel
        Its panels.
    """

    actions: Sequence[ActionSpec | Submenu] = ()
    panels: Sequence[Panel] = ()

    def __init__(self, window: MainWindow) -> None:
        self.window = window
        self.session, self.canvas = window.session, window.canvas_area.canvas
        self.set_up()

    def set_up(self) -> None:
        """Make its actions and panels, and follow what they depend on."""

    def close(self) -> bool:
        """End its work before the window closes; False keeps the window open."""
        return True


P = TypeVar("P", bound=Feature)


class MainWindow(QMainWindow):
    """The window of a session.

    Parameters
    ----------
    workspace : Workspace
        Session and features; closed together with the window.
    features : sequence of Feature
        What gives it actions and panels, in the order of their actions in the menus.
    preferences : Preferences, optional
        Settings that are stored between sessions.
    """

    files_wanted = Signal(list, bool)
    """Files are to be opened by their kind, and an image with the session next to it or not."""

    dropped = Signal(list)
    """The places of files are dropped on the window, or pasted."""

    def __init__(
        self, workspace: Workspace, features: Sequence[type[Feature]], preferences: Preferences | None = None
    ) -> None:
        super().__init__()
        self.workspace = workspace
        self.session = session = workspace.session
        self.preferences = preferences or Preferences(self)
        self.preferences.follow(UNIT, lambda: prefer_unit(self.preferences.value(UNIT)))
        self._garbage = GarbageCollector(self)  # before any part of the window is made: the worker is at work already
        self.turns = Turns(self)
        self.setAcceptDrops(True)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.NoContextMenu)
        self.resize(_SIZE.boundedTo(self.screen().availableSize() - _FRAME))
        self._use_look()
        self.canvas_area = CanvasArea(workspace)
        self.setCentralWidget(self.canvas_area)
        canvas, slices = self.canvas_area.canvas, workspace.slices
        self._keyboard = Keyboard(self, canvas)
        self.offers = self.canvas_area.offers
        session.listen(Opened, lambda _: self.offers.clear())  # before any feature offers something
        self.files = FileDialogs(self, session, self.preferences)
        self.document_file = DocumentFile(session, lambda: {**canvas.view_state(), **slices.view_state()})
        self.document_file.truth = lambda: workspace.comparison.file
        self.shortcuts = Shortcuts(self.preferences, self)
        self.shortcuts.changed.connect(self._use_keys)
        self.speed = SpeedControl(session)
        self.features: dict[type[Feature], Feature] = {}
        for kind in features:
            self.features[kind] = kind(self)
        specs = [spec for feature in self.features.values() for spec in feature.actions]
        self.actions_by_name = Actions(self, (spec for spec in specs if isinstance(spec, ActionSpec)))
        self.menus = Menus(self.menuBar(), specs, self.actions_by_name)
        panels = [panel for feature in self.features.values() for panel in feature.panels]
        self.panels = {panel.name: panel.widget for panel in panels}
        self.docks = Docks(self, panels, self._keyboard, self.canvas_area.controls)
        self._add_shortcuts()
        self.context_menus = self._add_menus(specs)
        self.addToolBar(ToolBar(self.actions_by_name, self.speed))
        self.addToolBar(Qt.ToolBarArea.LeftToolBarArea, ToolPalette(self.actions_by_name))
        self.pointer_readout = PointerReadout(session, canvas)
        self.zoom_readout = ZoomReadout(canvas)
        for field in (self.pointer_readout, self.zoom_readout):
            self.statusBar().addPermanentWidget(field)
        session.status_changed.connect(self._show)
        session.image_changed.connect(self._keep_tool)
        self.canvas_area.tool_changed.connect(self._follow_tool)
        self.preferences.changed.connect(self._follow)
        QGuiApplication.styleHints().colorSchemeChanged.connect(self._use_chosen_theme)
        self._use_chosen_theme()
        self._show()
        if not (geometry := self.preferences.get(_GEOMETRY, QByteArray())).isEmpty():
            self.restoreGeometry(geometry)
            self.docks.restore_layout(self.preferences.get(_LAYOUT, QByteArray()))
        self._follow_tool()
        canvas.setFocus()

    def feature(self, kind: type[P]) -> P:
        """A feature by its class."""
        return cast("P", self.features[kind])

    def do(self, name: str) -> None:
        """Trigger an action by its name."""
        self.actions_by_name[name].trigger()

    def refresh(self) -> None:
        """Update actions and hint after a change that the session does not report."""
        self.session.show_status()

    def open_image(self, path: str | Path, resumes: bool = False) -> None:
        """Open an image or a session, or an image that `resumes` with the session next to it."""
        self.files_wanted.emit([Path(path)], resumes)

    def use_theme(self, used: theme.Theme) -> None:
        """Apply a theme."""
        theme.apply_theme(used, self, self.turns.ask)
        self.actions_by_name.use_theme(used, self.turns)
        for widget in self.findChildren(QWidget):
            if hasattr(widget, "use_theme"):  # with colors that the palette does not set
                widget.use_theme(used)

    # Called by Qt

    def closeEvent(self, event: QCloseEvent) -> None:
        """Hide at once, then stop the worker; a feature may keep the window open."""
        if not all(feature.close() for feature in self.features.values()):
            event.ignore()
            return
        self.preferences.put(_GEOMETRY, self.saveGeometry())
        self.preferences.put(_LAYOUT, self.docks.layout_state())
        self.turns.stop()
        self.hide()
        self.workspace.close()
        self._garbage.stop()
        super().closeEvent(event)

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """Accept files."""
        if event.mimeData().hasUrls():
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        """Open the dropped files."""
        event.acceptProposedAction()
        self.dropped.emit(event.mimeData().urls())

    def _keep_tool(self) -> None:
        """Use the first tool in a volume where the tool in use has nothing to draw on."""
        tool = self.canvas_area.canvas.hold.tool
        if self.session.scene.slices is not None and tool is not None and tool.name in NOT_IN_VOLUMES:
            self.refresh()
            self.do(FIRST_TOOL)

    def _follow_tool(self) -> None:
        """Show the tab of the tool, once it has changed: the user may look at another one since."""
        self.docks.bring(self.canvas_area.canvas.hold.tool.panel)
        self.refresh()

    def _add_menus(self, specs: Sequence[ActionSpec | Submenu]) -> ContextMenus:
        self.menus["View"].addSeparator()
        self.menus["View"].addActions([*self.docks.actions])
        menus = ContextMenus(self, specs, self.actions_by_name, self.docks.actions)
        menus.watch(self, self.docks.column)
        self.canvas_area.canvas.pointer.menu_wanted.connect(partial(menus.open_at, self.canvas_area))
        return menus

    def _add_shortcuts(self) -> None:
        for spec in self.actions_by_name.specs.values():
            menu, _, group = spec.menu.partition(">")
            group = MENUS[menu].replace("&", "") if menu else group
            self.shortcuts.add(self.actions_by_name[spec.name], spec.name, spec.title, group)
        for action in self.docks.actions:
            self.shortcuts.add(action, action.objectName(), action.text(), tr("Panels"))
        self.shortcuts.changed.emit()

    def _use_keys(self) -> None:
        use_names(self.shortcuts.names())
        self.actions_by_name.show_keys()
        self.canvas_area.messages.show_keys()
        self.canvas_area.refresh()

    def _show(self) -> None:
        self.actions_by_name.show(self.session.situation)
        if self.session.status.started:
            self.offers.clear()

    def _follow(self, key: str) -> None:
        """Use a preference that has changed."""
        if key == THEME.name:
            self._use_chosen_theme()
        elif key in _LOOK:
            self._use_look()
            for item in self.canvas_area.canvas.scene().items():
                item.update()
            self.canvas_area.strip.legend.update()
            self._use_chosen_theme()
        elif key == UNIT.name:
            self.canvas_area.canvas.layers["scale_bar"].show_or_hide()
            self.refresh()

    def _use_chosen_theme(self) -> None:
        self.use_theme(_THEMES.get(self.preferences.value(THEME)) or theme.system_theme())

    def _use_look(self) -> None:
        value = self.preferences.value
        theme.use_look(
            theme.Look(
                contours=value(CONTOUR_WIDTH) / CONTOUR_WIDTH.default,
                shapes=value(SHAPE_WIDTH) / SHAPE_WIDTH.default,
                points=value(POINT_SIZE) / POINT_SIZE.default,
                colors={name: value(color) for name, color in INKS.items() if value(color) != color.default},
            )
        )
