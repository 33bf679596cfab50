"""Main window, and the base class of its features: related actions and panels.

A new feature is a module in `cpm_app.views.features` and an entry in its list.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TypeVar, cast

from PySide6.QtCore import QByteArray, QSize, Qt, Signal
from PySide6.QtGui import QCloseEvent, QDragEnterEvent, QDropEvent, QGuiApplication
from PySide6.QtWidgets import QMainWindow

from cpm_app.model.display.lengths import prefer_unit
from cpm_app.model.preferences.table import (
    CONTOUR_WIDTH,
    INK_PREFERENCES,
    POINT_SIZE,
    SHAPE_WIDTH,
    THEME_PREFERENCE,
    UNIT_PREFERENCE,
)
from cpm_app.model.state.situation import HIDDEN_IN_VOLUMES
from cpm_app.model.text.keys import use_action_names
from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import ImageOpened
from cpm_app.session.features.workspace import Workspace
from cpm_app.session.storage.preferences import Preferences
from cpm_app.session.storage.session_file import DocumentFile
from cpm_app.views.canvas.canvas_area import FIRST_TOOL, CanvasArea
from cpm_app.views.canvas.status_fields import PointerReadout, ZoomReadout
from cpm_app.views.theme import theme
from cpm_app.views.widgets.actions import ActionButton, Actions, ActionSpec, Submenu
from cpm_app.views.widgets.fields import SpeedControl
from cpm_app.views.widgets.turns import Turns
from cpm_app.views.window.bars import ToolBar, ToolPalette
from cpm_app.views.window.dialogs import FileDialogs
from cpm_app.views.window.docks import Docks, Panel
from cpm_app.views.window.keyboard import Keyboard
from cpm_app.views.window.menus import MENU_TITLES, ContextMenus, Menus
from cpm_app.views.window.python_hooks import GarbageCollector
from cpm_app.views.window.shortcuts import Shortcuts

_WINDOW_SIZE = QSize(1400, 880)
"""Preferred size of the window [px]."""

_FRAME_SIZE = QSize(16, 40)
"""Space on the screen for the frame of the window [px]."""

_GEOMETRY_KEY = "window/geometry"
"""Preference: size and position of the window."""

_LAYOUT_KEY = "window/panels"
"""Preference: layout of the panels."""

_THEMES_BY_NAME = {"light": theme.LIGHT_THEME, "dark": theme.DARK_THEME}
"""Themes by the names in the preferences."""

_STYLE_KEYS = {CONTOUR_WIDTH.name, SHAPE_WIDTH.name, POINT_SIZE.name, *(ink.name for ink in INK_PREFERENCES.values())}
"""Preferences that change how the canvas looks."""


class Feature:
    """Base class of features; each is created once per window, before its menus and docks.

    Attributes
    ----------
    window : MainWindow
        The window.
    session, canvas : Session, Canvas
        Session and canvas of the window.
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
        """Create the actions and panels and connect them to what they depend on."""

    def close(self) -> bool:
        """Finish before the window closes; return False to keep the window open."""
        return True


FeatureType = TypeVar("FeatureType", bound=Feature)


