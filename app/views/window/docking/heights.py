"""Heights of docks: those below the canvas are remembered for each panel, others follow their content."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, Qt, QTimer
from PySide6.QtWidgets import QDockWidget, QMainWindow, QTabBar

from app.views.window.feature import Panel

_LEAST = 1
"""Requested height of a panel that has none of its own; Qt enlarges it to the minimum [px]."""

_NEXT = 4
"""Largest distance of a dock from the tabs above it [px]."""

_SHARE = 0.42
"""Largest share of the window's height for a panel that follows its content."""


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
            room = round(_SHARE * self._window.height())
            height = min(panel.widget.sizeHint().height() + heading, room)
            area = self._window.dockWidgetArea(dock)
            others = [
                other
                for other in self._docks
                if other is not dock and not other.visibleRegion().isEmpty() and not other.isFloating()
                if self._window.dockWidgetArea(other) == area
            ]
            known = height, [other.objectName() for other in others]
            if self._fits.get(panel.name) == known:
                continue
            self._fits[panel.name] = known
            # together as high as they are now: Qt scales other heights
            rest = max(1, dock.height() + sum(other.height() for other in others) - height)
            heights = [height, *(rest // len(others) for _ in others)]
            self._window.resizeDocks([dock, *others], heights, Qt.Orientation.Vertical)
