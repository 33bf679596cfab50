"""How long tasks take in the window, by real mouse and keys, with few corrections, and how right the objects are.

Run it on a display: ``python tests/benchmarks/timed_tasks.py IMAGE --labels LABELS [--corrections 3]`` runs the mode
Automatic, accepts what Enter accepts, and corrects what differs most from the labels as a user who sees them would: a
click in a missing object and Enter, or a click and Delete for one too many. With ``--steps STEP ...`` it does what it
is told with the tool Objects: ``120,79`` clicks there, ``x120,79`` clicks with Shift, and ``Return``, ``]`` or another
key is pressed. Without labels the objects are to be looked at: ``--picture FILE`` is the window at the end. A user
needs time to look and to aim, ``--pace`` [s] before each step; the rest is waiting.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

import numpy as np
from PIL import Image
from PySide6.QtCore import QSettings, Qt
from PySide6.QtTest import QTest

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from cpm_app.views.window.window import MainWindow

from cpm_core.numerics.grids import measure_depth
from cpm_core.objects import compute_iou
from tests.benchmarks.window import shown_window

FOUND, RIGHT = 0.5, 0.8
"""Overlaps (intersection over union) with a label from which an object is found, and right."""

PATIENCE = 300.0
"""Longest time that anything may take [s]."""

KEYS = {"[": Qt.Key.Key_BracketLeft, "]": Qt.Key.Key_BracketRight}


class User:
    """Works in a window by mouse and keys, and counts the time."""

    def __init__(self, window: MainWindow, path: Path, pace: float) -> None:
        self.pace, self.waited, self.steps = pace, 0.0, 0
        self.window, self.session = window, window.session
        self.selection, self.canvas = window.workspace.object_selection, window.canvas_area.canvas
        self.wait(lambda: self.session.idle)
        self.window.open_image(str(path))
        self.wait(lambda: self.session.image is not None and self.session.idle)
        self.canvas.setFocus()
        self.begin, self.waited = time.perf_counter(), 0.0

    def wait(self, condition: Callable[[], bool]) -> None:
        """Let the window work until a condition holds."""
        begin = time.perf_counter()
        while not condition():
            assert time.perf_counter() < begin + PATIENCE, "this has not happened"
            QTest.qWait(1)
        self.waited += time.perf_counter() - begin

    def settle(self) -> None:
        """Wait until the answer to all that was done is shown."""
        self.wait(lambda: self.session.idle and self.selection.idle and self.selection.answered)

    def press(self, key: Qt.Key) -> None:
        """Press a key after a while."""
        QTest.qWait(int(1e3 * self.pace))
        self.steps += 1
        QTest.keyClick(self.window.focusWidget() or self.window, key)
        self.settle()

    def click(self, place: np.ndarray, modifier: Qt.KeyboardModifier = Qt.KeyboardModifier.NoModifier) -> None:
        """Click a place (row, col) of the image after a while."""
        QTest.qWait(int(1e3 * self.pace))
        self.steps += 1
        point, view = self.canvas.map_from_image(tuple(place)).toPoint(), self.canvas.viewport()
        QTest.mouseMove(view, point)
        QTest.mouseClick(view, Qt.MouseButton.LeftButton, modifier, point)
        self.settle()

    @property
    def masks(self) -> list[np.ndarray]:
        """The accepted objects, each of shape (H, W)."""
        return [item.region.paste(self.session.image.shape) for item in self.session.document.objects.items]

    def report(self, what: str) -> None:
        took = time.perf_counter() - self.begin
        sys.stdout.write(f"{what}; {self.steps} clicks and keys in {took:.1f} s, {self.waited:.1f} s of them waiting\n")


def innermost(mask: np.ndarray) -> np.ndarray:
    """The place of a mask that is farthest from its boundary."""
    return np.array(np.unravel_index(measure_depth(mask).argmax(), mask.shape))


def rate(masks: list[np.ndarray], labels: list[np.ndarray]) -> np.ndarray:
    """The overlap of each object (row) with each label (column)."""
    return np.array([[compute_iou(one, other) for other in labels] for one in masks]).reshape(-1, len(labels))


def run_and_correct(user: User, labels: list[np.ndarray], most: int, seconds: float) -> int:
    """Run the mode Automatic, accept, and correct; return the number of corrections."""
    user.window.actions_by_name["mode_automatic"].trigger()
    user.press(Qt.Key.Key_Space)
    user.wait(lambda: user.session.status.phase == "finished" and user.selection.offer_is_known)
    user.settle()
    user.press(Qt.Key.Key_Return)
    user.press(Qt.Key.Key_W)
    for correction in range(most):
        overlaps, left = rate(user.masks, labels), seconds - (time.perf_counter() - user.begin)
        wrong = [one for one, best in zip(user.masks, overlaps.max(axis=1, initial=0.0), strict=True) if best < FOUND]
        missing = [one for one, best in zip(labels, overlaps.max(axis=0, initial=0.0), strict=True) if best < FOUND]
        if left < 0.0 or not (wrong or missing):
            return correction
        if wrong:
            user.click(innermost(wrong[0]))
            user.press(Qt.Key.Key_Delete)
        else:
            user.click(innermost(max(missing, key=np.count_nonzero)))
            user.press(Qt.Key.Key_Return)
    return most


def follow(user: User, steps: list[str]) -> None:
    """Do what the steps say with the tool Objects."""
    user.press(Qt.Key.Key_W)
    for step in steps:
        if "," in step:
            held = Qt.KeyboardModifier.ShiftModifier if step.startswith("x") else Qt.KeyboardModifier.NoModifier
            user.click(np.array([float(part) for part in step.removeprefix("x").split(",")]), held)
        else:
            user.press(KEYS.get(step) or getattr(Qt.Key, f"Key_{step}"))


def main() -> None:
    parser = argparse.ArgumentParser(description="Time tasks in the window.")
    parser.add_argument("image", type=Path)
    parser.add_argument("--labels", type=Path)
    parser.add_argument("--steps", nargs="+", default=[])
    parser.add_argument("--corrections", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--pace", type=float, default=0.4)
    parser.add_argument("--picture", type=Path)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        QSettings.setPath(QSettings.Format.IniFormat, QSettings.Scope.UserScope, folder)
        window = stack.enter_context(shown_window(1500, 950))
        user = User(window, given.image, given.pace)
        if given.steps:
            follow(user, given.steps)
            user.report(f"{len(user.masks)} objects")
        else:
            numbers = np.asarray(Image.open(given.labels))
            labels = [numbers == number for number in np.unique(numbers[numbers > 0])]
            corrections = run_and_correct(user, labels, given.corrections, given.seconds)
            best = rate(user.masks, labels).max(axis=0, initial=0.0)
            user.report(
                f"{len(user.masks)} objects for {len(labels)} labels, {corrections} corrections, "
                f"{(best >= FOUND).sum()} found, {(best >= RIGHT).sum()} right, mean overlap {best.mean():.2f}"
            )
        if given.picture is not None:
            QTest.qWait(300)
            window.grab().save(str(given.picture))


if __name__ == "__main__":
    main()
