"""What many tests do in the window."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from cpm_app.model.document import edits
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import Qt

from cpm_core.shapes import Circle
from tests.app.reading import image_name


def draw_circle(window: MainWindow, row: float = 20.0) -> None:
    """Draw a circle on the disc."""
    window.session.edit("draw circle", lambda document: edits.add_shape(document, Circle((row, 30.0), 9.0)))


def open_image(window: MainWindow, hand: Any, path: Path) -> None:
    """Open an image and wait for it."""
    window.open_image(str(path))
    hand.wait(lambda: image_name(window) == path.name and window.session.idle)


def run_to_the_end(window: MainWindow, hand: Any) -> None:
    """Run by Space, and wait until the run has come to rest."""
    hand.canvas.setFocus()
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: window.session.idle)


def wait_for_offers(window: MainWindow, hand: Any) -> None:
    """Wait until a run has come to rest and its objects are offered."""
    selection = window.workspace.object_selection
    hand.wait_for_phase("finished")
    hand.wait(lambda: window.session.idle and selection.idle and selection.offer_is_known)
