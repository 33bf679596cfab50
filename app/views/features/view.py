"""Menu View: layers, gray values, a close look, going by keys, and the look of the program."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import partial

from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QMenu

from app.model.display.coloring import QUANTITIES
from app.model.preferences.table import CONTOUR_WIDTH, INKS, POINT_SIZE, SHAPE_WIDTH, THEME, UNIT
from app.model.state.situation import Condition, Situation, has_image
from app.model.text.language import tr, written
from app.session.storage.preferences import Preferences
from app.views.canvas.canvas import ZOOM
from app.views.canvas.layers.image_layer import AUTOMATIC, WHOLE
from app.views.canvas.layers.layer import Layer
from app.views.canvas.layers.particles import ParticleLayer
from app.views.canvas.pointed import selected_places
from app.views.canvas.wipe import Wipe
from app.views.panels.layer_list import LayersPanel
from app.views.theme import theme
from app.views.theme.theme import Look, Theme, use_look
from app.views.widgets.actions import LAYER, ActionSpec, Submenu
from app.views.window.feature import Feature, FeatureContext, Panel
from cpm_core import Result

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
            ActionSpec("fit", "View", tr("&Fit to window"), tr("Show the whole image."), canvas.fit, "F Ctrl+0",
                       short=tr("Fit"), icon="fit", when=has_image),
            ActionSpec("actual_size", "View", tr("&Actual size"),
                       tr("Show one pixel of the image on one pixel of the screen."), lambda: canvas.zoom_to(1.0),
                       "Ctrl+1", when=has_image),
            ActionSpec("zoom_to_selection", "View", tr("Zoom to the &selection"),
                       tr("Show the selected contours, objects or shape as large as possible."),
                       self.context.canvas_area.zoom_to_selection, "Shift+F",
                       when=lambda situation: bool(selected_places(self.context.workspace))),
            ActionSpec("zoom_in", "View", tr("Zoom &in"), tr("Zoom in."), lambda: canvas.zoom(ZOOM), "+ = Ctrl++"),
            ActionSpec("zoom_out", "View", tr("Zoom &out"), tr("Zoom out."), lambda: canvas.zoom(1.0 / ZOOM),
                       "- Ctrl+-"),
        )  # fmt: skip
        legend = self.context.canvas_area.strip.legend
        unfold = ActionSpec("legend", "View", tr("Le&gend"), tr("Show or hide what the lines and dots mean."),
                            lambda: legend.fold(not legend.folded), "Alt+L", gap=True,
                            holds=lambda situation: not legend.folded)  # fmt: skip
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
        return ActionSpec(f"colour_{way}", "View>" + tr("Color particles by"), title,
                          QUANTITIES[way].tip if way in QUANTITIES else layer.tip, lambda: layer.choose("colour", way),
                          holds=lambda situation: layer.word("colour") == way)  # fmt: skip

    return [spec(way, title) for way, title in layer.ways.items()]


def _toggle(layer: Layer, first: bool) -> ActionSpec:
    return ActionSpec(f"{LAYER}{layer.name}", "View", layer.title, tr("Show or hide: {layer}").format(layer=layer.tip),
                      lambda: layer.set_shown(not layer.shown), layer.shortcut, gap=first,
                      holds=lambda situation: layer.shown)  # fmt: skip


_MENU = "View>" + tr("Gra&y values")


class LevelsFeature(Feature):
    """Acts on the layer of the image, which slices and the view in space follow."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self._layer = context.canvas_area.canvas.layers.image
        drag = context.canvas_area.level_drag
        drag.moved.connect(self._say)
        drag.ended.connect(context.refresh)

    def action_specs(self) -> Sequence[ActionSpec]:
        """The ranges that need no drag."""
        return tuple(
            ActionSpec(name, _MENU, text, tip, partial(self._choose, value), key, when=has_image,
                       holds=self._is_shown(value))
            for name, text, key, tip, value in (
                ("levels_full", tr("&All gray values"), "Alt+Shift+W",
                 tr("Show all gray values, from the least, black, to the largest, white."), WHOLE),
                ("levels_auto", tr("A&utomatic range"), "Alt+W",
                 tr("Show all gray values but 0.1 % at either end. Drag with Ctrl and the right button to change it."),
                 AUTOMATIC),
            )
        )  # fmt: skip

    def _is_shown(self, value: str) -> Condition:
        return lambda _: self._layer.word("range") == value

    def _choose(self, value: str) -> None:
        self._layer.choose("range", value)
        self.context.refresh()

    def _say(self) -> None:
        low, high = self._layer.window
        text = tr("Black {low}, white {high}").format(low=written(f"{low:.4g}"), high=written(f"{high:.4g}"))
        self.context.canvas_area.strip.say_next(text)


