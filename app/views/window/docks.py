"""Panels in docks around the canvas: their places, heights, headings and actions."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial

from PySide6.QtCore import QEvent, QObject, QSize, Qt, QTimer
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QBoxLayout, QDockWidget, QLabel, QMainWindow, QTabBar, QTabWidget, QToolButton, QWidget

from app.model.text.language import tr
from app.views.theme.icons import icon
from app.views.theme.theme import Theme
from app.views.window.feature import Area, Panel
from app.views.window.keyboard import Areas


class PanelAction(QAction):
    """Checked while the panel is open; `enter` opens it, brings it to the front and gives it the keyboard.

    A panel that is open behind a tab is not seen, so it is raised before it is closed. When a panel with the keyboard
    closes, `leave` is called.
    """

    def __init__(self, dock: QDockWidget, key: str, enter: Callable[[], None], leave: Callable[[], None]) -> None:
        super().__init__(dock.windowTitle(), dock)
        self.setObjectName(f"panel_{dock.objectName()}")
        self._dock = dock
        self._enter = enter
        self._leave = leave
        self.setCheckable(True)
        self.setStatusTip(tr("Show or hide the panel {title}.").format(title=dock.windowTitle()))
        if key:
            self.setShortcut(QKeySequence(key))
        dock.toggleViewAction().toggled.connect(self.setChecked)
        dock.visibilityChanged.connect(self._follow)
        self.setChecked(not dock.isHidden())
        self.triggered.connect(self._do)

    @property
    def behind(self) -> bool:
        """Whether the panel is open behind the tab of another one."""
        return not self._dock.isHidden() and self._dock.visibleRegion().isEmpty()

    def _do(self) -> None:
        if self._dock.isHidden() or self.behind:
            self._enter()
        else:
            focused = self._dock.focusWidget()
            inside = focused is not None and focused.hasFocus()
            self._dock.close()
            if inside:
                self._leave()
        self._follow()

    def _follow(self) -> None:
        self.setChecked(not self._dock.isHidden())


class PanelTitle(QWidget):
    """Replaces the title bar of a dock: its name, and buttons to detach and to close it.

    An `upright` one stands at the left of its panel and takes no height; it has the buttons only.
    """

    def __init__(self, dock: QDockWidget, upright: bool = False) -> None:
        super().__init__(dock)
        self.setObjectName("upright" if upright else "title")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        name = QLabel(dock.windowTitle())
        name.setObjectName("heading")
        self._detach = self._button(tr("Detach the panel {title}, or put it back.").format(title=dock.windowTitle()))
        self._close = self._button(
            tr("Close the panel {title}; the menu View opens it again.").format(title=dock.windowTitle())
        )
        self._detach.clicked.connect(lambda: dock.setFloating(not dock.isFloating()))
        self._close.clicked.connect(dock.close)
        direction = QBoxLayout.Direction
        line = QBoxLayout(direction.TopToBottom if upright else direction.LeftToRight, self)
        line.setSpacing(0)
        if upright:
            name.hide()
            self.setToolTip(dock.windowTitle())
            line.setContentsMargins(3, 4, 3, 4)
            line.addWidget(self._close)
            line.addWidget(self._detach)
            line.addStretch(1)
        else:
            line.setContentsMargins(12, 3, 4, 3)
            line.addWidget(name)
            line.addStretch(1)
            line.addWidget(self._detach)
            line.addWidget(self._close)

    def use_theme(self, theme: Theme) -> None:
        """Tint the buttons."""
        self._detach.setIcon(icon("loosen", theme.dim))
        self._close.setIcon(icon("close", theme.dim))

    @staticmethod
    def _button(tip: str) -> QToolButton:
        button = QToolButton()
        button.setObjectName("quiet")
        button.setIconSize(QSize(14, 14))
        button.setAutoRaise(True)
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        button.setToolTip(tip)
        button.setAccessibleName(tip)
        return button


_LEAST = 1
"""Requested height of a panel that has none of its own; Qt enlarges it to the minimum [px]."""

_NEXT = 4
"""Largest distance of a dock from the tabs above it [px]."""

_SHARE = 0.42
"""Largest share of the window's height for a panel that follows its content."""

_AMONG_MANY = 0.15
"""The same where more than one other panel lies beside it."""


