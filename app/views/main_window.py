"""The main window: assembles, and holds no logic of its own."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from PySide6.QtCore import QSize, Qt, QTimer
from PySide6.QtGui import QCloseEvent, QDragEnterEvent, QDropEvent, QFontMetrics, QGuiApplication
from PySide6.QtWidgets import QDockWidget, QLabel, QMainWindow, QToolBar, QToolButton, QWidget

from app.model import edits
from app.model.paths import Position
from app.model.resolve import TOOLS
from app.model.samples import samples
from app.model.shades import Shades
from app.model.shapes import KINDS, Everywhere, Kind, describe
from app.session.messages import Snapshot
from app.session.session import Session
from app.views import theme
from app.views.actions import ENTRIES, MENUS, Actions
from app.views.canvas import ZOOM
from app.views.dialogs import ask_for_export, ask_for_image
from app.views.help import show_about, show_help
from app.views.panels.layers_panel import LAYERS
from app.views.side_column import SideColumn
from app.views.speed import SpeedControl
from app.views.stage import Stage
from app.views.tool_palette import ToolPalette
from cpm_core.image import Image

_SHORT = {
    "open": "Open",
    "undo": "Undo",
    "redo": "Redo",
    "export": "Export",
    "step": "Step",
    "reset": "Reset",
    "fit": "Fit",
}
"""Texts of the tool bar where those of the menu are too long."""

_SIZE, _FRAME = QSize(1400, 880), QSize(16, 40)
"""Size of the window where the screen has room for it, and what its frame may take of the screen."""

_FIGURES_EVERY = 250
"""Time between two looks at the frame counter [ms]."""


class MainWindow(QMainWindow):
    """The window of a session.

    Parameters
    ----------
    session : Session
        What it shows and drives; closed together with the window.
    """

    def __init__(self, session: Session) -> None:
        super().__init__()
        self.session = session
        self.setAcceptDrops(True)
        self.resize(self._roomy_size())
        self.stage = Stage(session)
        self.side = SideColumn(session)
        self.speed = SpeedControl(session)
        self.actions_by_name = Actions(self, self._handlers())
        self.palette_of_tools = ToolPalette(self.actions_by_name)
        self._image: Image | None = None
        self._snapshot: Snapshot | None = None
        self._pointer = QLabel()
        self._chosen_theme: theme.Theme | None = None
        self._folder = ""
        self._build_menus()
        self._build_tool_bar()
        self.setCentralWidget(self.stage)
        self._dock = self._build_dock()
        self.statusBar().addPermanentWidget(self._pointer)
        self._figures = QTimer(self)
        self._figures.setInterval(_FIGURES_EVERY)
        self._figures.timeout.connect(self._show_figures)
        self._follow()
        self._use_theme(None)
        self._show_resolved()
        self.stage.canvas.setFocus()

    def open_image(self, path: str) -> None:
        """Open an image; what was said about an earlier one is over."""
        self.stage.messages.hide()
        self.session.open(path)

    # What Qt calls

    def closeEvent(self, event: QCloseEvent) -> None:
        """Disappear at once, then stop the worker."""
        self.hide()
        self._figures.stop()
        self.session.close()
        super().closeEvent(event)

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """Files are welcome."""
        if event.mimeData().hasUrls():
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        """Open the first file dropped."""
        event.acceptProposedAction()
        url = event.mimeData().urls()[0]
        if url.isLocalFile():
            self.open_image(url.toLocalFile())
        else:
            self.session.say(
                f"{url.toDisplayString()} is not a file on this computer: save it first, then open it.", True
            )

    # Building

    def _roomy_size(self) -> QSize:
        """The size to open with: no larger than the screen, with room for the frame that the desktop puts around it."""
        return _SIZE.boundedTo(self.screen().availableSize() - _FRAME)

    def _build_menus(self) -> None:
        for title in MENUS:
            menu = self.menuBar().addMenu(f"&{title}")
            for entry in (entry for entry in ENTRIES if entry.menu == title):
                if entry.gap:
                    menu.addSeparator()
                menu.addAction(self.actions_by_name[entry.name])
                if entry.name == "open":
                    opened = menu.addMenu("Open &sample")
                    for sample in samples():
                        action = opened.addAction(sample.title, partial(self.open_image, str(sample.path)))
                        action.setStatusTip(sample.about)

    def _build_tool_bar(self) -> None:
        bar = QToolBar("Run")
        bar.setMovable(False)
        bar.toggleViewAction().setEnabled(False)
        bar.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        for names in (("open",), ("undo", "redo"), ("run", "step", "reset")):
            for name in names:
                self._add_button(bar, name)
            bar.addSeparator()
        bar.addWidget(self.speed)
        bar.addSeparator()
        for name in ("fit", "export"):
            self._add_button(bar, name)
        self.addToolBar(bar)
        self.addToolBar(Qt.ToolBarArea.LeftToolBarArea, self.palette_of_tools)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.NoContextMenu)

    def _add_button(self, bar: QToolBar, name: str) -> None:
        action = self.actions_by_name[name]
        if name in _SHORT:
            action.setIconText(_SHORT[name])
        bar.addAction(action)
        button = bar.widgetForAction(action)
        if isinstance(button, QToolButton):
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            button.setObjectName("primary" if name == "run" else name)
            if name == "run":
                bold = button.font()
                bold.setBold(True)
                button.setMinimumWidth(QFontMetrics(bold).horizontalAdvance("Run anew") + 60)

    def _build_dock(self) -> QDockWidget:
        dock = QDockWidget("Side column")
        dock.setObjectName("side column")
        dock.setFeatures(QDockWidget.DockWidgetFeature.NoDockWidgetFeatures)
        dock.setTitleBarWidget(QWidget())
        dock.setWidget(self.side)
        self.addDockWidget(Qt.DockWidgetArea.RightDockWidgetArea, dock)
        return dock

    def _follow(self) -> None:
        session = self.session
        session.status_changed.connect(self._show_resolved)
        session.image_changed.connect(self._show_image)
        session.snapshot_changed.connect(self._keep_snapshot)
        self.stage.canvas.pointed.connect(self._show_pointer)
        self.side.layers.toggled.connect(lambda name, shown: self.actions_by_name[f"layer_{name}"].setChecked(shown))
        QGuiApplication.styleHints().colorSchemeChanged.connect(self._scheme_changed)

    def _handlers(self) -> dict[str, Callable[..., object]]:
        session, canvas = self.session, self.stage.canvas
        handlers: dict[str, Callable[..., object]] = {
            "open": self._open,
            "export": self._export,
            "quit": self.close,
            "undo": session.undo,
            "redo": session.redo,
            "add_circle": self.stage.add_circle,
            "select_next": session.select_next,
            "escape": self.stage.escape,
            "delete": session.delete_selected,
            "clear": lambda: session.edit("delete all shapes", edits.clear_shapes),
            "fit": canvas.fit,
            "zoom_in": lambda: canvas.zoom(ZOOM),
            "zoom_out": lambda: canvas.zoom(1.0 / ZOOM),
            "panels": self._show_side,
            "theme_system": lambda: self._use_theme(None),
            "theme_light": lambda: self._use_theme(theme.LIGHT),
            "theme_dark": lambda: self._use_theme(theme.DARK),
            "run": session.toggle,
            "step": session.step,
            "reset": session.reset,
            "faster": self.speed.faster,
            "slower": self.speed.slower,
            "help": lambda: show_help(self),
            "about": lambda: show_about(self),
        }
        handlers |= {name: partial(self.stage.use_tool, name) for name in TOOLS}
        handlers |= {f"start_{kind}": partial(self._toggle_everywhere, kind) for kind in KINDS}
        handlers |= {f"layer_{layer.name}": partial(self._show_layer, layer.name) for layer in LAYERS}
        return handlers

    # Doing

    def _open(self) -> None:
        chosen = ask_for_image(self, self._folder)
        if chosen:
            self._folder = str(Path(chosen).parent)
            self.open_image(chosen)

    def _export(self) -> None:
        image = self.session.document.image
        stem = Path(image.name).stem if image else "contours"
        chosen = ask_for_export(self, str(Path(self._folder) / f"{stem}_contours.svg"))
        if chosen:
            self._folder = str(Path(chosen).parent)
            self.session.export(chosen)

    def _toggle_everywhere(self, kind: Kind) -> None:
        start = Everywhere(kind)
        session = self.session
        name = f"{'end ' if start in session.document.shapes else ''}{describe(start)}"
        session.edit(name, lambda document: edits.toggle_everywhere(document, kind))
        # Whether or not the document has changed, the action shows what is.
        self._show_resolved()

    def _show_layer(self, name: str, shown: bool) -> None:
        self.stage.show_layer(name, shown)
        self.side.layers.boxes[name].setChecked(shown)

    def _show_side(self, shown: bool) -> None:
        self._dock.setVisible(shown)

    # Showing

    def _show_resolved(self) -> None:
        resolved = self.session.resolved
        if self.windowTitle() != resolved.title:
            self.setWindowTitle(resolved.title)
        self.actions_by_name.show_resolved(resolved)
        self.stage.show_hint(resolved.hint)
        if resolved.running != self._figures.isActive():
            (self._figures.start if resolved.running else self._figures.stop)()
        self._show_figures()

    def _show_figures(self) -> None:
        resolved = self.session.resolved
        frames = f"{self.session.frames_per_second:.0f}" if resolved.running else "–"
        self.side.status.show_resolved(resolved, frames)
        self.side.plot.show_trace(self._snapshot.trace if self._snapshot else None)

    def _show_image(self, image: Image, _: Shades) -> None:
        self._image = image

    def _keep_snapshot(self, snapshot: Snapshot | None) -> None:
        # The plot is read, not watched: it follows at the slower pace of the figures.
        self._snapshot = snapshot

    def _show_pointer(self, position: Position | None) -> None:
        text = ""
        if position is not None and self._image is not None:
            row, col = round(position[0]), round(position[1])
            rows, cols = self._image.shape
            if 0 <= row < rows and 0 <= col < cols:
                text = f"row {row}, col {col}:  {self._image.values[row, col]:g}"
        self._pointer.setText(text)

    def _use_theme(self, chosen: theme.Theme | None) -> None:
        self._chosen_theme = chosen
        used = chosen or theme.system_theme()
        theme.apply_theme(used)
        self.actions_by_name.use_theme(used)
        self.palette_of_tools.use_theme(used)
        self.side.use_theme(used)
        self.stage.messages.use_theme(used)

    def _scheme_changed(self) -> None:
        if self._chosen_theme is None:
            self._use_theme(None)
