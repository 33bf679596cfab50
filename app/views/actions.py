"""The actions: one table of what there is, and the Qt actions made from it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from PySide6.QtGui import QAction, QActionGroup, QKeySequence
from PySide6.QtWidgets import QWidget

from app.model.resolve import ON_AN_IMAGE, Resolved
from app.views.icons import icon
from app.views.panels.layers_panel import LAYERS
from app.views.theme import Theme


@dataclass(frozen=True, slots=True)
class Entry:
    """One action.

    Attributes
    ----------
    name : str
        What it is called in code; also the name of its handler.
    menu : str
        Menu that it stands in.
    text : str
        Text in the menu.
    shortcuts : tuple of str
        Keys, the first of which is shown.
    tip : str
        One sentence for the tooltip and the status bar.
    icon : str
        Name of the icon, empty for none.
    group : str
        Actions of the same group are alternatives; ``"toggle"`` makes it checkable by itself, ``"state"`` checked as
        `Resolved` says.
    checked : bool
        Whether it is checked at first.
    gap : bool
        Whether a line is drawn above it.
    """

    name: str
    menu: str
    text: str
    shortcuts: tuple[str, ...] = ()
    tip: str = ""
    icon: str = ""
    group: str = ""
    checked: bool = False
    gap: bool = False


MENUS = ("File", "Edit", "Draw", "View", "Run", "Help")

ENTRIES = (
    Entry("open", "File", "&Open image…", ("Ctrl+O",), "Open an image.", "open"),
    Entry("export", "File", "&Export contours…", ("Ctrl+E",), "Write the contours to a file.", "export"),
    Entry("quit", "File", "&Quit", ("Ctrl+Q",), "End the program.", gap=True),
    Entry("undo", "Edit", "Undo", ("Ctrl+Z",), "Take back the last change.", "undo"),
    Entry("redo", "Edit", "Redo", ("Ctrl+Shift+Z", "Ctrl+Y"), "Do again what was undone.", "redo"),
    Entry("select_next", "Edit", "Select &next shape", ("N",), "Select one shape after the other.", gap=True),
    Entry(
        "escape", "Edit", "Gi&ve up", ("Escape",), "Give up what is being drawn, else select nothing and hide messages."
    ),
    Entry("delete", "Edit", "&Delete", ("Delete", "Backspace"), "Remove the selected shape.", gap=True),
    Entry("clear", "Edit", "Delete &all shapes", ("Ctrl+Shift+Backspace",), "Remove everything that is drawn."),
    Entry("select", "Draw", "&Select tool", ("S",), "Select, move and reshape what is drawn.", "select", "tool"),
    Entry("circle", "Draw", "&Circle tool", ("C",), "Drag from the centre to draw a circle.", "circle", "tool", True),
    Entry("points", "Draw", "&Point tool", ("P",), "Click to place a point.", "points", "tool"),
    Entry("stroke", "Draw", "S&troke tool", ("T",), "Drag, or click corners, where to start.", "stroke", "tool"),
    Entry(
        "region",
        "Draw",
        "Region of &interest tool",
        ("I",),
        "Drag, or click corners, around what particles are to stay in.",
        "region",
        "tool",
        gap=True,
    ),
    Entry(
        "barrier",
        "Draw",
        "&Barrier tool",
        ("B",),
        "Drag, or click corners, where no particle is to cross.",
        "barrier",
        "tool",
    ),
    Entry(
        "start_grid",
        "Draw",
        "Start everywhere (&grid)",
        ("Ctrl+G",),
        "Start evenly all over the image, or no longer.",
        "grid",
        "state",
        gap=True,
    ),
    Entry(
        "start_edges",
        "Draw",
        "Start on strong &edges",
        ("Ctrl+Shift+G",),
        "Start where the image changes most, or no longer.",
        "edges",
        "state",
    ),
    Entry(
        "start_centers",
        "Draw",
        "Start at ce&ntres",
        ("Ctrl+Shift+C",),
        "Start in the middle of what edges enclose, or no longer.",
        "centers",
        "state",
    ),
    Entry(
        "add_circle",
        "Draw",
        "Add circle in the &middle",
        ("Ctrl+K",),
        "Add a circle in the middle of what is seen.",
        gap=True,
    ),
    Entry("fit", "View", "&Fit to window", ("F", "Ctrl+0"), "Show the whole image.", "fit"),
    Entry("zoom_in", "View", "Zoom &in", ("+", "=", "Ctrl++"), "Enlarge."),
    Entry("zoom_out", "View", "Zoom &out", ("-", "Ctrl+-"), "Make smaller."),
    *(
        Entry(
            f"layer_{layer.name}",
            "View",
            layer.title,
            (layer.shortcut,),
            f"Show or hide the {layer.title.lower()}.",
            "",
            "toggle",
            layer.shown,
            index == 0,
        )
        for index, layer in enumerate(LAYERS)
    ),
    Entry(
        "panels",
        "View",
        "&Side column",
        ("F9",),
        "Show or hide the column beside the image.",
        "",
        "toggle",
        True,
        gap=True,
    ),
    Entry(
        "theme_system",
        "View",
        "Colours of the &desktop",
        (),
        "Light or dark as the desktop is.",
        "",
        "theme",
        True,
        gap=True,
    ),
    Entry("theme_light", "View", "&Light colours", (), "Light window.", "", "theme"),
    Entry("theme_dark", "View", "Dar&k colours", (), "Dark window.", "", "theme"),
    Entry("run", "Run", "Run", ("Space",), "Let the particles move, or hold them.", "run"),
    Entry("step", "Run", "&Step", (".",), "Take a single step.", "step"),
    Entry("reset", "Run", "&Reset", ("R",), "Forget the particles and go back to the drawing.", "reset"),
    Entry("faster", "Run", "&Faster", ("]",), "Allow more steps a second.", gap=True),
    Entry("slower", "Run", "S&lower", ("[",), "Allow fewer steps a second."),
    Entry("help", "Help", "&Short help", ("F1",), "What to do, and all keys."),
    Entry("about", "Help", "&About CPM", (), "What this is."),
)


class Actions:
    """The Qt actions of the table.

    Parameters
    ----------
    parent : QWidget
        Window in which their keys work.
    handlers : mapping of str to callable
        What each action does, by name; checkable ones are given whether they are checked.
    """

    def __init__(self, parent: QWidget, handlers: Mapping[str, Callable[..., object]]) -> None:
        self._theme: Theme | None = None
        self._run_icon = "run"
        self._groups: dict[str, QActionGroup] = {}
        self._actions = {entry.name: self._make(entry, parent, handlers[entry.name]) for entry in ENTRIES}

    def __getitem__(self, name: str) -> QAction:
        return self._actions[name]

    def show_resolved(self, resolved: Resolved) -> None:
        """Enable what makes sense and word it accordingly."""
        for name in _CONDITIONAL:
            self._actions[name].setEnabled(name in resolved.enabled)
        for name in _STATES:
            self._actions[name].setChecked(name in resolved.checked)
        for name, text in (("run", resolved.run_text), ("undo", resolved.undo_text), ("redo", resolved.redo_text)):
            if self._actions[name].text() != text:
                self._actions[name].setText(text)
                self._say(name, text)
        wanted = "pause" if resolved.running else "run"
        if wanted != self._run_icon:
            self._run_icon = wanted
            self._tint("run", wanted)

    def use_theme(self, theme: Theme) -> None:
        """Tint the icons."""
        self._theme = theme
        for entry in ENTRIES:
            if entry.icon:
                self._tint(entry.name, self._run_icon if entry.name == "run" else entry.icon)

    def _make(self, entry: Entry, parent: QWidget, handler: Callable[..., object]) -> QAction:
        action = QAction(entry.text, parent)
        action.setShortcuts([QKeySequence(keys) for keys in entry.shortcuts])
        if entry.group:
            action.setCheckable(True)
            action.setChecked(entry.checked)
        if entry.group and entry.group not in ("toggle", "state"):
            self._groups.setdefault(entry.group, QActionGroup(parent)).addAction(action)
        if entry.group == "toggle":
            action.toggled.connect(handler)
        else:
            action.triggered.connect(lambda checked=False: handler())
        action.setStatusTip(entry.tip)
        action.setToolTip(_tooltip(entry.text, entry))
        parent.addAction(action)
        return action

    def _say(self, name: str, text: str) -> None:
        entry = next(entry for entry in ENTRIES if entry.name == name)
        self._actions[name].setToolTip(_tooltip(text, entry))

    def _tint(self, name: str, drawing: str) -> None:
        if self._theme is not None:
            colour = self._theme.accent_text if name == "run" else self._theme.text
            self._actions[name].setIcon(icon(drawing, colour, faded=self._theme.line))


_CONDITIONAL = (
    "run",
    "step",
    "reset",
    "export",
    "undo",
    "redo",
    "delete",
    "clear",
    "select_next",
    *ON_AN_IMAGE,
)
_STATES = tuple(entry.name for entry in ENTRIES if entry.group == "state")


def _tooltip(text: str, entry: Entry) -> str:
    keys = f" ({entry.shortcuts[0]})" if entry.shortcuts else ""
    return f"{text.replace('&', '').rstrip('…')}{keys}: {entry.tip}"