class DockHeights(QObject):
    """Gives the area below the canvas the height of the panel in front, and panels beside it that of their content."""

    def __init__(self, window: QMainWindow) -> None:
        super().__init__(window)
        self._window = window
        window.installEventFilter(self)
        self._docks: list[QDockWidget] = []
        self._below: dict[str, tuple[QDockWidget, Panel]] = {}
        self._fitted: list[tuple[QDockWidget, Panel]] = []
        self._chosen: dict[str, int] = {}
        self._shares: dict[str, float] = {}
        self._front = ""
        self._fits: dict[str, tuple[int, list[str]]] = {}
        """Height that a panel had when its dock was fitted to its content, and the docks beside it, by name."""
        self._fitting = QTimer(self, singleShot=True, interval=0)
        self._fitting.timeout.connect(self._fit)
        self._raising = QTimer(self, singleShot=True, interval=0)
        self._raising.timeout.connect(self._follow_front)

    @property
    def chosen(self) -> list[str]:
        """Names and heights that the user has given to the panels below the canvas, as ``name=height``."""
        return [f"{name}={height}" for name, height in self._chosen.items()]

    @chosen.setter
    def chosen(self, values: list[str]) -> None:
        for name, _, height in (value.partition("=") for value in values):
            if name in self._below and height.isdecimal():
                self._chosen[name] = int(height)

    def add(self, dock: QDockWidget, panel: Panel) -> None:
        """Follow one panel."""
        self._docks.append(dock)
        self._shares[panel.name] = panel.share
        if panel.area == "bottom":
            self._below[panel.name] = dock, panel
            dock.visibilityChanged.connect(lambda _: self._raising.start())
            return
        dock.visibilityChanged.connect(lambda _: self._fitting.start())
        if panel.fitted:
            self._fitted.append((dock, panel))
            dock.installEventFilter(self)

    def restore(self) -> None:
        """Forget what the user has chosen."""
        self._chosen.clear()
        self._fits.clear()
        self._front = ""
        self._fitting.start()
        self._raising.start()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Remember the height that a separator was dragged to, and fit panels whose content or window has changed."""
        if event.type() == QEvent.Type.MouseButtonRelease and watched is self._window and self._front:
            self._chosen[self._front] = self._below[self._front][0].height()
        elif event.type() in (QEvent.Type.LayoutRequest, QEvent.Type.Resize):
            if watched is self._window and event.type() == QEvent.Type.Resize:
                self._fits.clear()
                self._front = ""
                self._raising.start()
            self._fitting.start()
        return super().eventFilter(watched, event)

    def _docked(self, dock: QDockWidget) -> bool:
        area = self._window.dockWidgetArea(dock)
        return not dock.isFloating() and area == Qt.DockWidgetArea.BottomDockWidgetArea

    def _follow_front(self) -> None:
        """Give the area the height of the panel that is in front now."""
        for name, (dock, panel) in self._below.items():
            if dock.isVisible() and self._docked(dock) and not dock.visibleRegion().isEmpty():
                if name != self._front:
                    self._front = name
                    height = self._chosen.get(name) or panel.height or _LEAST
                    self._window.resizeDocks([dock], [height + self._tabs(dock)], Qt.Orientation.Vertical)
                return
        self._front = ""

    def _tabs(self, dock: QDockWidget) -> int:
        """Height of the tabs above a dock, which Qt counts as a part of it."""
        bars = self._window.findChildren(QTabBar, options=Qt.FindChildOption.FindDirectChildrenOnly)
        above = (bar for bar in bars if bar.isVisible() and 0 <= dock.y() - bar.geometry().bottom() <= _NEXT)
        return next((bar.height() for bar in above), 0)

    def _fit(self) -> None:
        """Give each panel that follows its content the height of it, and the rest to the panels below it."""
        for dock, panel in self._fitted:
            if not dock.isVisible() or dock.isFloating():
                continue
            heading = dock.height() - panel.widget.height()
            area = self._window.dockWidgetArea(dock)
            others = [
                other
                for other in self._docks
                if other is not dock and not other.visibleRegion().isEmpty() and not other.isFloating()
                if self._window.dockWidgetArea(other) == area
            ]
            room = round((_SHARE if len(others) < 2 else _AMONG_MANY) * self._window.height())
            height = min(panel.widget.sizeHint().height() + heading, room)
            known = height, [other.objectName() for other in others]
            if self._fits.get(panel.name) == known:
                continue
            self._fits[panel.name] = known
            # together as high as they are now: Qt scales other heights
            rest = max(1, dock.height() + sum(other.height() for other in others) - height)
            shares = [self._shares[other.objectName()] for other in others]
            heights = [height, *(int(rest * share / sum(shares)) for share in shares)]
            self._window.resizeDocks([dock, *others], heights, Qt.Orientation.Vertical)


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
