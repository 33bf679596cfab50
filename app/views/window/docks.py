"""Panels in docks around the canvas."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator, Sequence

from PySide6.QtCore import QEvent, QObject, Qt, QTimer
from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import QDockWidget, QMainWindow, QTabBar, QTabWidget, QWidget

from app.model.text.language import tr
from app.views.theme.theme import Theme
from app.views.widgets.panel_title import PanelTitle
from app.views.window.feature import Area, Panel

_AREAS: dict[Area, Qt.DockWidgetArea] = {
    "left": Qt.DockWidgetArea.LeftDockWidgetArea,
    "right": Qt.DockWidgetArea.RightDockWidgetArea,
    "bottom": Qt.DockWidgetArea.BottomDockWidgetArea,
}
_WIDTH = 352
"""Width of what stands beside the canvas at first [px]."""

_LEAST = 1
"""Height of what lies below the canvas: as little as it bears [px]."""

_NEXT = 4
"""Distance at which a panel lies just below its tabs [px]."""

_UPPER_SHARE = 0.36
"""Share of the height that the uppermost panel beside the canvas gets."""


class Docks(QObject):
    """One dock a panel, which a person may move, close and bring back.

    Panels that lie upon each other are named by their tabs and need no heading of their own.

    Parameters
    ----------
    window : QMainWindow
        Around whose canvas they lie.
    panels : iterable of Panel
        What there is.
    """

    def __init__(self, window: QMainWindow, panels: Iterable[Panel]) -> None:
        super().__init__(window)
        self._window = window
        self._panels = list(panels)
        self._docks: dict[str, QDockWidget] = {}
        self._titles: dict[str, PanelTitle] = {}
        self._untitled: dict[str, QWidget] = {}
        self._tidying = QTimer(self)
        self._tidying.setSingleShot(True)
        self._tidying.timeout.connect(self._tidy)
        # What stands beside the canvas goes down to the foot of the window; what lies below it is as wide as it.
        window.setCorner(Qt.Corner.BottomRightCorner, Qt.DockWidgetArea.RightDockWidgetArea)
        window.setCorner(Qt.Corner.BottomLeftCorner, Qt.DockWidgetArea.LeftDockWidgetArea)
        window.setDockOptions(
            QMainWindow.DockOption.AnimatedDocks
            | QMainWindow.DockOption.AllowTabbedDocks
            | QMainWindow.DockOption.AllowNestedDocks
        )
        window.setTabPosition(Qt.DockWidgetArea.AllDockWidgetAreas, QTabWidget.TabPosition.North)
        for panel in self._panels:
            self._make(panel)
        self.restore()
        window.installEventFilter(self)

    def __getitem__(self, name: str) -> QDockWidget:
        return self._docks[name]

    def __iter__(self) -> Iterator[QDockWidget]:
        return iter(self._docks.values())

    @property
    def version(self) -> int:
        """Number of the places that are remembered: where other panels were known, new ones would have none."""
        return zlib.crc32(",".join(self._docks).encode()) & 0x7FFFFFFF

    def reveal(self, name: str) -> None:
        """Open a panel and bring it to the front."""
        self._docks[name].show()
        self._docks[name].raise_()

    def restore(self) -> None:
        """Put every panel where it is at first."""
        window = self._window
        first: dict[tuple[Area, str], QDockWidget] = {}
        for panel in self._panels:
            dock, key = self._docks[panel.name], (panel.area, panel.tab)
            dock.setFloating(False)
            if panel.tab and key in first:
                window.tabifyDockWidget(first[key], dock)
            else:
                window.addDockWidget(_AREAS[panel.area], dock)
                first[key] = dock
        for panel in self._panels:
            if self._docks[panel.name].isHidden() == panel.shown:
                self._docks[panel.name].setVisible(panel.shown)
        for dock in first.values():
            dock.raise_()
        beside = [dock for (area, _), dock in first.items() if area == "right"]
        window.resizeDocks(beside, [_WIDTH] * len(beside), Qt.Orientation.Horizontal)
        below = [dock for (area, _), dock in first.items() if area == "bottom"]
        window.resizeDocks(below, [_LEAST] * len(below), Qt.Orientation.Vertical)
        self._share_height(beside)
        self._tidying.start()

    def leave(self) -> None:
        """Take away the panels that are windows of their own, for the window is about to close."""
        for dock in self:
            if dock.isFloating():
                dock.hide()

    def use_theme(self, theme: Theme) -> None:
        """Tint the headings."""
        for title in self._titles.values():
            title.use_theme(theme)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Panels come to lie upon each other without any signal; then a tab bar has been added to the window."""
        if event.type() in (QEvent.Type.ChildAdded, QEvent.Type.LayoutRequest):
            self._tidying.start()
        return super().eventFilter(watched, event)

    def _make(self, panel: Panel) -> None:
        dock = QDockWidget(panel.title, self._window)
        dock.setObjectName(panel.name)
        dock.setWidget(panel.widget)
        action = dock.toggleViewAction()
        action.setStatusTip(tr("Show or hide the panel {title}.").format(title=panel.title))
        if panel.shortcut:
            action.setShortcut(QKeySequence(panel.shortcut))
        self._docks[panel.name] = dock
        self._titles[panel.name] = PanelTitle(dock)
        self._untitled[panel.name] = QWidget(dock)
        dock.setTitleBarWidget(self._titles[panel.name])
        for told in (dock.topLevelChanged, dock.dockLocationChanged, dock.visibilityChanged):
            told.connect(self._look_soon)

    def _share_height(self, beside: Sequence[QDockWidget]) -> None:
        """The uppermost gets what it needs at least, and no more than its share; what can be scrolled gets the rest."""
        if len(beside) > 1:
            least = beside[0].minimumSizeHint().height()
            first = max(least, round(_UPPER_SHARE * self._window.height()))
            rest = max(1, self._window.height() - first) // (len(beside) - 1)
            heights = [first, *(rest for _ in beside[1:])]
            self._window.resizeDocks(beside, heights, Qt.Orientation.Vertical)

    def _look_soon(self) -> None:
        self._tidying.start()

    def _leads(self, bar: QTabBar) -> bool:
        """Whether one of the panels lies just below a bar of tabs."""
        place = bar.geometry()
        return any(
            not dock.isHidden() and dock.x() == place.x() and 0 <= dock.y() - place.bottom() <= _NEXT for dock in self
        )

    def _tidy(self) -> None:
        """Give headings to the panels that have no tab, and let no tab cut its name off."""
        for name, dock in self._docks.items():
            beside: Sequence[QDockWidget] = self._window.tabifiedDockWidgets(dock)
            tabbed = not dock.isFloating() and any(not other.isHidden() for other in beside)
            wanted = self._untitled[name] if tabbed else self._titles[name]
            if dock.titleBarWidget() is not wanted:
                before = dock.titleBarWidget()
                dock.setTitleBarWidget(wanted)
                before.hide()
                wanted.show()
        for bar in self._window.findChildren(QTabBar, options=Qt.FindChildOption.FindDirectChildrenOnly):
            # Qt leaves bars of arrangements that are over where they were, with names of panels that are elsewhere.
            # Those that it has put out of sight are left alone: it would show them again, and that would never end.
            away = bar.geometry().right() < 0 or bar.geometry().bottom() < 0
            if not away and bar.isHidden() == self._leads(bar):
                bar.setVisible(bar.isHidden())
            if bar.elideMode() != Qt.TextElideMode.ElideNone:
                bar.setElideMode(Qt.TextElideMode.ElideNone)
                bar.setUsesScrollButtons(True)
                bar.setExpanding(False)
                bar.setDrawBase(False)
