"""The areas of the window between which the keyboard goes."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from PySide6.QtWidgets import QApplication, QDockWidget, QSlider, QWidget

from app.views.window.keys.keyboard import sliders_of, take_keyboard

AREAS = ("parameters", "contours", "objects", "timeline")
"""The panels that the keyboard visits after the canvas, in this order."""


class Areas:
    """Gives the keyboard to panels and to the canvas; `reveal` brings a panel to the front by its name."""

    def __init__(self, canvas: QWidget, panels: Mapping[str, QWidget], reveal: Callable[[str], None]) -> None:
        self._canvas = canvas
        self._panels = panels
        self._reveal = reveal

    def enter(self, name: str) -> None:
        """Open a panel, bring it to the front and give it the keyboard."""
        self._reveal(name)
        panel = self._panels[name]
        panel.window().activateWindow()
        take_keyboard(self._within(panel))

    def go_on(self, by: int = 1) -> None:
        """Give the keyboard to the next area that is open, or for -1 to the previous one."""
        around: list[str] = ["", *(name for name in AREAS if name in self._panels and self._is_open(name))]
        here = next((name for name in around if name and self._has_keyboard(name)), "")
        name = around[(around.index(here) + by) % len(around)]
        if name:
            self.enter(name)
        else:
            self.leave()

    def leave(self) -> None:
        """Give the keyboard to the canvas."""
        self._canvas.window().activateWindow()
        self._canvas.setFocus()

    def _within(self, panel: QWidget) -> QWidget:
        """What takes the keyboard in a panel: what it says itself, or the slider that had it last, or the first one."""
        proxy, last, sliders = panel.focusProxy(), panel.focusWidget(), sliders_of(panel)
        if proxy is not None:
            return proxy
        if isinstance(last, QSlider) and last in sliders:
            return last
        return sliders[0] if sliders else panel

    def _is_open(self, name: str) -> bool:
        dock = self._panels[name].parentWidget()
        return isinstance(dock, QDockWidget) and not dock.isHidden()

    def _has_keyboard(self, name: str) -> bool:
        focused = QApplication.focusWidget()
        return focused is not None and (focused is self._panels[name] or self._panels[name].isAncestorOf(focused))
