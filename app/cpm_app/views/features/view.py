"""Menu View: layers, gray values, zoom, and moving the keyboard focus."""

from __future__ import annotations

import json
from functools import partial

from PySide6.QtWidgets import QApplication

from cpm_app.model.state.situation import Situation, has_image
from cpm_app.model.text.language import localize_number, tr
from cpm_app.views.canvas.canvas import WHEEL_ZOOM_FACTOR
from cpm_app.views.layers.image_layer import (
    AUTOMATIC_RANGE,
    CT_WINDOWS,
    WHOLE_RANGE,
    format_window,
    window_from_level,
)
from cpm_app.views.layers.layer import Layer
from cpm_app.views.panels.layer_list import LayersPanel
from cpm_app.views.widgets.actions import LAYER_ACTION_PREFIX, ActionSpec
from cpm_app.views.window.docks import Panel
from cpm_app.views.window.window import Feature

_LAYERS_GROUP = ">" + tr("Layers")
"""Group of the layers in the list of keys."""

_CT_GROUP = ">" + tr("CT window")
"""Group of the usual windows of CT in the list of keys."""

_CT_KEYS = {"soft_tissue": "Shift+F1", "lung": "Shift+F2", "bone": "Shift+F3", "brain": "Shift+F4"}
"""Keys of the windows of CT that are used most."""

_PANELS_GROUP = ">" + tr("Panels")
"""Group of the panels in the list of keys."""

_LAYER_SETTINGS_KEY = "layers/{layer}"
"""Preference: the settings of a layer."""

_LEGEND_FOLDED_KEY = "legend/folded"
"""Preference: whether the legend is folded away."""