class MainWindow(QMainWindow):
    """Main window of a session.

    Parameters
    ----------
    workspace : Workspace
        Session and features; closed together with the window.
    features : sequence of Feature
        Classes of the features, in the order of their actions in the menus.
    preferences : Preferences or None
        Settings that are stored between sessions; None for those of the user.
    """

    files_wanted = Signal(list, bool)
    """Files are to be opened by their kind; whether an image is opened with the session next to it."""

    urls_dropped = Signal(list)
    """URLs of files were dropped on the window or pasted."""

    second_dropped = Signal(list)
    """URLs of files were dropped on the window with Shift."""

    def __init__(
        self, workspace: Workspace, features: Sequence[type[Feature]], preferences: Preferences | None
    ) -> None:
        super().__init__()
        self.workspace = workspace
        self.session = session = workspace.session
        self.preferences = preferences or Preferences(self)
        self.preferences.call_on_change(
            UNIT_PREFERENCE, lambda: prefer_unit(self.preferences.read_preference(UNIT_PREFERENCE))
        )
        self._garbage = GarbageCollector(self)  # before any widget is created: the worker thread is already running
        self.turns = Turns(self)
        self.setAcceptDrops(True)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.NoContextMenu)
        self.resize(_WINDOW_SIZE.boundedTo(self.screen().availableSize() - _FRAME_SIZE))
        self._apply_canvas_style()
        self.canvas_area = CanvasArea(workspace)
        self.setCentralWidget(self.canvas_area)
        canvas, slices = self.canvas_area.canvas, workspace.slices
        self._keyboard = Keyboard(self, canvas, self.canvas_area.press_enter)
        self._keyboard.typing_changed.connect(self.canvas_area.set_typing)
        self.offers = self.canvas_area.offers
        session.store.add_listener(
            ImageOpened, lambda _: self.offers.clear()
        )  # connected first, before any feature adds an offer
        self.files = FileDialogs(self, session, self.preferences)
        self.document_file = DocumentFile(
            session,
            view=lambda: {**canvas.view_state(), **slices.view_state()},
            truth=lambda: workspace.comparison.truth_file,
            pages=workspace.pages.to_json,
            has_unsaved_pages=lambda: workspace.pages.has_unsaved_others,
        )
        self.shortcuts = Shortcuts(self.preferences, self)
        self.shortcuts.changed.connect(self._on_shortcuts_changed)
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
        self._connect_actions()
        self.context_menus = self._add_menus(specs)
        self.addToolBar(ToolBar(self.actions_by_name, self.speed))
        self.addToolBar(Qt.ToolBarArea.LeftToolBarArea, ToolPalette(self.actions_by_name))
        self.pointer_readout, self.zoom_readout = PointerReadout(session, canvas), ZoomReadout(canvas)
        # first what comes and goes, so that it moves no button
        self.statusBar().insertPermanentWidget(0, self.pointer_readout)
        self.statusBar().addPermanentWidget(self.zoom_readout)
        session.store.status_changed.connect(self._on_status_changed)
        session.image_changed.connect(self._on_image_changed)
        self.canvas_area.tool_changed.connect(self._on_tool_changed)
        self.preferences.changed.connect(self._on_preference_changed)
        QGuiApplication.styleHints().colorSchemeChanged.connect(self._apply_selected_theme)
        self._apply_selected_theme()
        self._on_status_changed()
        if not (geometry := self.preferences.read_key(_GEOMETRY_KEY, QByteArray())).isEmpty():
            self.restoreGeometry(geometry)
            self.docks.restore_layout(self.preferences.read_key(_LAYOUT_KEY, QByteArray()))
        self._on_tool_changed()
        canvas.setFocus()

    def get_feature(self, kind: type[FeatureType]) -> FeatureType:
        """Return a feature by its class."""
        return cast("FeatureType", self.features[kind])

    def trigger_action(self, name: str) -> None:
        """Trigger an action by its name."""
        self.actions_by_name[name].trigger()

    def refresh_actions(self) -> None:
        """Update actions and hint after a change that the session does not report."""
        self.session.store.announce_status()

    def open_image(self, path: str | Path, resumes: bool = False) -> None:
        """Open an image or a session; with `resumes`, an image together with the session next to it."""
        self.files_wanted.emit([Path(path)], resumes)

    # Called by Qt

    def closeEvent(self, event: QCloseEvent) -> None:
        """Hide at once, then stop the worker, unless a feature keeps the window open."""
        if not all(feature.close() for feature in self.features.values()):
            event.ignore()
            return
        self.preferences.store_key(_GEOMETRY_KEY, self.saveGeometry())
        self.preferences.store_key(_LAYOUT_KEY, self.docks.save_layout())
        self.turns.stop()
        self.hide()
        self.session.close()
        self._garbage.stop()
        super().closeEvent(event)

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """Accept files."""
        if event.mimeData().hasUrls():
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        """Open the dropped files, or with Shift put one over the image."""
        event.setDropAction(Qt.DropAction.CopyAction)  # Shift proposes to move: the source would delete the file
        event.accept()
        over = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
        (self.second_dropped if over else self.urls_dropped).emit(event.mimeData().urls())

    def _on_image_changed(self) -> None:
        """Switch to the first tool if the tool in use does not work in volumes."""
        tool = self.canvas_area.canvas.dispatcher.tool
        if self.session.scene.slices is not None and tool is not None and tool.name in HIDDEN_IN_VOLUMES:
            self.refresh_actions()
            self.trigger_action(FIRST_TOOL)

    def _on_tool_changed(self) -> None:
        """Bring the tab of the tool to the front, once per change, as the user may switch to another tab."""
        tool = self.canvas_area.canvas.dispatcher.tool
        if not (self.docks.is_in_front("measures") and tool.name == "select"):
            self.docks.bring_to_front(tool.panel)
        self.refresh_actions()

    def _add_menus(self, specs: Sequence[ActionSpec | Submenu]) -> ContextMenus:
        self.menus["View"].addSeparator()
        self.menus["View"].addActions([*self.docks.actions])
        menus = ContextMenus(self, specs, self.actions_by_name, self.docks.actions)
        menus.watch_widgets(self, self.docks.column)
        self.canvas_area.canvas.menu_wanted.connect(partial(menus.open_menu_at, self.canvas_area))
        return menus

    def _connect_actions(self) -> None:
        for name, spec in self.actions_by_name.specs.items():
            if spec.checked_when is not None:  # Qt has changed the check mark, even if nothing else has changed
                self.actions_by_name[name].triggered.connect(self.refresh_actions)
        for button in self.findChildren(ActionButton):
            button.use_action(self.actions_by_name[button.objectName()])
        for spec in self.actions_by_name.specs.values():
            menu, _, group = spec.menu.partition(">")
            group = MENU_TITLES[menu].replace("&", "") if menu else group
            self.shortcuts.add_action(self.actions_by_name[spec.name], spec.name, spec.title, group)
        for action in self.docks.actions:
            self.shortcuts.add_action(action, action.objectName(), action.text(), tr("Panels"))
        self.shortcuts.changed.emit()

    def _on_shortcuts_changed(self) -> None:
        use_action_names(self.shortcuts.describe_actions())
        self.actions_by_name.show_keys()
        self.canvas_area.messages.show_keys()
        self.canvas_area.update_hint()

    def _on_status_changed(self) -> None:
        self.actions_by_name.show_situation(self.session.situation)
        if self.session.status.started:
            self.offers.clear()

    def _on_preference_changed(self, key: str) -> None:
        """Apply a preference that has changed."""
        if key == THEME_PREFERENCE.name:
            self._apply_selected_theme()
        elif key in _STYLE_KEYS:
            self._apply_canvas_style()
            for item in self.canvas_area.canvas.scene().items():
                item.update()
            self.update()  # the swatches
        elif key == UNIT_PREFERENCE.name:
            self.canvas_area.canvas.layers["scale_bar"].apply_visibility()
            self.refresh_actions()

    def _apply_selected_theme(self) -> None:
        selected = _THEMES_BY_NAME.get(self.preferences.read_preference(THEME_PREFERENCE))
        theme.apply_theme(selected or theme.system_theme(), self)

    def _apply_canvas_style(self) -> None:
        value = self.preferences.read_preference
        theme.set_canvas_style(
            theme.CanvasStyle(
                contours=value(CONTOUR_WIDTH) / CONTOUR_WIDTH.default,
                shapes=value(SHAPE_WIDTH) / SHAPE_WIDTH.default,
                points=value(POINT_SIZE) / POINT_SIZE.default,
                colors={name: value(color) for name, color in INK_PREFERENCES.items() if value(color) != color.default},
            )
        )
