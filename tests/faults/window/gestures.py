"""What a person does with hand and keyboard: each gesture is a row of real events with pauses in between."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from cpm_app.views.tools import TOOLS
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import QMimeData, QPoint, QPointF, QRect, Qt, QUrl
from PySide6.QtGui import QCursor, QDragEnterEvent, QDropEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSlider,
    QApplication,
    QComboBox,
    QFileDialog,
    QLineEdit,
    QMenuBar,
    QSplitter,
    QTabBar,
    QWidget,
)
from shiboken6 import isValid

Gesture = Iterator[float]
"""Sends an event between one pause and the next [s]."""

KEY, LEFT, RIGHT = Qt.Key, Qt.MouseButton.LeftButton, Qt.MouseButton.RightButton
PLAIN, CTRL, SHIFT = (
    Qt.KeyboardModifier.NoModifier,
    Qt.KeyboardModifier.ControlModifier,
    Qt.KeyboardModifier.ShiftModifier,
)
WRITTEN = ("a.cpm", "b.cpm", "c.geojson", "d.csv", "e.svg", "f.gif", "g.png", "i.json", "j.zip")
"""Names of files that are written; each suffix decides on a format where the dialog offers it."""

_HELD = (QAbstractButton, QAbstractSlider, QAbstractItemView, QComboBox, QLineEdit, QTabBar, QMenuBar, QSplitter)
"""Kinds of widgets that are aimed at."""

_NOT_PRESSED = {"quit"}
_TYPED = [
    KEY.Key_0, KEY.Key_1, KEY.Key_5, KEY.Key_Period, KEY.Key_Return, KEY.Key_Tab, KEY.Key_Escape, KEY.Key_Up,
    KEY.Key_Down, KEY.Key_Left, KEY.Key_Right, KEY.Key_Home, KEY.Key_End, KEY.Key_Space, KEY.Key_A, KEY.Key_Delete,
    KEY.Key_Backspace, KEY.Key_PageUp, KEY.Key_PageDown, KEY.Key_F2,
]  # fmt: skip


class Hand:
    """A hand on mouse and keyboard, led by random choices of its own; `folder` has the images."""

    def __init__(self, window: MainWindow, choice: random.Random, folder: Path, images: Sequence[str]) -> None:
        self.window = window
        self.choice = choice
        self.events = 0
        self._folder = folder
        self._images = images

    # Events

    def key(self, key: Qt.Key, modifiers: Qt.KeyboardModifier = PLAIN) -> None:
        """Press and release a key where the keyboard is."""
        self.events += 1
        top = QApplication.activePopupWidget() or QApplication.activeModalWidget() or QApplication.activeWindow()
        window = (top or self.window).windowHandle()
        if window is not None and window.isVisible():
            QTest.keyClick(window, key, modifiers)

    def type(self, text: str) -> None:
        """Type a text where the keyboard is."""
        for letter in text:
            self.events += 1
            focused = QApplication.focusWidget()
            if focused is not None:
                QTest.keyClick(focused, letter)

    def mouse(self, what: str, widget: QWidget, at: QPoint, button: Qt.MouseButton = LEFT) -> None:
        """Send a press, move, release or double click at a point of a widget, by way of its window."""
        self.events += 1
        top = widget.window()
        window, place = top.windowHandle(), widget.mapTo(top, at)
        if not _within(top, place):
            return
        QCursor.setPos(top.mapToGlobal(place))
        match what:
            case "press":
                QTest.mousePress(window, button, PLAIN, place)
            case "move":
                QTest.mouseMove(window, place)
            case "release":
                QTest.mouseRelease(window, button, PLAIN, place)
            case "double":
                QTest.mouseDClick(window, button, PLAIN, place)

    def wheel(self, widget: QWidget, at: QPoint, by: int) -> None:
        """Turn the wheel over a point of a widget."""
        self.events += 1
        top = widget.window()
        window, place = top.windowHandle(), widget.mapTo(top, at)
        if _within(top, place):
            QTest.wheelEvent(window, QPointF(place), QPoint(0, by))

    # Aims

    @property
    def tops(self) -> list[QWidget]:
        """Windows that can be reached now: a popup, or else a dialog that asks, or else all."""
        popup, modal = QApplication.activePopupWidget(), QApplication.activeModalWidget()
        if popup is not None:
            return [popup]
        if modal is not None:
            return [modal]
        others = [top for top in QApplication.topLevelWidgets() if top.isVisible() and top is not self.window]
        return [self.window] * 4 + others

    def some_widget(self) -> QWidget:
        """A visible widget of those that are aimed at."""
        top = self.choice.choice(self.tops)
        found = [
            widget
            for widget in top.findChildren(QWidget)
            if isinstance(widget, _HELD)
            and widget.isVisible()
            and widget.isEnabled()
            and not widget.visibleRegion().isEmpty()
        ]
        return self.choice.choice(found) if found else top

    def some_point(self, widget: QWidget) -> QPoint:
        """A point of the part of a widget that is seen."""
        seen, down, right = widget.visibleRegion().boundingRect(), self.choice.random(), self.choice.random()
        return seen.topLeft() + QPoint(int(right * seen.width()), int(down * seen.height()))

    def some_place(self) -> QPoint:
        """A point of the canvas over the image, or near it."""
        canvas = self.window.canvas_area.canvas
        rows, cols = canvas.shape or (1, 1)
        at = self.choice.uniform(-0.05, 1.05) * rows, self.choice.uniform(-0.05, 1.05) * cols
        point = canvas.map_from_image(at).toPoint()
        inside = canvas.viewport().rect()
        return QPoint(
            min(max(point.x(), inside.left()), inside.right()), min(max(point.y(), inside.top()), inside.bottom())
        )

    def press_named(self, name: str) -> None:
        """Press the key of an action, or choose it in its menu where it has no key."""
        action = self.window.actions_by_name[name]
        keys = action.shortcut()
        self.events += 1
        if keys.isEmpty():
            action.trigger()
        else:
            self.key(KEY(keys[0].key()), keys[0].keyboardModifiers())

    # Gestures

    def draw(self) -> Gesture:
        """Take a tool and draw with it: a drag, or clicks and a double click, sometimes given up."""
        self.press_named(self.choice.choice(TOOLS).name)
        yield 0.0
        canvas = self.window.canvas_area.canvas.viewport()
        if self.choice.random() < 0.6:
            yield from self._drag(canvas, [self.some_place() for _ in range(self.choice.randint(2, 8))])
        else:
            for _ in range(self.choice.randint(1, 6)):
                yield from self._click(canvas, self.some_place())
            if self.choice.random() < 0.5:
                self.mouse("double", canvas, self.some_place())
                self.mouse("release", canvas, self.some_place())
        if self.choice.random() < 0.3:
            yield 0.0
            self.key(self.choice.choice([KEY.Key_Return, KEY.Key_Escape, KEY.Key_Backspace]))

    def go_on_drawing(self) -> Gesture:
        """Click or drag on the image with the tool in use."""
        canvas = self.window.canvas_area.canvas.viewport()
        button = self.choice.choice([LEFT, LEFT, LEFT, LEFT, Qt.MouseButton.MiddleButton, RIGHT])
        yield from self._drag(canvas, [self.some_place() for _ in range(self.choice.randint(1, 5))], button)

    def run(self) -> Gesture:
        """Run, pause, step, reset, and watch for a while."""
        self.press_named(self.choice.choice(["run", "run", "run", "step", "step", "reset", "faster"]))
        yield self.choice.choice([0.0, 0.02, 0.1])

    def travel(self) -> Gesture:
        """Go through the steps of the run."""
        self.press_named(self.choice.choice(["timeline_back", "timeline_forward", "timeline_first", "timeline_last"]))
        yield self.choice.choice([0.0, 0.05])

    def act(self) -> Gesture:
        """Press the key of any action that can be done."""
        names = [*self.window.actions_by_name]
        able = [name for name in names if self.window.actions_by_name[name].isEnabled() and name not in _NOT_PRESSED]
        yield 0.0
        self.press_named(self.choice.choice(able))

    def take_back(self) -> Gesture:
        """Undo and redo a few times."""
        for _ in range(self.choice.randint(1, 6)):
            self.key(KEY.Key_Z, CTRL if self.choice.random() < 0.6 else CTRL | SHIFT)
            yield 0.0

    def click(self) -> Gesture:
        """Click somewhere, sometimes twice."""
        widget = self.some_widget()
        at = self.some_point(widget)
        yield from self._click(_hit(widget), at)
        if self.choice.random() < 0.15 and _alive(widget):
            self.mouse("double", _hit(widget), at)
            self.mouse("release", _hit(widget), at)

    def drag(self) -> Gesture:
        """Drag from one point of a widget to others, as a slider, a divider or a heading is dragged."""
        widget = self.some_widget()
        points = [self.some_point(widget) for _ in range(self.choice.randint(2, 6))]
        yield from self._drag(_hit(widget), points)

    def open_context_menu(self) -> Gesture:
        """Click with the right button."""
        canvas = self.window.canvas_area.canvas.viewport()
        inside = self.choice.random() < 0.5
        widget = canvas if inside else _hit(self.some_widget())
        yield from self._click(widget, self.some_place() if inside else self.some_point(widget), RIGHT)

    def turn_wheel(self) -> Gesture:
        """Turn the wheel over the image or something else."""
        canvas = self.window.canvas_area.canvas.viewport()
        widget = canvas if self.choice.random() < 0.5 else self.some_widget()
        for _ in range(self.choice.randint(1, 4)):
            if _alive(widget):
                self.wheel(widget, self.some_point(widget), self.choice.choice([-120, 120]))
            yield 0.0

    def type_keys(self) -> Gesture:
        """Type some keys where the keyboard is."""
        for _ in range(self.choice.randint(1, 5)):
            modifiers = self.choice.choice([PLAIN, PLAIN, PLAIN, SHIFT])
            self.key(self.choice.choice(_TYPED), modifiers)
            yield 0.0

    def drop_files(self) -> Gesture:
        """Drop an image, a session or what has been exported on the window."""
        written = [path for path in self._folder.iterdir() if path.name in WRITTEN]
        path = self.choice.choice([*(self._folder / name for name in self._images), *sorted(written)])
        data = QMimeData()
        data.setUrls([QUrl.fromLocalFile(str(path))])
        middle = self.window.rect().center()
        action, left = Qt.DropAction.CopyAction, Qt.MouseButton.LeftButton
        self.events += 2
        yield 0.0
        QApplication.sendEvent(self.window, QDragEnterEvent(middle, action, data, left, PLAIN))
        QApplication.sendEvent(self.window, QDropEvent(QPointF(middle), action, data, left, PLAIN))

    def resize(self) -> Gesture:
        """Give the window another size."""
        self.events += 1
        self.window.resize(self.choice.randint(800, 1200), self.choice.randint(500, 720))
        yield 0.0

    def watch(self) -> Gesture:
        """Watch until nothing more happens, or for a while."""
        for _ in range(40):
            if self.window.session.idle:
                return
            yield 0.02

    # Answers

    def answer(self) -> Gesture:
        """Do something with the menu or the dialog that is open."""
        popup, modal = QApplication.activePopupWidget(), QApplication.activeModalWidget()
        if popup is not None:
            yield from self._choose()
        elif isinstance(modal, QFileDialog):
            yield from self._name_file(modal)
        elif self.choice.random() < 0.4:
            yield 0.0
            self.key(self.choice.choice([KEY.Key_Escape, KEY.Key_Return]))
        else:
            yield from self.choice.choice([self.click, self.drag, self.type_keys])()

    def _choose(self) -> Gesture:
        for _ in range(self.choice.randint(0, 8)):
            self.key(self.choice.choice([KEY.Key_Down, KEY.Key_Down, KEY.Key_Up, KEY.Key_Right]))
            yield 0.0
        self.key(self.choice.choice([KEY.Key_Return, KEY.Key_Return, KEY.Key_Escape]))

    def _name_file(self, dialog: QFileDialog) -> Gesture:
        yield 0.0
        if not _alive(dialog):
            return
        if self.choice.random() < 0.25:
            self.key(KEY.Key_Escape)
            return
        names = WRITTEN if dialog.acceptMode() == QFileDialog.AcceptMode.AcceptSave else (*WRITTEN, *self._images)
        dialog.selectFile(str(self._folder / self.choice.choice(names)))
        yield 0.0
        if _alive(dialog):
            self.key(KEY.Key_Return)
        yield 0.0
        if _alive(dialog) and dialog.isVisible():
            self.key(KEY.Key_Escape)

    def _click(self, widget: QWidget, at: QPoint, button: Qt.MouseButton = LEFT) -> Gesture:
        for what in ("move", "press", "release"):
            if _alive(widget):
                self.mouse(what, widget, at, button)
            yield 0.0

    def _drag(self, widget: QWidget, points: Sequence[QPoint], button: Qt.MouseButton = LEFT) -> Gesture:
        self.mouse("move", widget, points[0], button)
        self.mouse("press", widget, points[0], button)
        for point in points[1:]:
            yield 0.0
            if _alive(widget):
                self.mouse("move", widget, point, button)
        yield 0.0
        if _alive(widget):
            self.mouse("release", widget, points[-1], button)

    @property
    def repertoire(self) -> dict[Callable[[], Gesture], int]:
        """The gestures, and how often each is made among the others."""
        return {
            self.draw: 14, self.go_on_drawing: 12, self.run: 14, self.travel: 8, self.act: 12, self.take_back: 7,
            self.click: 12, self.drag: 8, self.open_context_menu: 6, self.turn_wheel: 5, self.type_keys: 4,
            self.drop_files: 2, self.resize: 1, self.watch: 5,
        }  # fmt: skip


def _within(top: QWidget, place: QPoint) -> bool:
    """Whether a place is in a window that is shown; it may have become smaller since the place was chosen."""
    window = top.windowHandle()
    shown = window is not None and window.isVisible()
    return shown and top.rect().contains(place) and QRect(QPoint(), window.size()).contains(place)


def _hit(widget: QWidget) -> QWidget:
    """The part of a widget that takes the mouse."""
    return widget.viewport() if isinstance(widget, QAbstractItemView) else widget


def _alive(widget: QWidget) -> bool:
    """Whether a widget has not been deleted by what was done to it."""
    return isValid(widget)
