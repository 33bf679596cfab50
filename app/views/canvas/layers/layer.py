"""A layer of the canvas: something that is seen or not, and draws of a scene what has changed."""

from __future__ import annotations

from typing import ClassVar, Protocol

import pyqtgraph as pg
from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QGraphicsItem

from app.session.scene import Scene
from app.session.worker.commands.run import Command
from app.views.canvas.items.item import OverImage
from app.views.canvas.layers.options import Option, Value


class Requests(Protocol):
    """What layers ask of the worker; the answers come as parts of a scene."""

    def post(self, command: Command) -> None:
        """Send a command to the worker."""

    def want_overlay(self, name: str, wanted: bool) -> None:
        """Say whether an overlay is to be kept up to date; see `app.session.worker.overlays`."""


class Layer(QObject):
    """What layers have in common.

    Subclasses set the class variables, add their items with `add`, and draw in `follow`.

    Parameters
    ----------
    view : pg.ViewBox
        Where its items lie.
    requests : Requests
        Where it asks for what the worker makes.

    Attributes
    ----------
    scene : Scene
        What has been drawn last.
    """

    name: ClassVar[str]
    """What it is called in code, and in a session file."""
    title: ClassVar[str]
    """What it is called in panel and menu."""
    tip: ClassVar[str] = ""
    """What it shows, in a sentence."""
    shortcut: ClassVar[str] = ""
    """Key that shows or hides it."""
    initially: ClassVar[bool] = True
    """Whether it is shown at first."""
    colors: ClassVar[tuple[str, ...]] = ()
    """Legend."""
    options: ClassVar[tuple[Option, ...]] = ()
    """What can be chosen about it, besides its opacity."""

    changed = Signal()
    """It is shown, hidden, of another opacity, or something else has been chosen now."""

    def __init__(self, view: pg.ViewBox, requests: Requests) -> None:
        super().__init__()
        self.view = view
        self.requests = requests
        self.scene = Scene()
        self.shown = self.initially
        self.opacity = 1.0
        self.chosen: dict[str, Value] = {option.name: option.first for option in self.options}
        self._items: list[QGraphicsItem] = []

    def add(self, *items: QGraphicsItem) -> None:
        """Put items on the canvas."""
        for item in items:
            self._items.append(item)
            self.view.addItem(item, ignoreBounds=True)

    def pin(self, *items: QGraphicsItem) -> None:
        """Put items on the canvas that do not move with the image; their places are in px of the screen."""
        for item in items:
            self._items.append(item)
            item.setParentItem(self.view)

    def draw(self, scene: Scene) -> None:
        """Draw what of a scene is not what has been drawn last."""
        before, self.scene = self.scene, scene
        if scene.image is not None and scene.image is not before.image:
            self.use_shape(scene.image.shape)
        self.follow(before)

    def use_shape(self, shape: tuple[int, ...]) -> None:
        """Make room for an image of this shape."""
        for item in self._items:
            if isinstance(item, OverImage):
                item.use_shape(shape)

    def follow(self, before: Scene) -> None:
        """Draw those parts of `scene` that are others than in the one before."""

    def set_shown(self, shown: bool) -> None:
        """Show or hide it."""
        if shown != self.shown:
            self.shown = shown
            self.show_or_hide()
            self.changed.emit()

    def set_opacity(self, opacity: float) -> None:
        """Let what lies below shine through, from 0 to 1."""
        if opacity != self.opacity:
            self.opacity = opacity
            self.fade()
            self.changed.emit()

    def show_or_hide(self) -> None:
        """Do to the items what `shown` says."""
        for item in self._items:
            item.setVisible(self.shown)

    def fade(self) -> None:
        """Do to the items what `opacity` says."""
        for item in self._items:
            item.setOpacity(self.opacity)

    def choose(self, name: str, value: object) -> None:
        """Choose something about it; a value that makes no sense changes nothing."""
        option = next(option for option in self.options if option.name == name)
        taken = option.taken(value)
        if taken is not None and taken != self.chosen[name]:
            self.chosen[name] = taken
            self.follow_choice(name)
            self.changed.emit()

    def follow_choice(self, name: str) -> None:
        """Do to the items what has been chosen."""

    def word(self, name: str) -> str:
        """Which way has been chosen."""
        return str(self.chosen[name])

    def number(self, name: str) -> float:
        """Which number has been chosen."""
        return float(self.chosen[name])

    @property
    def settable(self) -> bool:
        """Whether there is something to be chosen about it."""
        return bool(self.options)

    def view_state(self) -> dict[str, object]:
        """What a session file keeps of it."""
        return {"shown": self.shown, "opacity": self.opacity, **self.chosen}

    def use_view_state(self, state: dict[str, object]) -> None:
        """Look as a session file says; what it does not say, or says wrongly, stays as it is."""
        shown, opacity = state.get("shown"), state.get("opacity")
        if isinstance(shown, bool):
            self.set_shown(shown)
        if isinstance(opacity, int | float) and 0.0 <= opacity <= 1.0:
            self.set_opacity(float(opacity))
        for option in self.options:
            if option.name in state:
                self.choose(option.name, state[option.name])
