"""Panels in docks around the canvas."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator, Sequence
from functools import partial

from PySide6.QtCore import QEvent, QObject, Qt, QTimer
from PySide6.QtWidgets import QDockWidget, QMainWindow, QTabBar, QTabWidget, QWidget

from app.views.theme.theme import Theme
from app.views.window.docking.heights import DockHeights
from app.views.window.docking.panel_title import PanelTitle
from app.views.window.feature import Area, Panel
from app.views.window.keys.areas import Areas
from app.views.window.keys.panel_action import PanelAction

_AREAS: dict[Area, Qt.DockWidgetArea] = {
    "left": Qt.DockWidgetArea.LeftDockWidgetArea,
    "right": Qt.DockWidgetArea.RightDockWidgetArea,
    "bottom": Qt.DockWidgetArea.BottomDockWidgetArea,
}
_LOW_AREAS = (Qt.DockWidgetArea.BottomDockWidgetArea, Qt.DockWidgetArea.TopDockWidgetArea)
_UPRIGHT = QDockWidget.DockWidgetFeature.DockWidgetVerticalTitleBar
_FEATURES = (
    QDockWidget.DockWidgetFeature.DockWidgetClosable
    | QDockWidget.DockWidgetFeature.DockWidgetMovable
    | QDockWidget.DockWidgetFeature.DockWidgetFloatable
)

_WIDTH = 330
"""Initial width of the panels beside the canvas [px]."""

_NEXT = 4
"""Largest distance of a panel from the tabs above it [px]."""


class Docks(QObject):
    """One dock for each panel, which the user can move, close and open again.

    Tabbed panels are named by their tabs and have no heading; that of a panel below the canvas stands beside it.
    """

    def __init__(self, window: QMainWindow, panels: Iterable[Panel], areas: Areas) -> None:
        super().__init__(window)
        self._window = window
        self._areas = areas
        self.actions: list[PanelAction] = []
        self._panels = list(panels)
        self._docks: dict[str, QDockWidget] = {}
        self._theme: Theme | None = None
        self._titles: dict[tuple[str, bool], PanelTitle] = {}
        """Headings by the name of the panel, and whether it stands beside the panel; made when they are needed."""
        self._untitled: dict[str, QWidget] = {}
        self.heights = DockHeights(window)
        self._tidying = QTimer(self)
        self._tidying.setSingleShot(True)
        self._tidying.timeout.connect(self._tidy)
        # Panels beside the canvas reach the bottom of the window; those below the canvas are as wide as the canvas.
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
        """Version of the stored layout, computed from the panels: a layout with other panels cannot be used."""
        return zlib.crc32(",".join(self._docks).encode()) & 0x7FFFFFFF

    def reveal(self, name: str) -> None:
        """Open a panel and bring it to the front."""
        self._docks[name].show()
        self._docks[name].raise_()

    def conceal(self, name: str) -> None:
        """Close a panel."""
        self._docks[name].hide()

    def restore(self) -> None:
        """Move every panel to its initial place."""
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
        self.heights.restore()
        self._tidying.start()

    def leave(self) -> None:
        """Hide the floating panels before the window closes."""
        for dock in self:
            if dock.isFloating():
                dock.hide()

    def use_theme(self, theme: Theme) -> None:
        """Tint the headings."""
        self._theme = theme
        for title in self._titles.values():
            title.use_theme(theme)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Tidy when a tab bar may have been added: Qt emits no signal when panels become tabbed."""
        if event.type() in (QEvent.Type.ChildAdded, QEvent.Type.LayoutRequest):
            self._tidying.start()
        return super().eventFilter(watched, event)

    def _make(self, panel: Panel) -> None:
        dock = QDockWidget(panel.title, self._window)
        dock.setObjectName(panel.name)
        dock.setWidget(panel.widget)
        self.actions.append(
            PanelAction(dock, panel.shortcut, partial(self._areas.enter, panel.name), self._areas.leave)
        )
        self._docks[panel.name] = dock
        self._untitled[panel.name] = QWidget(dock)
        dock.setTitleBarWidget(self._title(panel.name, upright=False))
        self.heights.add(dock, panel)
        for changed in (dock.topLevelChanged, dock.dockLocationChanged, dock.visibilityChanged):
            changed.connect(lambda *_: self._tidying.start())

    def _title(self, name: str, upright: bool) -> PanelTitle:
        if (name, upright) not in self._titles:
            made = self._titles[name, upright] = PanelTitle(self._docks[name], upright)
            if self._theme is not None:
                made.use_theme(self._theme)
        return self._titles[name, upright]

    def _has_panel(self, bar: QTabBar) -> bool:
        """Whether a panel lies directly below a tab bar."""
        place = bar.geometry()
        return any(
            not dock.isHidden() and dock.x() == place.x() and 0 <= dock.y() - place.bottom() <= _NEXT for dock in self
        )

    def _tidy(self) -> None:
        """Give headings to the panels without a tab, and show the full names in tabs."""
        for name, dock in self._docks.items():
            beside: Sequence[QDockWidget] = self._window.tabifiedDockWidgets(dock)
            tabbed = not dock.isFloating() and any(not other.isHidden() for other in beside)
            upright = not dock.isFloating() and self._window.dockWidgetArea(dock) in _LOW_AREAS
            wanted = self._untitled[name] if tabbed else self._title(name, upright)
            if dock.titleBarWidget() is not wanted:
                dock.setFeatures(_FEATURES | _UPRIGHT if upright and not tabbed else _FEATURES)
                before = dock.titleBarWidget()
                dock.setTitleBarWidget(wanted)
                before.hide()
                wanted.show()
        for bar in self._window.findChildren(QTabBar, options=Qt.FindChildOption.FindDirectChildrenOnly):
            # Qt leaves tab bars of earlier arrangements in place, with names of panels that are elsewhere. Those that
            # it has moved outside the window are not touched: Qt would show them again, in an endless loop.
            away = bar.geometry().right() < 0 or bar.geometry().bottom() < 0
            if not away and bar.isHidden() == self._has_panel(bar):
                bar.setVisible(bar.isHidden())
            if bar.elideMode() != Qt.TextElideMode.ElideNone:
                bar.setElideMode(Qt.TextElideMode.ElideNone)
                bar.setUsesScrollButtons(True)
                bar.setExpanding(False)
                bar.setDrawBase(False)
