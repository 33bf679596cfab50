"""Panels: tabs in one column next to the canvas, and panels below it; their actions and the keyboard focus."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from PySide6.QtCore import QByteArray, QEvent, QObject, Qt
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QApplication, QBoxLayout, QDockWidget, QMainWindow, QTabWidget, QWidget

from cpm_app.model.text.language import tr, translate_core_text
from cpm_app.views.window.keyboard import Keyboard, find_focus_target, focus_and_reveal
from cpm_core.numerics.types import record


@record
class Panel:
    """A panel, either a tab of the column or below the canvas.

    Attributes
    ----------
    name : str
        Name in code.
    title : str
        Text of its tab, in English.
    widget : QWidget
        Content.
    shortcut : str
        Key that moves the keyboard focus to it.
    shown_at_start : bool
        Whether its tab is there from the start; `Docks.set_tab_available` adds others.
    below_canvas : bool
        Whether it is below the canvas; then its feature shows and hides it.
    """

    name: str
    title: str
    widget: QWidget
    shortcut: str = ""
    shown_at_start: bool = True
    below_canvas: bool = False


_COLUMN_WIDTH = 344
"""Initial width of the column [px]."""

_MIN_COLUMN_WIDTH = 304
"""Smallest width of the column [px]."""

_MAX_COLUMN_FRACTION = 0.29
"""Largest fraction of the width of the window that the column takes."""

_FIXED_TABS = ("objects", "run", "layers")
"""Tabs that are always there, in front of those that come and go."""

_LAYOUT_VERSION = 2
"""Version of the stored layout."""


class Docks(QObject):
    """Column of tabs on the right of a window, and the panels in the layout `below_canvas` its canvas."""

    def __init__(self, window: QMainWindow, panels: Iterable[Panel], keyboard: Keyboard, below: QBoxLayout) -> None:
        super().__init__(window)
        self._window, self._keyboard, self._laid_out = window, keyboard, False
        ordered = sorted(panels, key=lambda panel: (*_FIXED_TABS, panel.name).index(panel.name))
        self._panels = {panel.name: panel for panel in ordered}
        self.tabs = QTabWidget(documentMode=True)
        self.tabs.setMinimumWidth(_MIN_COLUMN_WIDTH)
        self.tabs.tabBar().setExpanding(False)
        self.tabs.tabBar().setDrawBase(False)
        self.column = QDockWidget(tr("Panels"), window, features=QDockWidget.DockWidgetFeature.DockWidgetClosable)
        self.column.setObjectName("column")
        self.column.setTitleBarWidget(QWidget(self.column))
        self.column.setWidget(self.tabs)
        self.actions = [self._create_action(panel) for panel in self._panels.values()]
        for name, panel in self._panels.items():
            if panel.below_canvas:
                below.addWidget(panel.widget)
                panel.widget.hide()
            else:
                self.tabs.addTab(panel.widget, translate_core_text(panel.title))
                if not panel.shown_at_start:
                    self.set_tab_available(name, False)
        side = self.column.toggleViewAction()
        side.setText(tr("Si&de panel"))
        side.setObjectName("panel_side")
        side.setStatusTip(tr("Show or hide the panels on the right."))
        side.setShortcut(QKeySequence("Ctrl+B"))
        self.actions.append(side)
        # The column reaches the bottom of the window.
        window.setCorner(Qt.Corner.BottomRightCorner, Qt.DockWidgetArea.RightDockWidgetArea)
        window.addDockWidget(Qt.DockWidgetArea.RightDockWidgetArea, self.column)
        window.installEventFilter(self)

    def bring_to_front(self, name: str) -> None:
        """Bring a tab to the front if it is there, without opening the column."""
        tab = self.tabs.indexOf(self._panels[name].widget)
        if self.tabs.isTabVisible(tab):
            self.tabs.setCurrentIndex(tab)

    def is_in_front(self, name: str) -> bool:
        """Return whether a tab is in front."""
        return self.tabs.currentWidget() is self._panels[name].widget

    def reveal_panel(self, name: str) -> None:
        """Open a panel and bring it to the front."""
        if not self._panels[name].below_canvas:
            self.set_tab_available(name, True)
            self.column.show()
            self.bring_to_front(name)

    def set_tab_available(self, name: str, available: bool) -> None:
        """Add a tab behind the one in front, or remove it."""
        self.tabs.setTabVisible(self.tabs.indexOf(self._panels[name].widget), available)
        self.actions[list(self._panels).index(name)].setVisible(available)

    def enter_panel(self, name: str) -> None:
        """Open a panel, bring it to the front and move the keyboard focus to it."""
        self.reveal_panel(name)
        focus_and_reveal(find_focus_target(self._panels[name].widget))

    def focus_next_area(self, by: int) -> None:
        """Move the keyboard focus to the next visible area for 1, or to the previous one for -1."""
        visible = {name: panel.widget for name, panel in self._panels.items() if panel.widget.isVisible()}
        areas, focused = ["", *visible], QApplication.focusWidget()
        here = next((name for name, widget in visible.items() if focused and widget.isAncestorOf(focused)), "")
        name = areas[(areas.index(here) + by) % len(areas)]
        if name:
            self.enter_panel(name)
        else:
            self._keyboard.focus_canvas()

    def save_layout(self) -> QByteArray:
        """Return the layout of the panels, to be stored."""
        return self._window.saveState(_LAYOUT_VERSION)

    def restore_layout(self, layout: QByteArray) -> None:
        """Restore a stored layout of the panels."""
        self._laid_out = self._window.restoreState(layout, _LAYOUT_VERSION)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Limit the column to its fraction of the width of the window."""
        if event.type() == QEvent.Type.Resize:
            self.tabs.setMaximumWidth(max(round(_MAX_COLUMN_FRACTION * self._window.width()), _MIN_COLUMN_WIDTH))
        if event.type() == QEvent.Type.Show and not self._laid_out:
            self._laid_out = True
            self._window.resizeDocks([self.column], [_COLUMN_WIDTH], Qt.Orientation.Horizontal)
        return False

    def _create_action(self, panel: Panel) -> QAction:
        """Create the action that moves the keyboard focus to a panel, or back from it to the canvas."""
        title = translate_core_text(panel.title)
        action = QAction(
            title,
            self._window,
            statusTip=tr("Open the panel {title} and move the keyboard focus to it.", title=title),
            shortcut=QKeySequence(panel.shortcut),
        )
        action.setObjectName(f"panel_{panel.name}")
        action.triggered.connect(partial(self._toggle_focus, panel))
        self._window.addAction(action)
        return action

    def _toggle_focus(self, panel: Panel) -> None:
        focused = QApplication.focusWidget()
        if panel.widget.isVisible() and focused is not None and panel.widget.isAncestorOf(focused):
            self._keyboard.focus_canvas()
        elif not panel.below_canvas or panel.widget.isVisible():
            self.enter_panel(panel.name)
