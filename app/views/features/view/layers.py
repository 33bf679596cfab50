"""Zoom and layers."""

from __future__ import annotations

import json
from collections.abc import Sequence

from app.model.display.coloring import QUANTITIES
from app.model.state.situation import has_image
from app.model.text.language import tr
from app.session.storage.preferences import Preferences
from app.views.canvas.canvas import ZOOM
from app.views.canvas.layers.layer import Layer
from app.views.canvas.layers.particles.particles import ParticleLayer
from app.views.canvas.selected_places import selected_places
from app.views.panels.layer_list import LayersPanel
from app.views.theme.theme import Theme
from app.views.widgets.action_spec import LAYER, STATE, ActionSpec
from app.views.window.feature import Feature, FeatureContext, Panel

_KEY = "layers/{layer}"
"""Preference: the settings of a layer."""

_LEGEND = "legend/folded"
"""Preference: whether the legend is folded away."""


class LayersFeature(Feature):
    """Zoom, layers and their settings."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        layers = context.canvas_area.canvas.layers
        self._menu_state: tuple[object, ...] = ()
        self._panel = LayersPanel(layers)
        context.canvas_area.canvas.pointed.connect(layers.forces.point_at)
        for layer in layers:
            layer.use_view_state(_kept(context.preferences, layer))
            layer.changed.connect(self._follow)
        legend = context.canvas_area.strip.legend
        legend.fold(bool(context.preferences.get(_LEGEND, False)))
        legend.folded_changed.connect(self._fold_legend)
        workspace = context.workspace
        workspace.review.selection_changed.connect(context.refresh)
        workspace.object_list.selection_changed.connect(context.refresh)

    def _fold_legend(self, folded: bool) -> None:
        self.context.preferences.put(_LEGEND, folded)
        self.context.refresh()

    def _follow(self) -> None:
        """Refresh the menu, but only if something that it shows has changed."""
        layers = self.context.canvas_area.canvas.layers
        state = (*(layer.shown for layer in layers), layers.particles.word("colour"))
        if state != self._menu_state:
            self._menu_state = state
            self.context.refresh()

    def action_specs(self) -> Sequence[ActionSpec]:
        """Zoom, one toggle per layer, and the coloring of particles."""
        canvas = self.context.canvas_area.canvas
        zoom = (
            ActionSpec(name="fit", menu="View", text=tr("&Fit to window"), short=tr("Fit"), do=canvas.fit,
                       shortcuts=("F", "Ctrl+0"), tip=tr("Show the whole image."), icon="fit", when=has_image),
            ActionSpec(name="actual_size", menu="View", text=tr("&Actual size"), do=lambda: canvas.zoom_to(1.0),
                       shortcuts=("Ctrl+1",), tip=tr("Show one pixel of the image on one pixel of the screen."),
                       when=has_image),
            ActionSpec(name="zoom_to_selection", menu="View", text=tr("Zoom to the &selection"),
                       do=self.context.canvas_area.zoom_to_selection, shortcuts=("Shift+F",),
                       tip=tr("Show the selected contours, objects or shape as large as possible."),
                       when=lambda situation: bool(selected_places(self.context.workspace))),
            ActionSpec(name="zoom_in", menu="View", text=tr("Zoom &in"), do=lambda: canvas.zoom(ZOOM),
                       shortcuts=("+", "=", "Ctrl++"), tip=tr("Zoom in.")),
            ActionSpec(name="zoom_out", menu="View", text=tr("Zoom &out"), do=lambda: canvas.zoom(1.0 / ZOOM),
                       shortcuts=("-", "Ctrl+-"), tip=tr("Zoom out.")),
        )  # fmt: skip
        legend = self.context.canvas_area.strip.legend
        unfold = ActionSpec(name="legend", menu="View", text=tr("Le&gend"), do=lambda: legend.fold(not legend.folded),
                            shortcuts=("Alt+L",), tip=tr("Show or hide what the lines and dots mean."), group=STATE,
                            gap=True, holds=lambda situation: not legend.folded)  # fmt: skip
        toggles = [_toggle(layer, index == 0) for index, layer in enumerate(canvas.layers)]
        return (*zoom, unfold, *toggles, *_colorings(canvas.layers.particles))

    def panels(self) -> Sequence[Panel]:
        """The layers."""
        return (Panel(name="layers", title=tr("Layers"), widget=self._panel, tab="settings", shortcut="F8"),)

    def use_theme(self, theme: Theme) -> None:
        """Show the colors of layers; the preferences may have changed them."""
        self._panel.show_colors()
        self.context.canvas_area.strip.legend.update()

    def use_keys(self) -> None:
        """Name the keys of layers in their tooltips."""
        prefix = LAYER
        specs = [spec for spec in self.context.action_specs() if spec.name.startswith(prefix)]
        self._panel.show_keys({spec.name.removeprefix(prefix): spec.shortcuts for spec in specs})

    def close(self) -> bool:
        """Keep the settings of layers for the next start; their visibility is not kept."""
        for layer in self.context.canvas_area.canvas.layers:
            chosen = {name: value for name, value in layer.chosen.items() if value != "hand"}
            if layer.options:
                self.context.preferences.put(_KEY.format(layer=layer.name), json.dumps(chosen))
        return True


def _kept(preferences: Preferences, layer: Layer) -> dict[str, object]:
    """The stored settings of a layer; empty if they cannot be read."""
    try:
        kept = json.loads(preferences.get(_KEY.format(layer=layer.name), "{}"))
    except json.JSONDecodeError:
        return {}
    return {name: kept[name] for name in layer.chosen if name in kept} if isinstance(kept, dict) else {}


def _colorings(layer: ParticleLayer) -> list[ActionSpec]:
    """One action per quantity that particles can be colored by."""

    def spec(way: str, title: str) -> ActionSpec:
        return ActionSpec(name=f"colour_{way}", menu="View>" + tr("Color particles by"), text=title,
                          do=lambda: layer.choose("colour", way),
                          tip=QUANTITIES[way].tip if way in QUANTITIES else layer.tip, group=STATE,
                          holds=lambda situation: layer.word("colour") == way)  # fmt: skip

    return [spec(way, title) for way, title in layer.ways.items()]


def _toggle(layer: Layer, first: bool) -> ActionSpec:
    return ActionSpec(name=f"{LAYER}{layer.name}", menu="View", text=layer.title,
                      do=lambda: layer.set_shown(not layer.shown),
                      shortcuts=(layer.shortcut,) if layer.shortcut else (),
                      tip=tr("Show or hide: {layer}").format(layer=layer.tip), group=STATE, checked=layer.shown,
                      gap=first, holds=lambda situation: layer.shown)  # fmt: skip
