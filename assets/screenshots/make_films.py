"""Makes the films that README.md and docs/tasks show, from the real window on the samples.

    QT_QPA_PLATFORM=offscreen python assets/screenshots/make_films.py [NAME ...]

All of them, or those named. Keys and the pointer are real events; frames are taken from the window while it answers.
How long a frame is shown follows from the script and not from how busy the machine is.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from cpm_app.model.document import edits
from cpm_app.views.features.exchange import ExportFeature
from cpm_app.views.features.volumes import SpaceFeature
from make_screenshots import Stand, each_in_a_window, wait
from PIL import Image as Picture
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QColor, QFont, QImage, QPainter, QPen, QPolygonF
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractButton, QApplication, QWidget

HERE = Path(__file__).parent
NONE = Qt.KeyboardModifier.NoModifier
SIZE = (1024, 640)
"""Width and height of the window [px]."""

LONGEST, LARGEST = 13_000, 700_000
"""Longest film [ms], and its largest file [bytes]."""

_ARROW = QPolygonF([QPointF(*at) for at in ((0, 0), (0, 17), (4, 13), (7, 20), (10, 19), (7, 12), (12, 12))])
_GLIDE = 5
"""Frames of a move of the pointer."""

_PACE, _EVERY = 4.0, 6
"""Steps per second of a run that is filmed, and after how many of them a frame is taken."""


class Film:
    """Frames of the window, the pointer that moves over it, and the key that was pressed last."""

    def __init__(self, stand: Stand) -> None:
        self.stand, self.window = stand, stand.window
        self.session = stand.window.session
        self.canvas = stand.window.canvas_area.canvas
        self._frames: list[Picture.Image] = []
        self._shown: list[int] = []
        self._pointer = QPointF(SIZE[0] * 0.4, SIZE[1] * 0.8)
        self._key, self._pressed = "", False

    def frame(self, milliseconds: int) -> None:
        """Take a frame, shown for this time."""
        QApplication.processEvents()
        picture = self.window.grab().toImage().convertToFormat(QImage.Format.Format_RGB888)
        painter = QPainter(picture)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        dialog = QApplication.activeModalWidget()
        if dialog is not None:
            corner = self.window.rect().center() - dialog.rect().center()
            painter.drawPixmap(corner, dialog.grab())
            painter.setPen(QPen(QColor("#5f6368"), 1.5))
            painter.drawRect(dialog.rect().translated(corner))
        if self._key:
            self._draw_key(painter)
        painter.translate(self._pointer)
        if self._pressed:
            painter.setPen(QPen(QColor("#ffb000"), 3))
            painter.drawEllipse(QPointF(0, 0), 13, 13)
        painter.setPen(QPen(QColor("white"), 1.5))
        painter.setBrush(QColor("black"))
        painter.drawPolygon(_ARROW)
        painter.end()
        rows = np.frombuffer(picture.constBits(), np.uint8).reshape(picture.height(), picture.bytesPerLine())
        pixels = rows[:, : 3 * picture.width()].reshape(picture.height(), picture.width(), 3)
        self._frames.append(Picture.fromarray(pixels.copy()))
        self._shown.append(milliseconds)

    def _draw_key(self, painter: QPainter) -> None:
        """Draw the name of a key at the bottom of the canvas."""
        font = QFont(self.window.font())
        font.setPixelSize(22)
        font.setBold(True)
        painter.setFont(font)
        area = self.canvas.rect().translated(self.canvas.mapTo(self.window, QPoint(0, 0)))
        wide = painter.fontMetrics().horizontalAdvance(self._key) + 36
        painter.setPen(QPen(QColor("white"), 1.5))
        painter.setBrush(QColor(20, 22, 26, 235))
        left, top = area.center().x() - wide // 2, area.bottom() - 58
        painter.drawRoundedRect(left, top, wide, 42, 9, 9)
        painter.drawText(left, top, wide, 42, Qt.AlignmentFlag.AlignCenter, self._key)

    def hold(self, seconds: float) -> None:
        """Let the window be looked at."""
        self._key = ""
        self.frame(int(1000 * seconds))

    def key(self, key: Qt.Key, named: str, modifier: Qt.KeyboardModifier = NONE) -> None:
        """Press a key, and show its name."""
        self._key = named
        self.frame(500)
        self.window.activateWindow()
        QTest.keyClick(self.window.focusWidget() or self.window, key, modifier)
        QApplication.processEvents()

    def write(self, text: str) -> None:
        """Type into the field that has the focus."""
        self._key = ""
        for letter in text:
            QTest.keyClicks(QApplication.focusWidget() or self.window, letter)
            self.frame(70)

    def point(self, widget: QWidget, at: QPoint | None = None) -> QPoint:
        """Move the pointer over a widget, its middle unless said otherwise; returns the place in it."""
        at = at or widget.rect().center()
        above = widget.window()
        corner = self.window.rect().center() - above.rect().center()
        start, end = self._pointer, QPointF(widget.mapTo(above, at) + corner)
        self._key = ""
        for part in np.linspace(0.0, 1.0, _GLIDE + 1)[1:]:
            self._pointer = start + (end - start) * float(part * part * (3 - 2 * part))
            QTest.mouseMove(widget, widget.mapFrom(above, self._pointer.toPoint() - corner))
            self.frame(70)
        return at

    def click(self, widget: QWidget, at: QPoint | None = None, modifier: Qt.KeyboardModifier = NONE) -> None:
        """Click a widget."""
        at = self.point(widget, at)
        self._pressed, self._key = True, "Shift + click" if modifier else ""
        self.frame(400 if modifier else 150)
        QTest.mouseClick(widget, Qt.MouseButton.LeftButton, modifier, at)
        self._pressed = False
        QApplication.processEvents()

    def click_image(self, *position: float, modifier: Qt.KeyboardModifier = NONE) -> None:
        """Click a position of the image, and wait for the answer."""
        self.click(self.canvas.viewport(), self.canvas.map_from_image(position).toPoint(), modifier)
        self.settle()

    def drag(self, widget: QWidget, start: QPoint, end: QPoint) -> None:
        """Drag over a widget."""
        self.point(widget, start)
        QTest.mousePress(widget, Qt.MouseButton.LeftButton, pos=start)
        self._pressed = True
        self.point(widget, end)
        QTest.mouseRelease(widget, Qt.MouseButton.LeftButton, pos=end)
        self._pressed = False

    def settle(self) -> None:
        """Wait for runs, and for proposals."""
        self.stand.settle()
        wait(lambda: self.window.workspace.object_selection.idle)

    def button(self, text: str) -> QWidget:
        """Return the visible button of the window with this text."""
        buttons = self.window.findChildren(QAbstractButton)
        return next(button for button in buttons if button.isVisible() and button.text() == text)

    def run(self, milliseconds: int) -> None:
        """Press Space, and take frames of the run until its particles rest; ever fewer, as they move ever less."""
        self.session.set_pace(_PACE)
        self.key(Qt.Key.Key_Space, "Space")
        status, step = self.session.status, 0
        while status.phase != "finished":
            wait(lambda: self.session.status.phase == "finished" or self.session.status.step >= step)  # noqa: B023
            self.frame(milliseconds)
            status, step = self.session.status, max(step + _EVERY, int(step * 1.12))
            if step > 3 * _EVERY:
                self._key = ""
        self.settle()

    def keep(self, name: str) -> None:
        """Write the film, and check that it is short and small."""
        first, *others = self._frames
        file = HERE / f"{name}.webp"
        times = {"duration": self._shown, "loop": 0}
        first.save(file, save_all=True, append_images=others, quality=40, method=4, **times)
        assert sum(self._shown) < LONGEST and file.stat().st_size < LARGEST, (name, sum(self._shown), file.stat())


BETWEEN = (192.0, 195.0)
"""A place between nuclei, which what encloses it takes for an object; its confidence is low."""


def nuclei(film: Film) -> None:
    """Nuclei are found without a drawing; a doubtful proposal is rejected, and all others are accepted and measured."""
    film.stand.open("nuclei.png")
    film.hold(0.8)
    film.run(70)
    film.hold(1.0)
    film.key(Qt.Key.Key_W, "W")
    film.click_image(*BETWEEN)
    film.key(Qt.Key.Key_X, "X")
    film.settle()
    film.hold(0.8)
    film.key(Qt.Key.Key_Return, "Enter")
    film.settle()
    film.window.docks.reveal_panel("objects")
    film.hold(2.0)


def artery(film: Film) -> None:
    """Particles run along an artery; then its center line, colored by its width, and a table of the widths."""
    film.stand.open("artery.png")
    film.hold(0.8)
    film.run(70)
    film.hold(0.8)
    film.click(film.button("Skeleton"))
    film.key(Qt.Key.Key_Space, "Space")
    wait(lambda: film.session.scene.skeleton is not None)
    film.settle()
    film.hold(2.0)
    film.key(Qt.Key.Key_E, "Ctrl+E", Qt.KeyboardModifier.ControlModifier)
    film.hold(0.6)
    dialog = film.window.get_feature(ExportFeature).dialog
    assert dialog is not None
    row = dialog.list.visualItemRect(dialog.rows["skeleton", ".csv"])
    film.click(dialog.list.viewport(), QPoint(row.left() + 8, row.center().y()))
    film.hold(1.5)
    dialog.close()


PALM = (150.0, 120.0)
"""A place in the palm of the hand."""


def hand(film: Film) -> None:
    """Show a circle in the palm that finds the outline up to every fingertip; click the hand, and accept it."""
    film.stand.open("hand.png")
    film.hold(0.8)
    film.run(60)
    film.hold(0.6)
    film.key(Qt.Key.Key_X, "X")
    film.settle()
    film.key(Qt.Key.Key_W, "W")
    film.click_image(*PALM)
    film.settle()
    film.hold(0.8)
    film.key(Qt.Key.Key_Return, "Enter")
    film.settle()
    film.hold(1.5)


def head(film: Film) -> None:
    """Show a lesion and a ventricle of a head, found by one click each, named, and turned in space."""
    film.stand.open("head.tif")
    film.session.edit("clear", edits.clear_shapes)
    film.settle()
    film.hold(0.8)
    film.key(Qt.Key.Key_W, "W")
    view = film.window.get_feature(SpaceFeature).panel.view
    for name, place in (("lesion", (45.0, 31.0)), ("ventricle", (28.0, 55.0))):
        film.click_image(*place)
        film.hold(0.6)
        film.key(Qt.Key.Key_Return, "Enter")
        film.settle()
        if name == "ventricle":
            film.key(Qt.Key.Key_2, "2")
        film.key(Qt.Key.Key_F2, "F2")
        film.write(name)
        film.key(Qt.Key.Key_Return, "Enter")
        film.settle()
        wait(lambda: view.is_idle)
        film.hold(0.6)
    middle = view.rect().center()
    film.drag(view, middle - QPoint(60, 10), middle + QPoint(60, 10))
    wait(lambda: view.is_idle)
    film.hold(1.5)


FILMS: Mapping[str, Callable[[Film], None]] = {"nuclei": nuclei, "artery": artery, "hand": hand, "head": head}


def main(names: list[str]) -> None:
    """Take the films, each of a window of its own."""
    for name, stand in each_in_a_window(names or list(FILMS), SIZE):
        film = Film(stand)
        FILMS[name](film)
        film.keep(f"{name}_film")


if __name__ == "__main__":
    main(sys.argv[1:])
