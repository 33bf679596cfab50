"""A feature of the window: related actions and panels.

A new one is a module in `app.views.features` and an entry in its list.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, Literal, TypeVar

from PySide6.QtWidgets import QDialog, QMainWindow, QWidget

from app.session.features.workspace import Workspace
from app.session.session import Session
from app.session.storage.preferences import Preferences
from app.session.storage.session_file import DocumentFile
from app.views.canvas.canvas_area import CanvasArea
from app.views.theme.theme import Theme
from app.views.widgets.actions import ActionSpec, Submenu
from app.views.widgets.turns import Turns
from app.views.window.dialogs import FileDialogs
from app.views.window.keyboard import Areas
from app.views.window.shortcuts import Shortcuts
from cpm_core.formats import Reading

Area = Literal["left", "right", "bottom"]


@dataclass(frozen=True, eq=False, slots=True)
class FeatureContext:
    """What every feature works with.

    Attributes
    ----------
    window : QMainWindow
        The window, as the parent of dialogs.
    workspace : Workspace
        The session with its features.
    canvas_area : CanvasArea
        Canvas, layers and tools.
    preferences : Preferences
        Settings that are stored between sessions.
    document_file : DocumentFile
        The session file of what is open.
    action_specs : callable
        Returns all actions, once the window is built.
    shortcuts : callable
        Returns the keys of all actions, once the window is built.
    reveal : callable
        Opens a panel by name and brings it to the front.
    areas : callable
        Returns what gives the keyboard to panels, once the window is built.
    use_theme : callable
        Sets the theme of the window.
    refresh : callable
        Updates the window after a change that the session does not report.
    open_file : callable
        Opens a file, or with True as second argument an image with the session next to it; asks about unsaved work.
    open_part : callable
        Opens a part of a file, with True a volume, with False an image; asks about unsaved work.
    do : callable
        Triggers an action by its name, once the window is built.
    open_menu : callable
        Opens the menu of what is chosen where the keyboard is.
    turns : Turns
        Does what takes long in pieces.
    """

    window: QMainWindow
    workspace: Workspace
    canvas_area: CanvasArea
    preferences: Preferences
    document_file: DocumentFile
    action_specs: Callable[[], Iterable[ActionSpec]]
    shortcuts: Callable[[], Shortcuts]
    reveal: Callable[[str], None]
    areas: Callable[[], Areas]
    use_theme: Callable[[Theme], None]
    refresh: Callable[[], None]
    open_file: Callable[[Path, bool], None]
    open_part: Callable[[Path, bool, Reading], None]
    do: Callable[[str], None]
    open_menu: Callable[[], None]
    turns: Turns

    @property
    def session(self) -> Session:
        """Document, history and run."""
        return self.workspace.session

    @property
    def files(self) -> FileDialogs:
        """The dialogs that ask for files."""
        return FileDialogs(self.window, self.session, self.preferences)


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Panel:
    """A panel next to the canvas; it can be moved, closed, and opened again from the menu View.

    Attributes
    ----------
    name : str
        Name in code and in the stored layout.
    title : str
        Heading.
    widget : QWidget
        Content.
    area : {"left", "right", "bottom"}
        Initial area.
    tab : str
        Panels of one area with the same value are tabbed; empty for a panel without tab.
    shown : bool
        Whether it is initially open.
    height : int
        Initial height, as far as there is room; those of an area keep their proportions [px].
    shortcut : str
        Key that opens or closes it.
    """

    name: str
    title: str
    widget: QWidget
    area: Area = "right"
    tab: str = ""
    shown: bool = True
    height: int = 400
    shortcut: str = ""


class Feature:
    """Base class of features."""

    def __init__(self, context: FeatureContext) -> None:
        self.context = context

    def action_specs(self) -> Sequence[ActionSpec | Submenu]:
        """Its actions, in the order of the menus."""
        return ()

    def panels(self) -> Sequence[Panel]:
        """Its panels."""
        return ()

    def use_theme(self, theme: Theme) -> None:
        """Apply the colors of a theme that the palette does not set."""

    def use_keys(self) -> None:
        """Show the keys of actions, at first and when the user has changed them."""

    def close(self) -> bool:
        """End its work before the window closes; False keeps the window open."""
        return True


D = TypeVar("D", bound=QDialog)


class OneDialog(Generic[D]):
    """A dialog that may stay open next to the window; `make` returns none where there is nothing to open it on."""

    def __init__(self, make: Callable[[], D | None]) -> None:
        self._make = make
        self.shown: D | None = None

    def open(self) -> D | None:
        """Open the dialog, or bring it to the front."""
        if self.shown is None:
            self.shown = self._make()
            if self.shown is None:
                return None
            self.shown.finished.connect(self._forget)
        self.shown.show()
        self.shown.raise_()
        self.shown.activateWindow()
        return self.shown

    def close(self) -> bool:
        """Close the dialog, which ends what it runs itself."""
        if self.shown is not None:
            self.shown.close()
        return True

    def _forget(self, _: int) -> None:
        self.shown = None
