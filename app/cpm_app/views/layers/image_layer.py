"""The layer of the image itself, or of all channels together, and the drag that changes its window of gray values."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from PySide6.QtCore import QEvent, QObject, QPointF, Qt, Signal
from PySide6.QtGui import QCursor, QMouseEvent
from PySide6.QtWidgets import QWidget

from cpm_app.model.display.display_image import (
    DisplayImage,
    IntensityWindow,
    compute_color_curve,
    percentile_window,
)
from cpm_app.model.text.language import localize_number, tr
from cpm_app.session.features.background import IdentityCache
from cpm_app.session.scene import Scene
from cpm_app.session.worker.requests import shade_image
from cpm_app.views.items.item import enable_caching
from cpm_app.views.items.tiled_image import TiledImage
from cpm_app.views.layers.layer import Layer, Option
from cpm_app.views.theme import color_maps
from cpm_core import Image
from cpm_core.formats.common.json_values import from_json, to_json
from cpm_core.numerics.types import Pixels, frozen

WHOLE_RANGE = "0"
"""Range of all gray values."""

AUTOMATIC_RANGE = "0.1"
"""Range without the most extreme gray values [% at either end]."""

FILE_RANGE = "file"
"""Range that the file states."""

MANUAL_RANGE = "hand"
"""Range set by hand."""

RANGE_TITLES: Mapping[str, str] = MappingProxyType(
    {
        FILE_RANGE: tr("As the file states"),
        WHOLE_RANGE: tr("All gray values"),
        AUTOMATIC_RANGE: tr("All except 0.1 % at either end"),
        "1": tr("All except 1 % at either end"),
        "5": tr("All except 5 % at either end"),
        MANUAL_RANGE: tr("By hand"),
    }
)
"""Titles of the ranges."""

_MAX_CHANNELS_AT_FIRST = 7
"""Number of channels that a composite shows at first, as many as there are usual colors."""

WidthAndLevel = tuple[float, float]
"""Width and middle of a window of gray values."""

CT_WINDOWS: Mapping[str, tuple[str, WidthAndLevel]] = MappingProxyType(
    {
        "soft_tissue": (tr("Soft tissue"), (400.0, 50.0)),
        "mediastinum": (tr("Mediastinum"), (350.0, 50.0)),
        "lung": (tr("Lung"), (1500.0, -600.0)),
        "bone": (tr("Bone"), (1800.0, 400.0)),
        "brain": (tr("Brain"), (80.0, 40.0)),
        "liver": (tr("Liver"), (150.0, 30.0)),
    }
)
"""Titles, widths and levels of the usual windows of CT, in Hounsfield units: radiopaedia.org, "Windowing (CT)"."""

_SHOW_COLORS = "colors"
"""Value of the option that shows an image in color."""

_SHOW_CHANNEL = "channel"
"""Value of the option that shows the channel of the run."""

_BRIGHT_COLOR = "#ffffff"
"""Color of a channel with a bright background."""

_MAX_IMMEDIATE_PIXELS = 1 << 22
"""Largest number of pixels shaded immediately, which takes two frames; the worker shades larger images."""


@frozen
class ChannelLook:
    """How a composite shows a channel; it has a range of its own once one has been chosen.

    `automatic` is whether nobody has chosen if it is shown, and in which color.
    """

    shown: bool
    color: str
    range: str = ""
    window: tuple[float, float] | None = None
    automatic: bool = False


class ImageLayer(Layer):
    """The image in a window of gray values, set by percentiles or by hand; of several channels, all together."""

    name = "image"
    title = tr("Image")
    tip = tr("The image itself.")
    shortcut = "Alt+0"
    options = (
        Option(
            "content",
            tr("Shown"),
            _SHOW_COLORS,
            tr("All channels, each in its color, or the channel in which a run finds edges."),
            {_SHOW_COLORS: tr("In color"), _SHOW_CHANNEL: tr("Channel of the run")},
        ),
        Option("map", tr("Colors"), color_maps.GRAY_MAP, tr("Colors from dark to bright."), color_maps.COLOR_MAPS),
        Option(
            "range",
            tr("Range"),
            WHOLE_RANGE,
            tr(
                "Range of gray values; values below are black, values above are white. Hot pixels and padding far from "
                "all others do not count."
            ),
            RANGE_TITLES,
        ),
        Option(
            "gamma",
            tr("Gamma"),
            1.0,
            tr("Smaller values bring out dark areas, larger ones bright areas."),
            bounds=(0.2, 3.0, 0.05),
        ),
    )

    def create_items(self) -> None:
        """Create the items of the layer."""
        self._item = TiledImage(0.0)
        enable_caching(self._item)
        self.add_items(self._item)
        self.gray_range = self.window = (0.0, 1.0)
        """Gray values shown as black and white at first, `Image.shown_range`; the same now."""
        self.window_bounds = self.gray_range
        """Bounds of a window set by hand: the gray range, extended by that of the file and the usual ones of CT."""
        self.looks: list[ChannelLook] = []
        """How a composite shows each channel of the file; none without channels."""
        self._parts = IdentityCache()

    @property
    def shades(self) -> Pixels | None:
        """Shades shown, before the color map is applied."""
        return self._item.display.shades if self._item.display is not None else None

    @property
    def shown_window(self) -> IntensityWindow:
        """Window with gamma, as shown."""
        return IntensityWindow(*self.window, self.get_amount("gamma"))

    def set_window(self, low: float, high: float) -> None:
        """Show gray values from `low`, black, to `high`, white."""
        if math.isfinite(low) and math.isfinite(high) and low <= high and (low, high) != self.window:
            self.option_values["range"] = MANUAL_RANGE
            self._apply_window(low, high)

    def apply_option(self, name: str) -> None:
        """Change colors or window."""
        if name == "map":
            self._apply_colors()
        elif name == "range":
            self._apply_range()
        else:  # what is shown, or gamma
            self._update_shades()

    def has_effect(self, name: str) -> bool:
        """Tell whether an option has an effect: a single channel has no colors, colors have no color map."""
        colored = bool(self.looks) or (self.scene.image is not None and self.scene.image.colors is not None)
        return {"content": colored, "map": not colored or self.get_choice("content") == _SHOW_CHANNEL}.get(name, True)

    def view_state(self) -> dict[str, object]:
        """Return the state, with the channels, and the window if it was set by hand."""
        state = {**super().view_state(), "channels": to_json(self.looks)}
        return {**state, "low": self.window[0], "high": self.window[1]} if state["range"] == MANUAL_RANGE else state

    def use_view_state(self, state: dict[str, object]) -> None:
        """Restore the state, the channels and the window."""
        state = {"content": state.get("shown"), **state}  # its name in older sessions
        kept = state.get("channels")
        if self.looks and isinstance(kept, list) and len(kept) == len(self.looks):
            with suppress(ValueError):
                self.looks = [from_json(ChannelLook, look, "channel") for look in kept]
                self._choose_looks()  # another channel may be open
                look = self.looks[self.open_channel]
                window = look.window or self.window
                state = {**state, "range": look.range, "low": window[0], "high": window[1]}
        super().use_view_state(state)
        low, high = state.get("low"), state.get("high")
        if self.get_choice("range") == MANUAL_RANGE and isinstance(low, int | float) and isinstance(high, int | float):
            self.set_window(float(low), float(high))
        self._show_image()  # looks may have changed without any option
        self.changed.emit()

    @property
    def is_composite(self) -> bool:
        """Whether all channels of the file are shown together."""
        return bool(self.looks) and self.get_choice("content") == _SHOW_COLORS

    def toggle_composite(self) -> None:
        """Show all channels together, or the open one alone."""
        self.set_option("content", _SHOW_CHANNEL if self.is_composite else _SHOW_COLORS)

    @property
    def wanted_channels(self) -> frozenset[int]:
        """Indices of the channels that a composite shows."""
        return frozenset(index for index, look in enumerate(self.looks) if look.shown and self.is_composite)

    @property
    def open_channel(self) -> int:
        """Index of the channel that is open: the one of the run, whose window can be set."""
        image = self.scene.document.image
        return 0 if image is None else (image.reading.channel or 1) - 1

    @property
    def shown_channels(self) -> Mapping[int, tuple[Image, IntensityWindow, str]]:
        """The other channels that a composite shows, as far as they have been read, each with its window and color."""
        found, gamma = {}, self.get_amount("gamma")
        for index in self.wanted_channels:
            image, look = (self.scene.whole or self.scene).channels[index].image, self.looks[index]
            if image is not None:
                low, high = look.window or image.window or image.shown_range
                found[index] = image, IntensityWindow(low, high, gamma), look.color
        return found

    def set_look(self, channel: int, **changes: Any) -> None:
        """Show or hide a channel, by its index, or change its color or its window."""
        automatic = self.looks[channel].automatic and not changes.keys() & {"shown", "color"}
        self.looks[channel] = replace(self.looks[channel], automatic=automatic, **changes)
        self._show_image()
        self.changed.emit()

    def find_channel_image(self, channel: int) -> Image | None:
        """Return the image of a channel, by its index; None until it has been read."""
        scene = self.scene.whole or self.scene
        return scene.full_image if channel == self.open_channel else scene.channels[channel].image

    def channel_range(self, channel: int) -> str:
        """Return the range in which a channel is shown, by its index."""
        if channel == self.open_channel:
            return self.get_choice("range")
        image = self.find_channel_image(channel)
        return self.looks[channel].range or (WHOLE_RANGE if image is None or image.window is None else FILE_RANGE)

    def set_channel_range(self, channel: int, way: str) -> None:
        """Show a channel, by its index, in another range."""
        image = self.find_channel_image(channel)
        if channel == self.open_channel:
            self.set_option("range", way)
        elif image is not None and way != MANUAL_RANGE:  # in which it is already
            self.set_look(channel, range=way, window=_find_range(image, way))

    def _choose_looks(self) -> None:
        """Choose a look for the channels for which nobody has: one with a bright background would drown the others."""
        channels, here = (self.scene.whole or self.scene).channels, self.open_channel
        mixed = not all(channel.is_bright for channel in channels)
        for index, (look, channel) in enumerate(zip(self.looks, channels, strict=True)):
            if look.automatic:
                bright = mixed and channel.is_bright
                shown = index < _MAX_CHANNELS_AT_FIRST and (not bright or index == here)
                self.looks[index] = replace(look, shown=shown, color=_BRIGHT_COLOR if bright else channel.color)

    def show_scene(self, before: Scene) -> None:
        """Show another image, or shades that were requested."""
        scene, image, shaded = self.scene, self.scene.image, self.scene.shaded
        if image is None or scene.display is None:
            return
        channel, last = scene.document.parameters.channel, before.document.parameters.channel
        whole, former = scene.full_image or image, before.full_image
        if image is not before.image and (former is None or whole.values is not former.values):
            self._parts.clear()
            listed, known = ([(each.name, each.color) for each in one.channels] for one in (scene, before))
            if listed != known:
                self.looks = [ChannelLook(True, each.color, automatic=True) for each in scene.channels]
            self.looks = [replace(look, range="", window=None) for look in self.looks]
            self._choose_looks()
            self.gray_range = self.window = whole.shown_range
            usual = [window_from_level(window) for _, window in CT_WINDOWS.values()] if whole.is_ct else []
            low, high = zip(self.gray_range, whole.window or self.gray_range, *usual, strict=True)
            self.window_bounds = min(low), max(high)
            if whole.window is not None:
                self.option_values["range"] = FILE_RANGE
            elif self.get_choice("range") in (MANUAL_RANGE, FILE_RANGE):
                # a window set by hand for another image does not apply to this one
                self.option_values["range"] = WHOLE_RANGE
            self._apply_range()
        elif (image, scene.display, channel) != (before.image, before.display, last):
            self._update_shades()  # another slice of the volume, another pixel size, or a completed preview
        elif scene.channels != before.channels:
            former_looks = self.looks.copy()
            self._choose_looks()
            self._show_image()
            if self.looks != former_looks:
                self.changed.emit()
        # of two pending requests, only the newer one may be shown
        wanted = image, self.shown_window, self._channel
        if shaded not in (None, before.shaded) and (shaded.image, shaded.window, shaded.channel) == wanted:
            self._show_image(shaded.display)

    def _apply_range(self) -> None:
        """Set the window from the selected range."""
        way, image = self.get_choice("range"), self.scene.full_image
        if image is None or way == MANUAL_RANGE:
            return
        self._apply_window(*_find_range(image, way))

    def _apply_window(self, low: float, high: float) -> None:
        self.window = (low, high)
        if self.looks:
            look = self.looks[self.open_channel]
            self.looks[self.open_channel] = replace(look, range=self.get_choice("range"), window=self.window)
        self._update_shades()
        self.changed.emit()

    def _update_shades(self) -> None:
        image, whole, channel = self.scene.image, self.scene.display, self._channel
        if image is None or whole is None:
            return
        window, all_of_it = self.shown_window, self.shown_window == IntensityWindow(*self.gray_range)
        if image.colors is not None and channel is None:
            self._item.set_tone_curve(None if all_of_it else compute_color_curve(window, image.colors.white))
            self._show_image(whole)
        elif image.colors is None and all_of_it:
            self._show_image(whole)
        elif image.colors is None and image.values.size <= _MAX_IMMEDIATE_PIXELS:
            self._show_image(DisplayImage.from_image(image, window))
        elif channel is not None and self.session is not None:
            self.session.post_command(shade_image(image, window, channel))

    def _show_image(self, display: DisplayImage | None = None) -> None:
        """Show the image, by default as it is shown now, with the other channels of a composite."""
        display = display or self._item.display
        if display is not None:
            self._apply_colors()
            others = tuple((self._shade_channel(*each), each[1][2]) for each in self.shown_channels.items())
            self._item.show_image(display, others)

    def _shade_channel(self, index: int, shown: tuple[Image, IntensityWindow, str]) -> DisplayImage:
        """Shade another channel, or a slice of it."""
        channel, (whole, window, _) = self.scene.channels[index], shown
        if channel.display is not None and window == IntensityWindow(*whole.shown_range):
            return channel.display
        image = channel.image or whole

        def make_display() -> DisplayImage:
            if image.stored.size > _MAX_IMMEDIATE_PIXELS:
                return DisplayImage.from_visible(image, window)
            return DisplayImage.from_image(image, window)

        return self._parts.get_named(index, make_display, image, window)

    @property
    def color_table(self) -> Pixels:
        """Color of each shade, shape (256, 3); in a composite, of the open channel."""
        if self.is_composite:
            look = self.looks[self.open_channel]
            return color_maps.ramp_table(look.color if look.shown else "black")
        return color_maps.color_table(self.get_choice("map"))

    def _apply_colors(self) -> None:
        gray = not self.is_composite and self.get_choice("map") == color_maps.GRAY_MAP
        self._item.set_color_table(None if gray else self.color_table)

    @property
    def _channel(self) -> str | None:
        """Channel that is shown; None for an image in color."""
        image = self.scene.image
        if image is None or (image.colors is not None and self.get_choice("content") == _SHOW_COLORS):
            return None
        return image.resolve_channel(self.scene.document.parameters.channel)


_FULL_DRAG_LENGTH = 400.0
"""Length of a drag that changes width or middle by the whole range [px of the screen]."""

_MIN_WINDOW_WIDTH = 1e-3
"""Minimum width of the window, as a fraction of the range."""

Window = tuple[float, float]
"""Gray values shown as black and as white."""


def _find_range(image: Image, way: str) -> Window:
    """Find the window of a range that is not set by hand."""
    if way in (WHOLE_RANGE, FILE_RANGE):
        return (way == FILE_RANGE and image.window) or image.shown_range
    return percentile_window(image.values, float(way))


def window_from_level(width_and_level: WidthAndLevel) -> Window:
    """Return the window of gray values of a width around a level."""
    width, level = width_and_level
    return level - 0.5 * width, level + 0.5 * width


def format_window(window: Window) -> str:
    """Format width and level of a window in the manner of radiology."""
    low, high = window
    return f"W {localize_number(f'{high - low:.4g}')}  L {localize_number(f'{0.5 * (low + high):.4g}')}"


def drag_window(window: Window, ends: Window, right: float, down: float) -> Window:
    """Return the window of gray values after a drag to the right and down [px of the screen], within `ends`."""
    span = ends[1] - ends[0]
    width = window[1] - window[0] + span * right / _FULL_DRAG_LENGTH
    width = min(max(width, _MIN_WINDOW_WIDTH * span), span)
    middle = 0.5 * (window[0] + window[1]) - span * down / _FULL_DRAG_LENGTH
    middle = min(max(middle, ends[0]), ends[1])
    return max(middle - 0.5 * width, ends[0]), min(middle + 0.5 * width, ends[1])


class LevelDrag(QObject):
    """Adjusts the window of a layer by Ctrl-drags with the right button on the watched widgets."""

    moved = Signal()
    """The window has changed during a drag."""
    ended = Signal()
    """The button has been released."""

    def __init__(self, layer: ImageLayer, widget: QWidget) -> None:
        super().__init__(widget)
        self.watch_widget(widget)
        self._layer = layer
        self._drag_origin: QPointF | None = None
        self._window: Window = (0.0, 1.0)
        self._cursor = QCursor()

    def watch_widget(self, widget: QWidget) -> None:
        """Handle drags on a widget that shows the image."""
        widget.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Begin, continue and end a drag."""
        if not isinstance(event, QMouseEvent) or not isinstance(watched, QWidget):
            return False
        kind, right = event.type(), Qt.MouseButton.RightButton
        begins = event.button() == right and bool(event.modifiers() & Qt.KeyboardModifier.ControlModifier)
        if kind == QEvent.Type.MouseButtonPress and begins and self._layer.scene.image is not None:
            self._drag_origin, self._window = event.position(), self._layer.window
            self._cursor = watched.cursor()
            watched.setCursor(Qt.CursorShape.SizeAllCursor)
            return True
        if self._drag_origin is None:
            return False
        if kind == QEvent.Type.MouseMove:
            way = event.position() - self._drag_origin
            self._layer.set_window(*drag_window(self._window, self._layer.window_bounds, way.x(), way.y()))
            self.moved.emit()
            return True
        if kind == QEvent.Type.MouseButtonRelease and event.button() == right:
            self._drag_origin = None
            watched.setCursor(self._cursor)
            self.ended.emit()
            return True
        return False
