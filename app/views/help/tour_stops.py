"""What the tour shows, in the order in which one works: open, draw, run, steer, export."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtWidgets import QMainWindow, QToolBar, QToolButton, QWidget

from app.model.text.language import tr
from app.views.help.tour import Stop


def stops(window: QMainWindow, reveal: Callable[[str], None]) -> tuple[Stop, ...]:
    """The five stops in a window.

    Parameters
    ----------
    window : QMainWindow
        Where they are.
    reveal : callable
        Opens a panel by its name and brings it to the front.
    """

    def button(name: str) -> Callable[[], QWidget | None]:
        def seen() -> QWidget | None:
            found = window.findChild(QToolButton, name)
            # In a narrow window the last buttons have no room; what they do stands in the menus, too.
            return found if found is not None and found.isVisible() else window.menuBar()

        return seen

    def parameters() -> QWidget | None:
        reveal("parameters")
        return window.findChild(QWidget, "parameters")

    return (
        Stop(
            tr("Open an image"),
            tr("Open one of your own, or drop a file on the window. A sample is open already, ready to be tried."),
            button("open"),
        ),
        Stop(
            tr("Draw where to start"),
            tr("Drag a circle in or around an object. Strokes and points do as well; “Automatic” above needs none."),
            lambda: window.findChild(QToolBar, "palette"),
        ),
        Stop(
            tr("Run"),
            tr("Press Space. Particles flow to the edges and push each other along them, until they rest."),
            button("primary"),
        ),
        Stop(
            tr("Steer"),
            tr("Each slider acts at the very next step, while it runs. The drawing below shows what it does."),
            parameters,
        ),
        Stop(
            tr("Export"),
            tr("Write the contours as drawing, table or mask. The guide (F1) leads through three real tasks."),
            button("export"),
        ),
    )
