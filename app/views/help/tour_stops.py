"""The stops of the tour."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtWidgets import QMainWindow, QToolBar, QToolButton, QWidget

from app.model.text.language import tr
from app.session.session import Session
from app.views.export.dialog import ExportDialog
from app.views.help.tour import Stop


def stops(window: QMainWindow, session: Session, reveal: Callable[[str], None]) -> tuple[Stop, ...]:
    """The five stops in a window; `reveal` brings a panel to the front by its name."""

    def button(name: str) -> Callable[[], QWidget | None]:
        def seen() -> QWidget | None:
            found = window.findChild(QToolButton, name)
            # In a narrow window the last buttons are hidden; their actions are also in the menus.
            return found if found is not None and found.isVisible() else window.menuBar()

        return seen

    def another_image() -> Callable[[], bool]:
        before = session.image_generation
        return lambda: session.image_generation != before

    def more_shapes() -> Callable[[], bool]:
        before = session.document.shapes
        return lambda: len(session.document.shapes) > len(before)

    def other_parameters() -> Callable[[], bool]:
        reveal("parameters")
        before = session.document.parameters
        return lambda: session.document.parameters != before

    def run() -> None:
        if session.document.starts and not has_run():
            session.run()

    def has_run() -> bool:
        return session.status.started

    return (
        Stop(
            tr("Open an image"),
            tr("Open your own image, or drop a file on the window. Or go on with the sample, which is open already."),
            button("open"),
            another_image,
        ),
        Stop(
            tr("Draw where to start"),
            tr("Drag a circle in or around an object. The other tools beside the image draw strokes, points and more."),
            lambda: window.findChild(QToolBar, "palette"),
            more_shapes,
        ),
        Stop(
            tr("Run"),
            tr("Press Space. Particles move to the edges and repel each other along them until they come to rest."),
            button("primary"),
            lambda: has_run,
            run,
        ),
        Stop(
            tr("Steer"),
            tr("Move a slider: it acts at the next step of the run. The text below the sliders explains it."),
            lambda: window.findChild(QWidget, "parameters"),
            other_parameters,
        ),
        Stop(
            tr("Export"),
            tr("When the run has found contours, export them as vector graphics, table or mask. "
               "The guide (F1) explains three examples."),
            button("export"),
            lambda: lambda: window.findChild(ExportDialog) is not None,
        ),
    )  # fmt: skip
