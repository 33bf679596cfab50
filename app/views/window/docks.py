"""Panels in docks around the canvas: their places and actions, and the keyboard in them."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from PySide6.QtCore import QByteArray, QObject, Qt, QTimer
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QApplication, QDockWidget, QMainWindow, QTabBar, QTabWidget, QWidget

from app.model.text.language import from_core, tr
from app.views.window.keyboard import Keyboard, in_panel, take_keyboard

BELOW = "below"
"""Name of the tab of the panels below the canvas; all others are on the right."""


@dataclass(frozen=True, eq=False, slots=True)
class Panel:
    """A panel next to the canvas; it can be moved, closed, and opened again from the menu View.

    Attributes
    ----------
    name : str
        Name in code and in the stored layout.
    title : str
        Heading, in English.
    widget : QWidget
        Content.
    tab : str
        Panels with the same value are tabbed; empty for a panel without tab.
    shown : bool
        Whether it is initially open.
    height : int
        Initial height, as far as there is room; those of an area keep their proportions [px].
    shortcut : str
        Key that opens or closes it.
    """

    name: str
    title: str
    widget: QWidget
    tab: str = ""
    shown: bool = True
    height: int = 400
    shortcut: str = ""


_RIGHT, _BOTTOM = Qt.DockWidgetArea.RightDockWidgetArea, Qt.DockWidgetArea.BottomDockWidgetArea
_LOW_AREAS = (_BOTTOM, Qt.DockWidgetArea.TopDockWidgetArea)
_UPRIGHT = QDockWidget.DockWidgetFeature.DockWidgetVerticalTitleBar

_AROUND = ("parameters", "objects", "timeline")
"""The panels that the keyboard visits after the canvas, in this order."""

_WIDTH = 330
"""Initial width of the panels next to the canvas [px]."""


class Docks(QObject):
    """One dock for each panel, which the user can move, close and open again; tabs replace the headings of panels."""

    def __init__(self, window: QMainWindow, panels: Iterable[Panel], keyboard: Keyboard) -> None:
        super().__init__(window)
        self._window = window
        self._keyboard = keyboard
        self.actions: list[QAction] = []
        self._panels = list(panels)
        self._docks: dict[str, QDockWidget] = {}
        self._front: str | None = ""
        """The panel below the canvas that is in front; None where its height is stored and is kept."""
        self._tidying = QTimer(self, singleShot=True, interval=0)
        self._tidying.timeout.connect(self._tidy)
        # Panels next to the canvas reach the bottom of the window; those below the canvas are as wide as the canvas.
        window.setCorner(Qt.Corner.BottomRightCorner, _RIGHT)
        window.setCorner(Qt.Corner.BottomLeftCorner, Qt.DockWidgetArea.LeftDockWidgetArea)
        window.setDockNestingEnabled(True)
        window.setTabPosition(Qt.DockWidgetArea.AllDockWidgetAreas, QTabWidget.TabPosition.North)
        for panel in self._panels:
            dock = self._docks[panel.name] = QDockWidget(from_core(panel.title), window)
            dock.setObjectName(panel.name)
            dock.setWidget(panel.widget)
            self.actions.append(self._make_action(dock, panel.shortcut))
            for changed in (dock.topLevelChanged, dock.dockLocationChanged, dock.visibilityChanged):
                changed.connect(lambda *_: self._tidying.start())
        self.restore()

    def __getitem__(self, name: str) -> QDockWidget:
        return self._docks[name]

    def __iter__(self) -> Iterator[QDockWidget]:
        return iter(self._docks.values())

    @property
    def version(self) -> int:
        """Version of the stored layout, computed from the panels: a layout with other panels cannot be used."""
        return zlib.crc32(",".join(self._docks).encode()) & 0x7FFFFFFF

    def reveal(self, name: str) -> None:
        """Open a panel and bring it to the front."""
        self._docks[name].show()
        self._docks[name].raise_()

    def enter(self, name: str) -> None:
        """Open a panel, bring it to the front and give it the keyboard."""
        self.reveal(name)
        panel = self._docks[name].widget()
        panel.window().activateWindow()
        take_keyboard(in_panel(panel))

    def go_on(self, by: int = 1) -> None:
        """Give the keyboard to the next area that is open, or for -1 to the previous one."""
        focused = QApplication.focusWidget()
        around = ["", *(name for name in _AROUND if not self._docks[name].isHidden())]
        here = next((name for name in around[1:] if focused and self._docks[name].isAncestorOf(focused)), "")
        name = around[(around.index(here) + by) % len(around)]
        if name:
            self.enter(name)
        else:
            self._keyboard.give_back()

    def restore(self) -> None:
        """Move every panel to its initial place."""
        window = self._window
        first: dict[str, QDockWidget] = {}
        for panel in self._panels:
            dock = self._docks[panel.name]
            dock.setFloating(False)
            if panel.tab in first:
                window.tabifyDockWidget(first[panel.tab], dock)
            else:
                window.addDockWidget(_BOTTOM if panel.tab == BELOW else _RIGHT, dock)
                first[panel.tab or panel.name] = dock
            if dock.isHidden() == panel.shown:
                dock.setVisible(panel.shown)
        for dock in first.values():
            dock.raise_()
        beside = [dock for tab, dock in first.items() if tab != BELOW]
        window.resizeDocks(beside, [_WIDTH] * len(beside), Qt.Orientation.Horizontal)
        window.resizeDocks(list(self), [panel.height for panel in self._panels], Qt.Orientation.Vertical)
        self._front = ""
        self._tidying.start()

    def restore_layout(self, layout: QByteArray) -> None:
        """Move the panels to the places and heights of a stored layout, if it has the same panels."""
        if self._window.restoreState(layout, self.version):
            self._front = None

    def leave(self) -> None:
        """Hide the floating panels before the window closes."""
        for dock in self:
            if dock.isFloating():
                dock.hide()

    def _make_action(self, dock: QDockWidget, key: str) -> QAction:
        """Checked while the panel is open; it opens the panel, brings it to the front and gives it the keyboard.

        A panel that is open behind a tab is not seen, so it is raised before it is closed. When a panel with the
        keyboard closes, the canvas gets it.
        """
        action = QAction(dock.windowTitle(), dock, checkable=True)
        action.setObjectName(f"panel_{dock.objectName()}")
        action.setStatusTip(tr("Show or hide the panel {title}.").format(title=dock.windowTitle()))
        action.setShortcut(QKeySequence(key))

        def follow() -> None:
            action.setChecked(not dock.isHidden())

        def do() -> None:
            if dock.visibleRegion().isEmpty():  # hidden, or behind the tab of another one
                self.enter(dock.objectName())
            else:
                focused = dock.focusWidget()
                inside = focused is not None and focused.hasFocus()
                dock.close()
                if inside:
                    self._keyboard.give_back()
            follow()

        dock.toggleViewAction().toggled.connect(follow)
        dock.visibilityChanged.connect(follow)
        action.triggered.connect(do)
        follow()
        return action

    def _tidy(self) -> None:
        """Show no heading where a tab names a panel, and that of a panel below the canvas upright next to it."""
        for dock in self:
            beside = self._window.tabifiedDockWidgets(dock)
            tabbed = not dock.isFloating() and any(not other.isHidden() for other in beside)
            if tabbed != (dock.titleBarWidget() is not None):
                dock.setTitleBarWidget(QWidget(dock) if tabbed else None)  # type: ignore[arg-type]  # None is Qt's own
            below = self._window.dockWidgetArea(dock) in _LOW_AREAS and not dock.isFloating() and not tabbed
            dock.setFeatures(dock.features() | _UPRIGHT if below else dock.features() & ~_UPRIGHT)
        for bar in self._window.findChildren(QTabBar, options=Qt.FindChildOption.FindDirectChildrenOnly):
            bar.setElideMode(Qt.TextElideMode.ElideNone)
            bar.setUsesScrollButtons(True)
            bar.setExpanding(False)
            bar.setDrawBase(False)
        self._fit()

    def _fit(self) -> None:
        """Give the area below the canvas the height of the panel in front: a timeline is lower than a table."""
        for panel in self._panels:
            dock = self._docks[panel.name]
            below = self._window.dockWidgetArea(dock) in _LOW_AREAS and not dock.isFloating()
            if panel.tab == BELOW and below and not dock.visibleRegion().isEmpty():
                if self._front not in (None, panel.name):
                    self._window.resizeDocks([dock], [panel.height], Qt.Orientation.Vertical)
                self._front = panel.name
                return
