"""The main window: it assembles features, panels and menus."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Protocol, TypeVar, runtime_checkable

from PySide6.QtCore import QByteArray, QSize, Qt
from PySide6.QtGui import QAction, QCloseEvent, QDragEnterEvent, QDropEvent
from PySide6.QtWidgets import QMainWindow, QWidget

from app.model.display.lengths import prefer_unit
from app.model.preferences.table import UNIT
from app.model.state.situation import NOT_IN_VOLUMES
from app.model.text.keys import use_names
from app.model.text.language import tr
from app.session.features.workspace import Workspace
from app.session.storage.preferences import Preferences
from app.session.storage.session_file import DocumentFile
from app.views.canvas.canvas_area import FIRST_TOOL, CanvasArea
from app.views.canvas.status_fields import PointerReadout, ZoomField
from app.views.features import FEATURES
from app.views.features.exchange import ImportFeature
from app.views.features.files import OpenSaveFeature, StartFeature
from app.views.features.run import ParametersFeature, RunControlFeature
from app.views.features.view import AppearanceFeature
from app.views.theme import theme
from app.views.widgets.actions import Actions, ActionSpec, Submenu
from app.views.widgets.turns import Turns
from app.views.window.bars import ToolBar, ToolPalette
from app.views.window.docks import Docks
from app.views.window.feature import Feature, FeatureContext
from app.views.window.keyboard import Areas, Keyboard
from app.views.window.menus import MENUS, ContextMenus, Menus
from app.views.window.python_hooks import GarbageCollector
from app.views.window.shortcuts import Shortcuts, use_keys

P = TypeVar("P", bound=Feature)

_SIZE, _FRAME = QSize(1400, 880), QSize(16, 40)
"""Preferred size of the window, and space on the screen for its frame."""

_GEOMETRY, _LAYOUT = "window/geometry", "window/panels"
"""Keys of the preferences for the geometry of the window and the layout of its panels."""


@runtime_checkable
class Themed(Protocol):
    """A widget with colors that the palette does not set."""

    def use_theme(self, theme: theme.Theme) -> None:
        """Use the colors of a theme."""


class MainWindow(QMainWindow):
    """The window of a session.

    Parameters
    ----------
    workspace : Workspace
        Session and features; closed together with the window.
    preferences : Preferences, optional
        Settings that are stored between sessions.
    """

    def __init__(self, workspace: Workspace, preferences: Preferences | None = None) -> None:
        super().__init__()
        self.workspace = workspace
        self.session = session = workspace.session
        self.preferences = preferences or Preferences(self)
        self.preferences.follow(UNIT, lambda: prefer_unit(self.preferences.value(UNIT)))
        self._garbage = GarbageCollector(self)
        self._garbage.start()  # before any part of the window is made: the worker is at work already
        self.turns = Turns(self)
        self.setAcceptDrops(True)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.NoContextMenu)
        self.resize(_SIZE.boundedTo(self.screen().availableSize() - _FRAME))
        self.canvas_area = CanvasArea(workspace)
        self.setCentralWidget(self.canvas_area)
        self._keyboard = Keyboard(self, self.canvas_area.canvas)
        context = self._make_context()
        self.features: dict[type[Feature], Feature] = {kind: kind(context) for kind in FEATURES}
        specs = [spec for feature in self.features.values() for spec in feature.action_specs()]
        self._introduce_files()
        self.actions_by_name = Actions(self, (spec for spec in specs if isinstance(spec, ActionSpec)))
        self.menus = Menus(self.menuBar(), specs, self.actions_by_name)
        panels = [panel for feature in self.features.values() for panel in feature.panels()]
        self.panels = {panel.name: panel.widget for panel in panels}
        self.areas = Areas(self.canvas_area.canvas, self.panels, self._reveal)
        self.docks = Docks(self, panels, self.areas)
        self.shortcuts = self._make_shortcuts()
        self.context_menus = self._add_menus(specs)
        self.addToolBar(ToolBar(self.actions_by_name, self.feature(RunControlFeature).speed))
        self.addToolBar(Qt.ToolBarArea.LeftToolBarArea, ToolPalette(self.actions_by_name))
        self.pointer_readout = PointerReadout(session, self.canvas_area.canvas)
        self.zoom_field = ZoomField(self.canvas_area.canvas)
        self.statusBar().addPermanentWidget(self.pointer_readout)
        self.statusBar().addPermanentWidget(self.zoom_field)
        session.status_changed.connect(self._show)
        session.image_changed.connect(self._keep_tool)
        self.use_theme(self.feature(AppearanceFeature).theme())
        self._show()
        self._restore_geometry()
        self.canvas_area.canvas.setFocus()

    def feature(self, kind: type[P]) -> P:
        """A feature by its class."""
        feature = self.features[kind]
        assert isinstance(feature, kind)
        return feature

    def refresh(self) -> None:
        """Update actions and hint."""
        self.session.show_status()

    def open_image(self, path: str) -> None:
        """Open an image or a session."""
        self.feature(OpenSaveFeature).take([Path(path)])

    def use_theme(self, used: theme.Theme) -> None:
        """Apply a theme."""
        theme.apply_theme(used)
        self.actions_by_name.use_theme(used)
        for widget in self.findChildren(QWidget):
            if isinstance(widget, Themed):
                widget.use_theme(used)
        for feature in self.features.values():
            feature.use_theme(used)

    # Called by Qt

    def closeEvent(self, event: QCloseEvent) -> None:
        """Hide at once, then stop the worker; a feature may keep the window open."""
        if not all(feature.close() for feature in self.features.values()):
            event.ignore()
            return
        self.preferences.put(_GEOMETRY, self.saveGeometry())
        self.preferences.put(_LAYOUT, self.saveState(self.docks.version))
        self.turns.stop()
        self.docks.leave()
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
        self.feature(OpenSaveFeature).take_dropped(event.mimeData().urls())

    def _introduce_files(self) -> None:
        """Tell features that work with files of each other."""
        files = self.feature(OpenSaveFeature)
        importing = self.feature(ImportFeature)
        files.import_contours = importing.take
        importing.open_files = files.take_dropped
        files.bring_in = self.feature(ParametersFeature).presets.import_file
        self.feature(StartFeature).show_files_of(files.recent)

    def _keep_tool(self) -> None:
        """Use the first tool in a volume where the tool in use has nothing to draw on."""
        tool = self.canvas_area.canvas.hold.tool
        if self.session.scene.slices is not None and tool is not None and tool.name in NOT_IN_VOLUMES:
            self.refresh()
            self.actions_by_name[FIRST_TOOL].trigger()

    def _reveal(self, name: str) -> None:
        self.docks.reveal(name)  # the docks are made after the features

    def _open_menu(self) -> None:
        self.context_menus.open_by_key()  # and so are the menus

    def _add_menus(self, specs: Sequence[ActionSpec | Submenu]) -> ContextMenus:
        restore = QAction(tr("Restore pane&ls"), self)
        restore.setStatusTip(tr("Move every panel to its initial place."))
        restore.triggered.connect(self.docks.restore)
        general = (*self.docks.actions, restore)
        self.menus.add_section("View", general)
        menus = ContextMenus(self, specs, self.actions_by_name, general)
        menus.watch(self, *self.docks)
        self.canvas_area.canvas.pointer.menu_wanted.connect(partial(menus.open_at, self.canvas_area))
        return menus

    def _make_context(self) -> FeatureContext:
        canvas, slices, truth = self.canvas_area.canvas, self.workspace.slices, self.workspace.truth
        document_file = DocumentFile(self.session, lambda: {**canvas.view_state(), **slices.view_state()})
        document_file.truth = lambda: truth.file
        return FeatureContext(
            window=self,
            workspace=self.workspace,
            canvas_area=self.canvas_area,
            preferences=self.preferences,
            document_file=document_file,
            action_specs=lambda: self.actions_by_name.specs,
            shortcuts=lambda: self.shortcuts,
            reveal=self._reveal,
            areas=lambda: self.areas,
            use_theme=self.use_theme,
            refresh=self.refresh,
            open_file=lambda path, resumes: self.feature(OpenSaveFeature).take([path], resumes),
            open_part=lambda path, whole, reading: self.feature(OpenSaveFeature).take_part(path, whole, reading),
            do=lambda name: self.actions_by_name[name].trigger(),
            open_menu=self._open_menu,
            turns=self.turns,
        )

    def _make_shortcuts(self) -> Shortcuts:
        made = Shortcuts(self.preferences, self)
        for spec in self.actions_by_name.specs:
            menu = spec.menu.partition(">")[0]
            group = tr("Tools") if spec.group == "tool" else MENUS[menu].replace("&", "")
            made.add(spec.name, spec.title, group, spec.shortcuts, partial(self.actions_by_name.use_keys, spec.name))
        for action in self.docks.actions:
            keys = [key.toString() for key in action.shortcuts()]
            made.add(action.objectName(), action.text(), tr("Panels"), keys, partial(use_keys, action))
        made.changed.connect(lambda: self._use_keys(made))
        self._use_keys(made)
        return made

    def _use_keys(self, shortcuts: Shortcuts) -> None:
        use_names(shortcuts.names())
        self.actions_by_name.show_keys()
        self.canvas_area.messages.show_keys()
        self.canvas_area.refresh()
        for feature in self.features.values():
            feature.use_keys()

    def _show(self) -> None:
        self.actions_by_name.show(self.session.situation)

    def _restore_geometry(self) -> None:
        geometry = self.preferences.get(_GEOMETRY, QByteArray())
        if not geometry.isEmpty():
            self.restoreGeometry(geometry)
            self.docks.restore_layout(self.preferences.get(_LAYOUT, QByteArray()))
