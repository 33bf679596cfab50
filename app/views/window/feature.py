"""A feature of the window: what belongs together of its actions, panels and what they do.

A new one is a module in `app.views.features` and a line in its list.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

from PySide6.QtWidgets import QMainWindow, QWidget

from app.session.session import Session
from app.session.storage.preferences import Preferences
from app.session.workspace import Workspace
from app.views.canvas.canvas_area import CanvasArea
from app.views.theme.theme import Theme
from app.views.widgets.action_spec import ActionSpec, Submenu
from app.views.widgets.preference_row import PreferenceRow

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
        What is kept from one start to the next.
    action_specs : callable
        All actions there are, once the window is built.
    preference_rows : callable
        All that may be preferred, once the window is built.
    reveal : callable
        Opens a panel by its name and brings it to the front.
    use_theme : callable
        Gives the window another theme.
    refresh : callable
        Shows the situation anew, where something has changed that the session does not know.
    """

    window: QMainWindow
    workspace: Workspace
    canvas_area: CanvasArea
    preferences: Preferences
    action_specs: Callable[[], Iterable[ActionSpec]]
    preference_rows: Callable[[], Iterable[PreferenceRow]]
    reveal: Callable[[str], None]
    use_theme: Callable[[Theme], None]
    refresh: Callable[[], None]

    @property
    def session(self) -> Session:
        """Document, history and run."""
        return self.workspace.session


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Panel:
    """A panel beside the canvas, which can be moved, closed and brought back by the menu View.

    Attributes
    ----------
    name : str
        What it is called in code; its place is remembered by it.
    title : str
        Its heading.
    widget : QWidget
        What it shows.
    area : {"left", "right", "bottom"}
        Where it is at first.
    tab : str
        Panels of one area with the same tab lie upon each other; empty for a place of its own.
    shown : bool
        Whether it is open at first.
    shortcut : str
        Key that opens or closes it.
    """

    name: str
    title: str
    widget: QWidget
    area: Area = "right"
    tab: str = ""
    shown: bool = True
    shortcut: str = ""


class Feature:
    """What features have in common.

    Parameters
    ----------
    context : FeatureContext
        What it works with.
    """

    def __init__(self, context: FeatureContext) -> None:
        self.context = context

    def action_specs(self) -> Sequence[ActionSpec | Submenu]:
        """Its actions, in the order in which they stand in the menus."""
        return ()

    def panels(self) -> Sequence[Panel]:
        """Its panels."""
        return ()

    def preferences(self) -> Sequence[PreferenceRow]:
        """What a person may prefer about it, for the dialog of the preferences."""
        return ()

    def use_theme(self, theme: Theme) -> None:
        """Take on the colors of a theme, as far as the palette does not do so by itself."""

    def close(self) -> bool:
        """The window is about to close: end what is going on; False keeps it open."""
        return True
