"""A layer of the canvas: it can be shown or hidden, has options, and draws what has changed in a scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar, Literal, Protocol

import pyqtgraph as pg
from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QGraphicsItem

from cpm_app.session.scene import Scene
from cpm_app.session.worker.commands import Command
from cpm_app.views.items.item import OverImage
from cpm_core.numerics.types import Extent, Texts, frozen

Value = str | float | bool


@frozen
class Choice:
    """One of several alternatives.

    Attributes
    ----------
    name, title, tip : str
        Name in a session file, name in the panel, and what it does in one sentence.
    ways : mapping
        Names and titles of the alternatives.
    first : str
        The default.
    """

    name: str
    title: str
    ways: Mapping[str, str]
    first: str
    tip: str

    def taken(self, value: object) -> Value | None:
        """The value to store, None when it is not one of the alternatives."""
        return value if isinstance(value, str) and value in self.ways else None


@frozen
class Amount:
    """A number between `low` and `high` in increments of `step`, by default `first`; the rest is as in `Choice`."""

    name: str
    title: str
    low: float
    high: float
    step: float
    first: float
    tip: str

    def taken(self, value: object) -> Value | None:
        """The value to store, None when it is not a number within the bounds."""
        return float(value) if isinstance(value, int | float) and self.low <= value <= self.high else None


@frozen
class Switch:
    """Something that is on or off, by default `first`; the rest is as in `Choice`."""

    name: str
    title: str
    first: bool
    tip: str

    def taken(self, value: object) -> Value | None:
        """The value to store, None when it is not a truth value."""
        return value if isinstance(value, bool) else None


Option = Choice | Amount | Switch


Sign = Literal["line", "dashed", "dot", "check", "area"]
"""How it is drawn: as a line, a dashed line, a disc, or not in a way of its own."""


@frozen
class LegendEntry:
    """One kind of thing on the canvas.

    Attributes
    ----------
    count : int
        How many there are.
    text : str
        What they are, after their number.
    tip : str
        What that means, in one sentence.
    color : str
        Their color.
    sign : {"line", "dashed", "dot", "check", "area"}
        How they are drawn.
    """

    count: int
    text: str
    tip: str
    color: str
    sign: Sign = "line"


class Requests(Protocol):
    """Requests of layers to the worker; the answers arrive as parts of a scene."""

    def post(self, command: Command) -> None:
        """Send a command to the worker."""

    def want_overlay(self, name: str, wanted: bool) -> None:
        """Switch the updates of an overlay on or off; see `cpm_app.session.worker.prepared_methods`."""


class NoRequests:
    """Ignores requests: the layers of another view have already made them."""

    def post(self, command: Command) -> None:
        """Do nothing."""

    def want_overlay(self, name: str, wanted: bool) -> None:
        """Do nothing."""


class Layer(QObject):
    """Base class of layers: subclasses set the class variables, add items in `make`, and draw in `follow`.

    Parameters
    ----------
    view : pg.ViewBox
        Parent of its items.
    requests : Requests
        Receives its requests to the worker.

    Attributes
    ----------
    scene : Scene
        The scene drawn last.
    """

    name: ClassVar[str]
    """Name in code and in a session file."""
    title: ClassVar[str]
    """Name in panel and menu."""
    tip: ClassVar[str] = ""
    """What it shows, in one sentence."""
    shortcut: ClassVar[str] = ""
    """Key that shows or hides the layer."""
    initially: ClassVar[bool] = True
    """Whether it is shown at first."""
    colors: ClassVar[Texts] = ()
    """Colors of its legend."""
    options: ClassVar[tuple[Option, ...]] = ()
    """Its options besides the opacity."""
    in_slices: ClassVar[bool] = False
    """Whether it shows anything in the slices of a volume."""

    changed = Signal()
    """Visibility, opacity or an option has changed."""

    def __init__(self, view: pg.ViewBox, requests: Requests) -> None:
        super().__init__()
        self.view = view
        self.requests = requests
        self.scene = Scene()
        self.shown = self.initially
        self.opacity = 1.0
        self.chosen: dict[str, Value] = {option.name: option.first for option in self.options}
        self._items: list[tuple[QGraphicsItem, str]] = []
        self.make()

    def make(self) -> None:
        """Make its items."""

    def add(self, *items: QGraphicsItem, switch: str = "") -> None:
        """Put items on the canvas, unless they have their place there; they are shown while a `Switch` is on."""
        for item in items:
            self._items.append((item, switch))
            if item.parentItem() is None:
                self.view.addItem(item, ignoreBounds=True)

    def draw(self, scene: Scene) -> None:
        """Draw what has changed since the last scene."""
        before, self.scene = self.scene, scene
        if scene.image is not None and (before.image is None or scene.image.shape != before.image.shape):
            self.use_shape(scene.image.shape)
        self.follow(before)

    def use_shape(self, shape: Extent) -> None:
        """Cover an image of this shape."""
        for item, _ in self._items:
            if isinstance(item, OverImage):
                item.use_shape(shape)

    def follow(self, before: Scene) -> None:
        """Draw the parts of `scene` that differ from the scene before."""

    def legend_entries(self) -> Sequence[LegendEntry]:
        """What the legend says of it while it is shown."""
        return ()

    def set_shown(self, shown: bool) -> None:
        """Show or hide the layer."""
        if shown != self.shown:
            self.shown = shown
            self.show_or_hide()
            self.changed.emit()

    def set_opacity(self, opacity: float) -> None:
        """Set the opacity, from 0 to 1."""
        if opacity != self.opacity:
            self.opacity = opacity
            self.fade()
            self.changed.emit()

    def show_or_hide(self) -> None:
        """Apply `shown` and the switches to the items."""
        for item, switch in self._items:
            item.setVisible(self.shown and bool(not switch or self.chosen[switch]))

    def fade(self) -> None:
        """Apply `opacity` to the items."""
        for item, _ in self._items:
            item.setOpacity(self.opacity)

    def choose(self, name: str, value: object) -> None:
        """Set an option; an invalid value changes nothing."""
        option = next(option for option in self.options if option.name == name)
        taken = option.taken(value)
        if taken is not None and taken != self.chosen[name]:
            self.chosen[name] = taken
            self.follow_choice(name)
            self.changed.emit()

    def acts(self, name: str) -> bool:
        """Whether an option has an effect together with the other ones."""
        return True

    def follow_choice(self, name: str) -> None:
        """Apply an option that has changed, by default one that shows or hides items."""
        self.show_or_hide()

    def word(self, name: str) -> str:
        """Value of a `Choice`."""
        return str(self.chosen[name])

    def number(self, name: str) -> float:
        """Value of an `Amount`."""
        return float(self.chosen[name])

    def view_state(self) -> dict[str, object]:
        """Its state for a session file."""
        return {"shown": self.shown, "opacity": self.opacity, **self.chosen}

    def use_view_state(self, state: dict[str, object]) -> None:
        """Restore the state from a session file; missing or invalid entries change nothing."""
        shown, opacity = state.get("shown"), state.get("opacity")
        if isinstance(shown, bool):
            self.set_shown(shown)
        if isinstance(opacity, int | float) and 0.0 <= opacity <= 1.0:
            self.set_opacity(float(opacity))
        for option in self.options:
            if option.name in state:
                self.choose(option.name, state[option.name])
