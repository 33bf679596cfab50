"""Panels in docks around the canvas."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import QDockWidget, QMainWindow

from app.model.language import tr
from app.views.part import Area, Panel

_AREAS: dict[Area, Qt.DockWidgetArea] = {
    "left": Qt.DockWidgetArea.LeftDockWidgetArea,
    "right": Qt.DockWidgetArea.RightDockWidgetArea,
    "bottom": Qt.DockWidgetArea.BottomDockWidgetArea,
}
_WIDTH = 352
"""Width of what stands beside the canvas at first [px]."""


class Docks:
    """One dock a panel, which a person may move, close and bring back.

    Parameters
    ----------
    window : QMainWindow
        Around whose canvas they lie.
    panels : iterable of Panel
        What there is.
    """

    def __init__(self, window: QMainWindow, panels: Iterable[Panel]) -> None:
        self._window = window
        self._docks: dict[str, QDockWidget] = {}
        # What stands beside the canvas goes down to the foot of the window; what lies below it is as wide as it.
        window.setCorner(Qt.Corner.BottomRightCorner, Qt.DockWidgetArea.RightDockWidgetArea)
        window.setCorner(Qt.Corner.BottomLeftCorner, Qt.DockWidgetArea.LeftDockWidgetArea)
        window.setDockOptions(
            QMainWindow.DockOption.AnimatedDocks
            | QMainWindow.DockOption.AllowTabbedDocks
            | QMainWindow.DockOption.AllowNestedDocks
        )
        first: dict[tuple[Area, str], QDockWidget] = {}
        for panel in panels:
            dock = self._make(panel)
            key = (panel.area, panel.tab)
            window.addDockWidget(_AREAS[panel.area], dock)
            if panel.tab and key in first:
                window.tabifyDockWidget(first[key], dock)
            else:
                first[key] = dock
            dock.setVisible(panel.shown)
        for dock in first.values():
            dock.raise_()
        beside = [dock for (area, _), dock in first.items() if area == "right"]
        window.resizeDocks(beside, [_WIDTH] * len(beside), Qt.Orientation.Horizontal)

    def __getitem__(self, name: str) -> QDockWidget:
        return self._docks[name]

    def __iter__(self) -> Iterator[QDockWidget]:
        return iter(self._docks.values())

    def reveal(self, name: str) -> None:
        """Open a panel and bring it to the front."""
        self._docks[name].show()
        self._docks[name].raise_()

    def _make(self, panel: Panel) -> QDockWidget:
        dock = QDockWidget(panel.title, self._window)
        dock.setObjectName(panel.name)
        dock.setWidget(panel.widget)
        action = dock.toggleViewAction()
        action.setStatusTip(tr("Show or hide the panel {title}.").format(title=panel.title))
        if panel.shortcut:
            action.setShortcut(QKeySequence(panel.shortcut))
        self._docks[panel.name] = dock
        return dock