class LayersFeature(Feature):
    """Zoom, layers and their settings."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        window = self.window
        area, canvas, workspace = window.canvas_area, self.canvas, window.workspace
        layers, legend = canvas.layers, area.strip.legend.button
        panel = LayersPanel(layers)
        self.panels = (Panel("layers", "Layers", panel, "F8"),)
        canvas.pointer_place_changed.connect(layers.forces.set_pointer)
        for layer in layers:
            layer.use_view_state(window.preferences.read_json(_LAYER_SETTINGS_KEY.format(layer=layer.name)))
            layer.changed.connect(window.refresh_actions)

        def show_range() -> None:
            low, high = layers.image.window
            text = tr(
                "Black {low}, white {high}", low=localize_number(f"{low:.4g}"), high=localize_number(f"{high:.4g}")
            )
            area.strip.show_hint(f"{text}: {format_window((low, high))}")

        area.level_drag.moved.connect(show_range)
        area.level_drag.ended.connect(window.refresh_actions)
        legend.setChecked(not window.preferences.read_key(_LEGEND_FOLDED_KEY, False))
        legend.toggled.connect(lambda unfolded: window.preferences.store_key(_LEGEND_FOLDED_KEY, not unfolded))
        legend.toggled.connect(window.refresh_actions)
        window.shortcuts.changed.connect(lambda: panel.use_actions(window.actions_by_name))
        workspace.contour_selection.selection_changed.connect(window.refresh_actions)
        workspace.object_list.selection_changed.connect(window.refresh_actions)

        def create_layer_action(layer: Layer) -> ActionSpec:
            tip = tr("Show or hide: {layer}", layer=layer.tip)
            return ActionSpec(f"{LAYER_ACTION_PREFIX}{layer.name}", _LAYERS_GROUP, layer.title, tip,
                              lambda: layer.set_shown(not layer.shown), layer.shortcut,
                              checked_when=lambda _: layer.shown)  # fmt: skip

        def shows_ct(_: Situation) -> bool:
            return self.session.image is not None and self.session.image.is_ct

        def create_window_action(name: str) -> ActionSpec:
            title, (width, level) = CT_WINDOWS[name]
            tip = tr(
                "Show the gray values of a CT around {level} HU, {width} HU wide.",
                level=f"{level:g}",
                width=f"{width:g}",
            )
            return ActionSpec(f"ct_{name}", _CT_GROUP, title, tip,
                              lambda: layers.image.set_window(*window_from_level((width, level))),
                              _CT_KEYS.get(name, ""),
                              visible_when=shows_ct)  # fmt: skip

        self.actions = (
            ActionSpec("fit", "View", "&Fit to window", "Show the whole image.", canvas.fit_image, "F Ctrl+0",
                       short=tr("Fit"), icon="fit", when=has_image),
            ActionSpec("actual_size", "View", "&Actual size",
                       "Show one pixel of the image on one pixel of the screen.", partial(canvas.zoom_to, 1.0),
                       "Ctrl+1", when=has_image),
            ActionSpec("zoom_to_selection", "View", "Zoom to the &selection",
                       "Show the selected contours, objects or shape as large as possible.", area.zoom_to_selection,
                       "Shift+F", when=lambda now: now.selected is not None
                       or bool(workspace.object_list.selected_keys)),
            ActionSpec("zoom_in", "View", "Zoom &in", "Zoom in.", partial(canvas.zoom_by, WHEEL_ZOOM_FACTOR),
                       "+ = Ctrl++"),
            ActionSpec("zoom_out", "View", "Zoom &out", "Zoom out.", partial(canvas.zoom_by, 1.0 / WHEEL_ZOOM_FACTOR),
                       "- Ctrl+-"),
            ActionSpec("legend", "View", "Le&gend", "Show or hide what the lines and dots mean.",
                       legend.toggle, "Alt+L", gap=True, checked_when=lambda _: legend.isChecked()),
            *map(create_layer_action, layers),
            ActionSpec("levels_full", _LAYERS_GROUP, "&All gray values",
                       "Show all gray values, from the smallest (black) to the largest (white).",
                       partial(layers.image.set_option, "range", WHOLE_RANGE), "Alt+Shift+W", when=has_image,
                       checked_when=lambda _: layers.image.get_choice("range") == WHOLE_RANGE),
            ActionSpec("levels_auto", _LAYERS_GROUP, "A&utomatic range",
                       "Show all gray values except 0.1 % at either end. Drag with Ctrl and the right "
                       "button to change the range.",
                       partial(layers.image.set_option, "range", AUTOMATIC_RANGE), "Alt+W", when=has_image,
                       checked_when=lambda _: layers.image.get_choice("range") == AUTOMATIC_RANGE),
            *map(create_window_action, CT_WINDOWS),
        )  # fmt: skip

    def close(self) -> bool:
        """Store the settings of the layers, but not their visibility, for the next start."""
        for layer in self.canvas.layers:
            chosen = {name: value for name, value in layer.option_values.items() if value not in ("hand", "file")}
            if layer.options:
                self.window.preferences.store_key(_LAYER_SETTINGS_KEY.format(layer=layer.name), json.dumps(chosen))
        return True


class KeyboardFeature(Feature):
    """Keys that move the keyboard focus to the sliders and from area to area."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        window = self.window
        self.actions = (
            ActionSpec("go_to_sliders", _PANELS_GROUP, "&Go to the sliders",
                       "Move the keyboard focus to the sliders; Enter or Esc returns it to the image.",
                       lambda: window.docks.enter_panel("run"), "Q"),
            ActionSpec("next_area", _PANELS_GROUP, "Go to the ne&xt area",
                       "Move the keyboard focus to the image, the panel and the timeline in turn.",
                       lambda: window.docks.focus_next_area(1), "F6"),
            ActionSpec("previous_area", _PANELS_GROUP, "Go to the pre&vious area", "The same in the other direction.",
                       lambda: window.docks.focus_next_area(-1), "Shift+F6"),
            ActionSpec("open_menu", _PANELS_GROUP, "Context &menu",
                       "Open the menu of a right click.",
                       lambda: window.context_menus.open_menu_at(QApplication.focusWidget()), "Shift+F10 Menu"),
        )  # fmt: skip
