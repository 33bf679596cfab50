"""Makes the films that README.md and docs show, from the real window on the samples.

    QT_QPA_PLATFORM=offscreen python assets/screenshots/make_films.py [NAME ...]

All of them, or those named. Keys and the pointer are real events; frames are taken from the window while it answers.
How long a frame is shown follows from the script and not from how busy the machine is.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable, Mapping
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np
from cpm_app.model.document import edits
from cpm_app.model.document.samples import find_sample_named
from cpm_app.views.features.exchange import ExportFeature
from cpm_app.views.features.volumes import SpaceFeature
from cpm_app.views.panels.parameters import ParametersPanel
from make_screenshots import Stand, each_in_a_window, wait
from PIL import Image as Picture
from PySide6.QtCore import QPoint, QPointF, Qt, QTimer
from PySide6.QtGui import QColor, QFont, QImage, QPainter, QPen, QPolygonF
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractButton, QApplication, QFileDialog, QLineEdit, QStyle, QStyleOptionSlider, QWidget

from cpm_core import Parameters
from tests.app.reading import treat_as_saved

HERE = Path(__file__).parent
NONE = Qt.KeyboardModifier.NoModifier
SIZE = (1024, 640)
"""Width and height of the window [px]."""

LONGEST, LARGEST = 20_000, 1_500_000
"""Longest film [ms], and its largest file [bytes]."""

_ARROW = QPolygonF([QPointF(*at) for at in ((0, 0), (0, 17), (4, 13), (7, 20), (10, 19), (7, 12), (12, 12))])
_GLIDE = 5
"""Frames of a move of the pointer."""

_PACE, _EVERY = 15.0, 6
"""Steps per second of a run that is filmed, and after how many of them a frame is taken."""

_WATCHED = 60
"""Steps for which a slider is watched at each value."""


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
        menu = QApplication.activePopupWidget()
        if menu is not None:
            painter.drawPixmap(self._corner_of(menu), menu.grab())
        dialog = QApplication.activeModalWidget()
        if dialog is not None:
            corner = self._corner_of(dialog)
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

    def _corner_of(self, above: QWidget) -> QPoint:
        """Return where a window of its own is drawn: a menu where it is, a dialog in the middle."""
        if above is QApplication.activePopupWidget():
            return self.window.mapFromGlobal(above.pos())
        return self.window.rect().center() - above.rect().center()

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

    def key(self, key: Qt.Key, named: str, modifier: Qt.KeyboardModifier = NONE, milliseconds: int = 500) -> None:
        """Press a key, and show its name for a while before."""
        self._key = named
        self.frame(milliseconds)
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
        corner = self._corner_of(above)
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

    def click_menu(self, name: str) -> None:
        """Click an action of the menu File, by its name."""
        bar, menu, action = self.window.menuBar(), self.window.menus["File"], self.window.actions_by_name[name]
        self.click(bar, bar.actionGeometry(menu.menuAction()).center())
        self.click(menu, menu.actionGeometry(action).center())

    def answer(self, name: str) -> None:
        """Answer the file dialog that is about to open with a name, unseen: it shows a temporary folder."""
        dialog = QApplication.activeModalWidget()
        if not isinstance(dialog, QFileDialog):
            QTimer.singleShot(50, partial(self.answer, name))
            return
        field = dialog.findChild(QLineEdit)
        assert field is not None
        field.setText(name)
        self._pressed = False
        QTest.keyClick(field, Qt.Key.Key_Return)

    def slide(self, name: str, *values: float) -> None:
        """Drag the slider of a parameter to one value after another, and watch the particles at each of them."""
        panel = self.window.findChild(ParametersPanel)
        assert panel is not None
        row = panel.rows[name]
        slider, control, option = row.slider, row.control, QStyleOptionSlider()
        slider.initStyleOption(option)
        handle = slider.style().subControlRect(
            QStyle.ComplexControl.CC_Slider, option, QStyle.SubControl.SC_SliderHandle, slider
        )
        room = slider.width() - handle.width()
        self.point(slider, handle.center())
        QTest.mousePress(slider, Qt.MouseButton.LeftButton, pos=handle.center())
        self._pressed = True
        for value in values:
            place = QStyle.sliderPositionFromValue(
                0, slider.maximum(), round((value - control.slider_low) / control.step), room
            )
            self.point(slider, QPoint(place + handle.width() // 2, handle.center().y()))
            self._key = f"{control.title} {slider.exact:.3g}"
            self.watch(90, _WATCHED)
        QTest.mouseRelease(slider, Qt.MouseButton.LeftButton)
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
        """Press Space, and take frames of the run until its particles rest."""
        self.session.set_pace(_PACE)
        self.key(Qt.Key.Key_Space, "Space")
        self.watch(milliseconds)
        self.settle()

    def watch(self, milliseconds: int, most: float = np.inf) -> None:
        """Take frames of a run for so many steps, or until its particles rest; ever fewer, as they move ever less."""
        first, ran, due = self.session.status.step, 0, 0
        while ran < most and self.session.status.phase != "finished":
            wait(lambda: self.session.status.phase == "finished" or self.session.status.step >= first + due)  # noqa: B023
            self.frame(milliseconds)
            ran = self.session.status.step - first
            due = max(due + _EVERY, int(ran * 1.2))
            if ran > 3 * _EVERY and not self._pressed:
                self._key = ""

    def keep(self, name: str) -> None:
        """Write the film, and check that it is short and small."""
        first, *others = self._frames
        file = HERE / f"{name}.webp"
        times = {"duration": self._shown, "loop": 0}
        first.save(file, save_all=True, append_images=others, quality=30, method=6, **times)
        assert sum(self._shown) < LONGEST and file.stat().st_size < LARGEST, (name, sum(self._shown), file.stat())


def nuclei(film: Film) -> None:
    """Nuclei are found without a drawing, and the objects are accepted and measured."""
    film.stand.open("nuclei.png")
    film.hold(0.8)
    film.run(70)
    wait(lambda: bool(film.session.scene.objects.proposals))
    film.hold(1.0)
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
    row = dialog.list.visualItemRect(dialog.list.rows["skeleton", ".csv"])
    film.click(dialog.list.viewport(), QPoint(row.left() + 8, row.center().y()))
    film.hold(1.5)
    dialog.close()


OUTLINE = ((22.0, 184.0), (216.3, 71.8))
"""Places on the outline of the hand, on either side of where it is open."""


def hand(film: Film) -> None:
    """Show a circle in the palm that finds the outline up to every fingertip, and keep the outline as objects."""
    film.stand.open("hand.png")
    film.hold(0.8)
    film.run(60)
    wait(lambda: bool(film.window.workspace.object_selection.proposals))
    film.hold(0.6)
    film.key(Qt.Key.Key_X, "X")
    film.settle()
    film.key(Qt.Key.Key_S, "S")
    film.click_image(*OUTLINE[0])
    film.click_image(*OUTLINE[1], modifier=Qt.KeyboardModifier.ShiftModifier)
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


STARTS: Mapping[str, tuple[tuple[float, float], float]] = {
    "hand.png": ((352.0, 200.0), 4.0),
    "artery.png": ((55.0, 113.5), 4.0),
    "cells.png": ((190.0, 130.0), 40.0),
}
"""Center and radius [px] of a circle, by sample: in a bone of the wrist, in an artery, and across two cells."""


def slider(film: Film, name: str, farther: float, nearer: float) -> None:
    """On three images a run rests at the published values; a slider lets its fronts go farther, and back."""
    for file, (center, radius) in STARTS.items():
        treat_as_saved(film.window)
        film.stand.open(file)
        film.session.edit(
            "preset", lambda document: edits.apply_preset(document, Parameters(reach=8.0, weakest_edge=0.5))
        )
        film.session.edit("clear", edits.clear_shapes)
        film.settle()
        film.key(Qt.Key.Key_C, "C")
        start, end = (
            film.canvas.map_from_image(place).toPoint() for place in (center, (center[0], center[1] + radius))
        )
        film.drag(film.canvas.viewport(), start, end)
        film.session.select_shape(None)
        film.run(60)
        film.hold(0.4)
        film.slide(name, farther, nearer)


FIELD, COUNT = 160, (3, 4)
"""Side of an image of the folder [px], and how many of them there are in the rows and columns of the sample."""


def folder(film: Film) -> None:
    """Work through twelve images of cells in a folder, from opening it to one table of all objects."""
    sample = find_sample_named("cells.png")
    assert sample is not None
    with Picture.open(sample.path) as picture, tempfile.TemporaryDirectory() as root:
        plate = Path(root) / "plate"
        plate.mkdir()
        tops, lefts = (np.linspace(0, picture.width - FIELD, count, dtype=int) for count in COUNT)
        for number, (top, left) in enumerate(product(tops.tolist(), lefts.tolist()), start=1):
            picture.crop((left, top, left + FIELD, top + FIELD)).save(plate / f"field_{number:02}.png")
        film.window.files.remember_path("open", plate)
        film.answer("plate")
        film.click_menu("open_folder")
        _work_through(film)


def _work_through(film: Film) -> None:
    """Find the cells of the first image, apply this to all, review them, and export the table."""
    project, selection = film.window.workspace.project, film.window.workspace.object_selection
    wait(lambda: project.current is not None)
    film.settle()
    film.hold(0.8)
    film.click(film.button("Automatic"))
    film.settle()
    film.run(70)
    for number, path in enumerate(project.images):
        milliseconds = 500 if number < 2 else 150
        wait(lambda: project.current == path and bool(selection.proposals))  # noqa: B023
        film.settle()
        film.hold(milliseconds / 1000)
        film.key(Qt.Key.Key_Return, "Enter", NONE, milliseconds)
        film.settle()
        if number == 0:
            film.hold(0.6)
            film.click_menu("apply_to_all")
            film.hold(0.8)
        film.key(Qt.Key.Key_Return, "Ctrl+Enter", Qt.KeyboardModifier.ControlModifier, milliseconds)
    film.settle()
    film.hold(1.5)
    film.answer("plate_objects.csv")
    film.click_menu("export_all_images")


FILMS: Mapping[str, Callable[[Film], None]] = {
    "nuclei": nuclei,
    "artery": artery,
    "hand": hand,
    "head": head,
    "damping": partial(slider, name="beta", farther=0.15, nearer=2.0),
    "weights": partial(slider, name="ratio", farther=0.99, nearer=0.3),
    "annealing": partial(slider, name="annealing", farther=0.999, nearer=0.92),
    "folder": folder,
}


def main(names: list[str]) -> None:
    """Take the films, each of a window of its own."""
    for name, stand in each_in_a_window(names or list(FILMS), SIZE):
        film = Film(stand)
        FILMS[name](film)
        film.keep(f"{name}_film")


if __name__ == "__main__":
    main(sys.argv[1:])
