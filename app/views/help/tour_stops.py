"""The stops of the tour."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtWidgets import QLineEdit, QMainWindow, QToolButton, QWidget

from app.model.text.language import tr
from app.session.session import Session
from app.views.export.dialog import ExportDialog
from app.views.help.tour import Stop


def stops(window: QMainWindow, session: Session, reveal: Callable[[str], None]) -> tuple[Stop, ...]:
    """The five stops in a window; `reveal` brings a panel to the front by its name."""
    doings = _Doings(window, session, reveal)
    return (
        Stop(
            tr("Open an image"),
            tr("Open your own image, or drop a file on the window. Or continue with the image that is open."),
            doings.button("open"),
            doings.another_image,
        ),
        Stop(
            tr("Select an object"),
            tr("Choose the tool Objects ({key:objects}) and click in an object. Click to add, Shift-click to remove. "
               "Enter accepts it and asks for its name; Enter again leaves it without one."),
            doings.button("objects"),
            doings.more_objects,
        ),
        Stop(
            tr("Or draw and run"),
            tr("Drag a circle ({key:circle}) in or around an object, unless there is one, and press {key:run}. "
               "Particles find the edges and follow them until they come to rest."),
            doings.button("primary"),
            lambda: doings.has_run,
            doings.run,
        ),
        Stop(
            tr("Steer"),
            tr("Move a slider: it acts at the next step of the run. The text below the sliders explains it."),
            lambda: window.findChild(QWidget, "parameters"),
            doings.other_parameters,
        ),
        Stop(
            tr("Export"),
            tr("When the run has found contours, export them as vector graphics, table or mask. "
               "The guide ({key:guide}) explains four examples."),
            doings.button("export"),
            lambda: doings.is_exporting,
        ),
    )  # fmt: skip


class _Doings:
    """What the stops point at, and what a person does there."""

    def __init__(self, window: QMainWindow, session: Session, reveal: Callable[[str], None]) -> None:
        self._window = window
        self._session = session
        self._reveal = reveal

    def button(self, name: str) -> Callable[[], QWidget | None]:
        """A button of the tool bar or of the palette."""

        def seen() -> QWidget | None:
            found = self._window.findChild(QToolButton, name)
            # In a narrow window the last buttons are hidden; their actions are also in the menus.
            return found if found is not None and found.isVisible() else self._window.menuBar()

        return seen

    def another_image(self) -> Callable[[], bool]:
        """Whether an image is opened from now on."""
        # The first image, which the program itself opens, does not count.
        opened = [] if self._session.document.image is None else [self._session.image_generation]

        def is_opened() -> bool:
            if not opened and self._session.document.image is not None:
                opened.append(self._session.image_generation)
            return bool(opened) and self._session.image_generation != opened[0]

        return is_opened

    def more_objects(self) -> Callable[[], bool]:
        """Whether an object is accepted, and named or not, from now on."""
        before = len(self._session.document.objects.items)
        return lambda: len(self._session.document.objects.items) > before and not self._typing()

    def other_parameters(self) -> Callable[[], bool]:
        """Whether a parameter is changed from now on."""
        self._reveal("parameters")
        before = self._session.document.parameters
        return lambda: self._session.document.parameters != before

    def _typing(self) -> bool:
        return isinstance(self._window.focusWidget(), QLineEdit)

    def run(self) -> None:
        """Run, where there is something to start from."""
        if self._session.document.starts and not self.has_run():
            self._session.run()

    def has_run(self) -> bool:
        """Whether there is a run."""
        return self._session.status.started

    def is_exporting(self) -> bool:
        """Whether the export dialog is open."""
        return self._window.findChild(ExportDialog) is not None
