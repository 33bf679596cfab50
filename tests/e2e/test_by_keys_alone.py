"""The main job from the sample to the exported file, with keys only and no mouse."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from cpm_app.views.features.files import StartFeature
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import Qt, QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QFileDialog, QWidget

from cpm_core.shapes import Circle
from tests.e2e.conftest import PATIENCE

KEY, SHIFT, CONTROL, ALT = Qt.Key, Qt.KeyboardModifier.ShiftModifier, Qt.KeyboardModifier.ControlModifier, (
    Qt.KeyboardModifier.AltModifier
)  # fmt: skip


class Keys:
    """Keys that go where the window system would send them."""

    def __init__(self, qtbot) -> None:
        self._qtbot = qtbot

    def press(self, *keys: Qt.Key, held: Qt.KeyboardModifier = Qt.KeyboardModifier.NoModifier) -> None:
        """Press keys one after the other."""
        for key in keys:
            QTest.keyClick(QApplication.activePopupWidget() or QApplication.focusWidget(), key, held)

    def type(self, text: str) -> None:
        """Type over what is selected."""
        QTest.keyClicks(QApplication.focusWidget(), text)

    def go_to(self, widget: QWidget) -> None:
        """Press Tab until a widget has the keyboard."""
        for _ in range(30):
            if not widget.hasFocus():
                self.press(KEY.Key_Tab)
        assert widget.hasFocus()

    def wait(self, condition: Callable[[], bool]) -> None:
        """Wait until a condition holds."""
        self._qtbot.waitUntil(condition, timeout=PATIENCE)


def test_the_main_job_is_done_by_keys_alone(window, qtbot, tmp_path) -> None:
    keys = Keys(qtbot)
    open_the_sample(window, keys)
    draw_and_run(window, keys)
    move_a_slider(window, keys)
    go_back_and_forward(window, keys)
    select_and_name_an_object(window, keys)
    export(window, keys, tmp_path / "cup.geojson")


def open_the_sample(window: MainWindow, keys: Keys) -> None:
    """By the menu and the start screen."""
    session = window.session
    generation = session.store.image_generation
    keys.press(KEY.Key_F, held=ALT)
    keys.press(KEY.Key_M)
    keys.wait(window.get_feature(StartFeature).screen.isVisible)
    window.activateWindow()  # as a window manager does when a menu closes
    keys.wait(window.isActiveWindow)
    keys.press(KEY.Key_Return)
    keys.wait(lambda: session.store.image_generation != generation and session.idle)
    assert session.document.image.name == "u_shape.png"
    window.activateWindow()  # as a window manager does when a menu closes
    keys.wait(window.isActiveWindow)


def draw_and_run(window: MainWindow, keys: Keys) -> None:
    """Choose a tool, draw with the cross-hair, run."""
    session = window.session
    drawn = len(session.document.shapes)
    keys.press(KEY.Key_C, KEY.Key_Return, KEY.Key_Return)
    keys.press(KEY.Key_Right, held=SHIFT)
    keys.press(KEY.Key_Return, KEY.Key_Escape)
    assert len(session.document.shapes) == drawn + 1
    assert isinstance(session.document.shapes[-1], Circle)
    keys.press(KEY.Key_Space)
    keys.wait(lambda: session.status.phase == "finished" and session.idle)


def move_a_slider(window: MainWindow, keys: Keys) -> None:
    """Go to it from the image, move it, and come back."""
    session = window.session
    beta = window.panels["run"].parameters.rows["beta"].slider
    keys.press(KEY.Key_Q)
    keys.go_to(beta)
    before = session.document.parameters.beta
    keys.press(KEY.Key_Right, KEY.Key_Right, KEY.Key_Return)
    assert session.document.parameters.beta > before
    assert window.canvas_area.canvas.hasFocus()


def go_back_and_forward(window: MainWindow, keys: Keys) -> None:
    """On the timeline."""
    workspace = window.workspace
    last = workspace.navigation.current_step[1]
    keys.press(KEY.Key_F6, held=SHIFT)
    keys.press(KEY.Key_Left, KEY.Key_Left)
    keys.wait(lambda: workspace.navigation.current_step[1] == last - 2)
    keys.press(KEY.Key_End)
    keys.wait(lambda: workspace.navigation.current_step[1] == last)


def select_and_name_an_object(window: MainWindow, keys: Keys) -> None:
    """With the cross-hair."""
    session, workspace, selection = window.session, window.workspace, window.workspace.object_selection
    keys.press(KEY.Key_W)
    keys.wait(lambda: selection.idle and selection.offer_is_known and bool(selection.proposals))
    keys.press(KEY.Key_X)
    keys.wait(lambda: selection.idle and not selection.proposals)
    keys.press(KEY.Key_Return)  # show the cross-hair
    crosshair = window.canvas_area.crosshair
    keys.wait(lambda: crosshair.position is not None)
    for _ in range(6):
        keys.press(KEY.Key_Down, held=SHIFT)
    keys.press(KEY.Key_Return)
    keys.wait(lambda: workspace.object_selection.idle and bool(workspace.object_selection.proposals))
    keys.press(KEY.Key_Return, held=CONTROL)
    keys.press(KEY.Key_F2)
    keys.type("cup")
    keys.press(KEY.Key_Return)
    keys.wait(lambda: [item.name for item in session.document.objects.items] == ["cup"])


def export(window: MainWindow, keys: Keys, path: Path) -> None:
    """To a file in another folder: format and name in the form, the folder in the dialog of the system."""
    keys.press(KEY.Key_E, held=CONTROL)
    keys.wait(lambda: QApplication.activeModalWidget() is not None)
    dialog = QApplication.activeModalWidget()
    keys.wait(dialog.isActiveWindow)
    keys.go_to(dialog.list)
    for _ in range(40):
        if not any(file.suffix == path.suffix for file in dialog.checked_files):
            keys.press(KEY.Key_Down, KEY.Key_Space)
    keys.go_to(dialog.base)
    keys.press(KEY.Key_A, held=CONTROL)
    keys.type(path.stem)
    keys.go_to(dialog._folder_button)
    named = []

    def name_the_file() -> None:
        """While the button waits for the answer."""
        asked = QApplication.activeModalWidget()
        if not isinstance(asked, QFileDialog) or not asked.isActiveWindow():
            return
        asking.stop()
        keys.type(str(path.parent))
        keys.press(KEY.Key_Return)
        named.append(asked.result())
        if asked.isVisible():
            asked.reject()  # else the test would never end

    asking = QTimer(dialog, interval=20)
    asking.timeout.connect(name_the_file)
    asking.start()
    keys.press(KEY.Key_Space)
    assert named == [QFileDialog.DialogCode.Accepted]
    dialog.activateWindow()  # as a window manager does when a dialog closes
    keys.wait(dialog.isActiveWindow)
    path = next(file.path for file in dialog.checked_files if file.suffix == path.suffix)
    keys.press(KEY.Key_E, held=ALT)
    keys.wait(path.exists)
    assert json.loads(path.read_text())["features"]
    keys.wait(lambda: window.session.idle)
    keys.wait(window.isActiveWindow)
    assert window.canvas_area.canvas.hasFocus()
