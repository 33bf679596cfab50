"""Makes the pictures of the guide from the real window, by doing what the guide says.

QT_QPA_PLATFORM=offscreen python assets/guide/make_pictures.py

"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from cpm_app.model.document import edits
from cpm_app.model.document.samples import find_sample_named
from cpm_app.views.application import make_application
from cpm_app.views.features.volumes import SpaceFeature
from cpm_app.views.main_window import open_window
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import QDeadlineTimer, QEventLoop, Qt
from PySide6.QtGui import QImage

from cpm_core.shapes import PolygonRegion
from tests.app.reading import treat_as_saved

HERE = Path(__file__).parent
PATIENCE = 60_000
"""Longest wait for anything [ms]."""

WIDTH = 420
"""Width of a picture [px]."""

FINGER = ((10.0, 150.0), (10.0, 214.0), (190.0, 214.0), (190.0, 158.0))
"""The region of interest around a finger."""


def wait(condition: Callable[[], bool]) -> None:
    """Let the window live until a condition holds."""
    application, deadline = make_application(), QDeadlineTimer(PATIENCE)
    while not condition():
        if deadline.hasExpired():
            raise TimeoutError("the window did not get there in a minute")
        application.processEvents(QEventLoop.ProcessEventsFlag.WaitForMoreEvents, 20)


def show(window: MainWindow, file: str) -> None:
    """Open a sample."""
    sample = find_sample_named(file)
    assert sample is not None
    treat_as_saved(window)  # nobody is there to be asked whether it is to be saved
    session, before = window.session, window.session.store.image_generation
    window.open_image(str(sample.path))
    wait(lambda: session.store.image_generation != before and session.idle and not session.status.busy)


def take(window: MainWindow, name: str) -> None:
    """Take a picture of the canvas, without what lies upon it."""
    canvas_area = window.canvas_area
    canvas_area.messages.hide()
    canvas_area.hint.hide()
    wait(lambda: window.session.idle)
    make_application().processEvents()
    keep(canvas_area.canvas.grab().toImage(), name)


def take_in_space(window: MainWindow, name: str) -> None:
    """Take a picture of the view in space."""
    view = window.get_feature(SpaceFeature).panel.view
    window.docks.reveal_panel("space")
    wait(lambda: window.session.idle)
    wait(lambda: view.is_idle)
    keep(view.grab().toImage(), name)


def keep(picture: QImage, name: str) -> None:
    """Write the middle of a picture."""
    side = min(picture.width(), picture.height())
    cut = picture.copy((picture.width() - side) // 2, (picture.height() - side) // 2, side, side)
    small = cut.scaledToWidth(WIDTH, Qt.TransformationMode.SmoothTransformation)
    small.save(str(HERE / f"{name}.jpg"), quality=88)


def run(window: MainWindow, until: int | None = None) -> None:
    """Let the particles go until a step, or until they rest."""
    session = window.session
    session.set_pace(60.0 if until else None)
    session.run()
    wait(lambda: session.status.phase == "finished" or (until is not None and session.status.step >= until))
    session.pause()
    wait(lambda: session.idle)


def main() -> None:
    """Do what the guide says, and take its pictures."""
    make_application()
    window = open_window()
    window.resize(1000, 640)
    session = window.session
    wait(lambda: session.idle and not session.status.busy)
    show(window, "artery.png")
    take(window, "artery_start")
    run(window, 60)
    take(window, "artery_midway")
    run(window)
    take(window, "artery_end")
    window.actions_by_name["mode_skeleton"].trigger()
    session.reset()
    session.toggle_run()
    wait(lambda: session.scene.skeleton is not None and session.idle)
    take(window, "artery_skeleton")
    show(window, "nuclei.png")
    take(window, "nuclei_start")
    run(window)
    selection = window.workspace.object_selection
    wait(lambda: selection.idle and bool(selection.proposals))
    take(window, "nuclei_end")
    show(window, "hand.png")
    take(window, "hand_start")
    run(window, 120)
    take(window, "hand_midway")
    run(window)
    take(window, "hand_end")
    session.edit("draw region", lambda document: edits.add_shape(document, PolygonRegion(FINGER)))
    session.edit("clear", lambda document: edits.delete_shape(document, 0))
    session.edit("everywhere", lambda document: edits.toggle_everywhere(document, "grid"))
    run(window)
    take(window, "hand_finger")
    show(window, "vessels.tif")
    take(window, "vessels_start")
    run(window, 40)
    take_in_space(window, "vessels_midway")
    run(window)
    take_in_space(window, "vessels_end")
    treat_as_saved(window)
    window.close()


if __name__ == "__main__":
    main()
