"""The action of a panel: its key opens it, raises it from behind its tab, or closes it."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QDockWidget

from app.model.text.language import tr


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
