"""A layer of the canvas, with visibility, opacity and options; it draws the changed parts of a scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import ClassVar, Literal

import pyqtgraph as pg
from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QGraphicsItem

from cpm_app.session.scene import Scene
from cpm_app.session.session import Session
from cpm_app.views.items.item import ImageOverlay
from cpm_core.numerics.types import Extent, Texts, frozen

Value = str | float | bool
"""Value of an option."""


@frozen
class Option:
    """An option of a layer: on or off, one of several alternatives, or a number.

    Attributes
    ----------
    name, title, tip : str
        Name in a session file, name in the panel, and a sentence on its effect.
    default : str, float or bool
        The default; a bool for an option that is on or off.
    choices : mapping
        Names and titles of the alternatives, if there are any.
    bounds : tuple of float
        Smallest and largest number, and increment, of an option that is a number.
    """

    name: str
    title: str
    default: Value
    tip: str
    choices: Mapping[str, str] = field(default_factory=dict)
    bounds: tuple[float, float, float] = (0.0, 1.0, 0.05)

    def validate_value(self, value: object) -> Value | None:
        """Return the value to store, None if it is of another kind or out of bounds."""
        if isinstance(self.default, bool):
            return value if isinstance(value, bool) else None
        if self.choices:
            return value if isinstance(value, str) and value in self.choices else None
        low, high, _ = self.bounds
        return float(value) if isinstance(value, int | float) and low <= value <= high else None


Sign = Literal["line", "dashed", "dot", "area"]
"""Way of drawing an item, for the legend: line, dashed line, disc or area."""


@frozen
class LegendEntry:
    """A kind of item on the canvas.

    Attributes
    ----------
    count : int
        Number of items.
    text : str
        What is counted, before the number.
    tip : str
        Sentence on their meaning.
    color : str
        Color of the items.
    sign : {"line", "dashed", "dot", "area"}
        Way of drawing.
    """

    count: int
    text: str
    tip: str
    color: str
    sign: Sign = "line"


class Layer(QObject):
    """Base class of layers: subclasses set the class variables, add items in `create_items`, and draw in `show_scene`.

    Parameters
    ----------
    view : pg.ViewBox
        Parent of the items.
    session : Session, optional
        Whose worker is asked for data; None for a view next to another one whose layers have already done so.

    Attributes
    ----------
    scene : Scene
        Scene drawn last.
    """

    name: ClassVar[str]
    """Name in code and in a session file."""
    title: ClassVar[str]
    """Name in panel and menu."""
    tip: ClassVar[str] = ""
    """Sentence on what it shows."""
    shortcut: ClassVar[str] = ""
    """Key that shows or hides the layer."""
    initially_shown: ClassVar[bool] = True
    """Whether it is shown at first."""
    colors: ClassVar[Texts] = ()
    """Colors of its legend."""
    options: ClassVar[tuple[Option, ...]] = ()
    """Options besides the opacity."""

    changed = Signal()
    """Visibility, opacity or an option has changed."""

    def __init__(self, view: pg.ViewBox, session: Session | None) -> None:
        super().__init__()
        self.view = view
        self.session = session
        self.scene = Scene()
        self.shown = self.initially_shown
        self.opacity = 1.0
        self.option_values: dict[str, Value] = {option.name: option.default for option in self.options}
        self._items: list[tuple[QGraphicsItem, str]] = []
        self.create_items()

    def create_items(self) -> None:
        """Create the items of the layer."""

    def add_items(self, *items: QGraphicsItem, switch: str = "") -> None:
        """Put items without a parent on the canvas; with `switch`, show them only while that option is on."""
        for item in items:
            self._items.append((item, switch))
            if item.parentItem() is None:
                self.view.addItem(item, ignoreBounds=True)

    def set_scene(self, scene: Scene) -> None:
        """Set the scene, and draw the parts that have changed."""
        before, self.scene = self.scene, scene
        if scene.image is not None and (before.image is None or scene.image.shape != before.image.shape):
            self.set_image_shape(scene.image.shape)
        self.show_scene(before)

    def set_image_shape(self, shape: Extent) -> None:
        """Fit the items to an image of this shape."""
        for item, _ in self._items:
            if isinstance(item, ImageOverlay):
                item.set_image_shape(shape)

    def show_scene(self, before: Scene) -> None:
        """Draw the parts of `scene` that differ from the previous scene, `before`."""

    def legend_entries(self) -> Sequence[LegendEntry]:
        """Return the entries of the legend while the layer is shown."""
        return ()

    def set_shown(self, shown: bool) -> None:
        """Show or hide the layer."""
        if shown != self.shown:
            self.shown = shown
            self.apply_visibility()
            self.changed.emit()

    def set_opacity(self, opacity: float) -> None:
        """Set the opacity, from 0 to 1."""
        if opacity != self.opacity:
            self.opacity = opacity
            self.apply_opacity()
            self.changed.emit()

    def apply_visibility(self) -> None:
        """Apply `shown` and the switches to the items."""
        for item, switch in self._items:
            item.setVisible(self.shown and bool(not switch or self.option_values[switch]))

    def apply_opacity(self) -> None:
        """Apply `opacity` to the items."""
        for item, _ in self._items:
            item.setOpacity(self.opacity)

    def set_option(self, name: str, value: object) -> None:
        """Set an option; an invalid value changes nothing."""
        option = next(option for option in self.options if option.name == name)
        taken = option.validate_value(value)
        if taken is not None and taken != self.option_values[name]:
            self.option_values[name] = taken
            self.apply_option(name)
            self.changed.emit()

    def has_effect(self, name: str) -> bool:
        """Tell whether an option has an effect, given the other options."""
        return True

    def apply_option(self, name: str) -> None:
        """Apply an option that has changed; by default, show or hide items."""
        self.apply_visibility()

    def get_choice(self, name: str) -> str:
        """Return the value of an option with alternatives."""
        return str(self.option_values[name])

    def get_amount(self, name: str) -> float:
        """Return the value of an option that is a number."""
        return float(self.option_values[name])

    def view_state(self) -> dict[str, object]:
        """Return the state for a session file."""
        return {"shown": self.shown, "opacity": self.opacity, **self.option_values}

    def use_view_state(self, state: dict[str, object]) -> None:
        """Restore the state from a session file; missing or invalid entries change nothing."""
        shown, opacity = state.get("shown"), state.get("opacity")
        if isinstance(shown, bool):
            self.set_shown(shown)
        if isinstance(opacity, int | float) and 0.0 <= opacity <= 1.0:
            self.set_opacity(float(opacity))
        for option in self.options:
            if option.name in state:
                self.set_option(option.name, state[option.name])