class ComparingFeature(Feature):
    """The wipe: another result on the other side of a divider."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        canvas = context.canvas_area.canvas
        self._other = context.workspace.other_result
        self.wipe = Wipe(canvas)
        self.wipe.ended.connect(lambda: self._other.choose(None))
        self._other.changed.connect(self._show_wipe)
        context.session.scene_changed.connect(self._draw)

    def action_specs(self) -> Sequence[ActionSpec | Submenu]:
        """Compare, and keep a result."""
        return (
            ActionSpec("wipe", "View", tr("Compare &two results"),
                       tr("Show another result on the right of a divider that can be dragged."), self._other.toggle,
                       "Ctrl+D", gap=True, when=has_image, holds=lambda situation: self._other.chosen is not None),
            Submenu(name="wipe_with", menu="View", text=tr("Compare wit&h"), fill=self._fill),
            ActionSpec("keep_result", "View", tr("&Keep this result to compare"),
                       tr("Keep what is found now, to compare later results with it."), self._other.keep,
                       "Ctrl+Shift+D", when=self._has_result),
        )  # fmt: skip

    def _has_result(self, situation: Situation) -> bool:
        scene = self.context.session.scene
        found = None if scene.reconstruction is None else scene.reconstruction.result
        surface = isinstance(found, Result) and found.surface is not None
        return bool(scene.contours.items or scene.skeleton or surface or situation.document.objects.items)

    def _fill(self, menu: QMenu) -> None:
        for other in self._other.choices:
            action = menu.addAction(other.title)
            action.setCheckable(True)
            action.setChecked(other == self._other.chosen)
            action.triggered.connect(partial(self._other.choose, None if other == self._other.chosen else other))

    def _show_wipe(self) -> None:
        if self._other.chosen is None:
            self.wipe.end()
        else:
            self.wipe.begin(*self._other.titles)
            self._draw()
        self.context.refresh()

    def _draw(self) -> None:
        if self._other.chosen is not None:
            self.wipe.draw(self._other.far(self.context.session.scene))


class KeyboardFeature(Feature):
    """Gives the keyboard to the sliders, and to one area of the window after the other."""

    def action_specs(self) -> Sequence[ActionSpec]:
        """The sliders, and the next and previous area."""
        return (
            ActionSpec("go_to_sliders", "View", tr("&Go to the sliders"),
                       tr("Give the keyboard to the sliders; Enter or Esc gives it back to the image."),
                       lambda: self.context.areas().enter("parameters"), "Q", gap=True),
            ActionSpec("next_area", "View", tr("Go to the ne&xt area"),
                       tr("Give the keyboard to the image, the sliders, the table and the timeline in turn."),
                       lambda: self.context.areas().go_on(), "F6"),
            ActionSpec("previous_area", "View", tr("Go to the pre&vious area"), tr("The same in the other direction."),
                       lambda: self.context.areas().go_on(-1), "Shift+F6"),
            ActionSpec("open_menu", "View", tr("&Menu of what is chosen"),
                       tr("Open the menu that a click with the right button opens."), self.context.open_menu,
                       "Shift+F10 Menu"),
        )  # fmt: skip


_THEMES = {"light": theme.LIGHT, "dark": theme.DARK}
_OF_LOOK = {CONTOUR_WIDTH.name, SHAPE_WIDTH.name, POINT_SIZE.name, *(color.name for color in INKS.values())}


class AppearanceFeature(Feature):
    """The colors of the window, and the look of what is drawn on the canvas."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self._following = True
        self._use_look()
        context.preferences.changed.connect(self._follow)
        QGuiApplication.styleHints().colorSchemeChanged.connect(self._follow_desktop)

    def theme(self) -> theme.Theme:
        """The chosen theme, or that of the desktop."""
        return _THEMES.get(self.context.preferences.value(THEME)) or theme.system_theme()

    def close(self) -> bool:
        """Stop following the desktop."""
        if self._following:
            self._following = False
            QGuiApplication.styleHints().colorSchemeChanged.disconnect(self._follow_desktop)
        return True

    def _follow(self, key: str) -> None:
        if key == THEME.name:
            self.context.use_theme(self.theme())
        elif key in _OF_LOOK:
            self._use_look()
            for item in self.context.canvas_area.canvas.scene().items():
                item.update()
            self.context.use_theme(self.theme())
        elif key == UNIT.name:
            self.context.canvas_area.canvas.layers["scale_bar"].show_or_hide()
            self.context.refresh()

    def _use_look(self) -> None:
        value = self.context.preferences.value
        use_look(
            Look(
                contours=value(CONTOUR_WIDTH) / CONTOUR_WIDTH.default,
                shapes=value(SHAPE_WIDTH) / SHAPE_WIDTH.default,
                points=value(POINT_SIZE) / POINT_SIZE.default,
                colors={name: value(color) for name, color in INKS.items() if value(color) != color.default},
            )
        )

    def _follow_desktop(self) -> None:
        if self.context.preferences.value(THEME) == "system":
            self.context.use_theme(self.theme())
