"""Menu View: layers, gray values, a close look, going by keys, and the look of the program."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import partial

from PySide6.QtCore import QElapsedTimer, QEvent, QObject, Qt
from PySide6.QtGui import QGuiApplication, QKeyEvent
from PySide6.QtWidgets import QMenu

from app.model.display.coloring import QUANTITIES
from app.model.preferences.table import CONTOUR_WIDTH, INKS, POINT_SIZE, SHAPE_WIDTH, THEME, UNIT
from app.model.state.situation import Condition, Situation, has_image
from app.model.text.language import tr
from app.model.text.numbers import written
from app.session.storage.preferences import Preferences
from app.views.canvas.canvas import ZOOM
from app.views.canvas.layers.image.image import AUTOMATIC, WHOLE
from app.views.canvas.layers.layer import Layer
from app.views.canvas.layers.particles.particles import ParticleLayer
from app.views.canvas.mirrors.magnifier import Magnifier
from app.views.canvas.mirrors.wipe import Wipe
from app.views.canvas.selected_places import selected_places
from app.views.panels.layer_list import LayersPanel
from app.views.theme import theme
from app.views.theme.look import Look, use_look
from app.views.theme.theme import Theme
from app.views.widgets.action_spec import LAYER, STATE, ActionSpec, Submenu
from app.views.window.feature import Feature, FeatureContext, Panel
from cpm_core.contours.result import Result

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
            ActionSpec(name=name, menu=_MENU, text=text, do=partial(self._choose, value), shortcuts=(key,),
                       tip=tip, group=STATE, when=has_image, holds=self._is_shown(value))
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


_HELD = 350
"""Time after which the key of the magnifier counts as held: then it ends when the key is released [ms]."""


class ComparingFeature(Feature):
    """The wipe and the magnifier."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        canvas = context.canvas_area.canvas
        self._other = context.workspace.other_result
        self.wipe = Wipe(canvas)
        self.magnifier = Magnifier(canvas)
        self._held = QElapsedTimer()
        self._keys = _Release(self)
        canvas.installEventFilter(self._keys)
        self.wipe.ended.connect(lambda: self._other.choose(None))
        self._other.changed.connect(self._show_wipe)
        context.session.scene_changed.connect(self._draw)
        context.session.image_changed.connect(lambda: self.magnifier.switch(False))

    def action_specs(self) -> Sequence[ActionSpec | Submenu]:
        """Compare, keep a result, magnify."""
        return (
            ActionSpec(name="wipe", menu="View", text=tr("Compare &two results"), do=self._other.toggle,
                       shortcuts=("Ctrl+D",), gap=True, when=has_image, group=STATE,
                       tip=tr("Show another result on the right of a divider that can be dragged."),
                       holds=lambda situation: self._other.chosen is not None),
            Submenu(name="wipe_with", menu="View", text=tr("Compare wit&h"), fill=self._fill),
            ActionSpec(name="keep_result", menu="View", text=tr("&Keep this result to compare"), do=self._other.keep,
                       shortcuts=("Ctrl+Shift+D",), tip=tr("Keep what is found now, to compare later results with it."),
                       when=self._has_result),
            ActionSpec(name="magnifier", menu="View", text=tr("&Magnifier"), do=self._switch, shortcuts=("M",),
                       tip=tr("Show what is under the pointer four times as large; hold the key for a short look."),
                       when=has_image, group=STATE, holds=lambda situation: self.magnifier.shown),
        )  # fmt: skip

    def release(self) -> None:
        """The key of the magnifier has been released; after a while that ends it."""
        if self.magnifier.shown and self._held.isValid() and self._held.elapsed() >= _HELD:
            self._switch()
        self._held.invalidate()

    def _switch(self) -> None:
        self.magnifier.switch(not self.magnifier.shown)
        if self.magnifier.shown:
            self._held.start()
        self.context.refresh()

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
        scene = self.context.session.scene
        if self._other.chosen is not None:
            self.wipe.draw(self._other.far(scene))
        self.magnifier.draw(self._other.near(scene))


class _Release(QObject):
    """Reports the release of the key of the magnifier."""

    def __init__(self, feature: ComparingFeature) -> None:
        super().__init__(feature.context.window)
        self._feature = feature

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Look for the key."""
        if not isinstance(event, QKeyEvent) or event.type() != QEvent.Type.KeyRelease:
            return False
        if event.key() == Qt.Key.Key_M and not event.isAutoRepeat():
            self._feature.release()
        return False


class KeyboardFeature(Feature):
    """Gives the keyboard to the sliders, and to one area of the window after the other."""

    def action_specs(self) -> Sequence[ActionSpec]:
        """The sliders, and the next and previous area."""
        return (
            ActionSpec(name="go_to_sliders", menu="View", text=tr("&Go to the sliders"),
                       do=lambda: self.context.areas().enter("parameters"), shortcuts=("Q",), gap=True,
                       tip=tr("Give the keyboard to the sliders; Enter or Esc gives it back to the image.")),
            ActionSpec(name="next_area", menu="View", text=tr("Go to the ne&xt area"),
                       do=lambda: self.context.areas().go_on(), shortcuts=("F6",),
                       tip=tr("Give the keyboard to the image, the sliders, the table and the timeline in turn.")),
            ActionSpec(name="previous_area", menu="View", text=tr("Go to the pre&vious area"),
                       do=lambda: self.context.areas().go_on(-1), shortcuts=("Shift+F6",),
                       tip=tr("The same in the other direction.")),
            ActionSpec(name="open_menu", menu="View", text=tr("&Menu of what is chosen"), do=self.context.open_menu,
                       shortcuts=("Shift+F10", "Menu"),
                       tip=tr("Open the menu that a click with the right button opens.")),
        )  # fmt: skip


_CHOICES: tuple[tuple[str, str, str, theme.Theme | None], ...] = (
    ("system", tr("Colors of the &desktop"), tr("Light or dark colors, as on the desktop."), None),
    ("light", tr("&Light colors"), tr("Light background."), theme.LIGHT),
    ("dark", tr("Dar&k colors"), tr("Dark background."), theme.DARK),
)
_OF_LOOK = {CONTOUR_WIDTH.name, SHAPE_WIDTH.name, POINT_SIZE.name, *(color.name for color in INKS.values())}


class AppearanceFeature(Feature):
    """The colors of the window, and the look of what is drawn on the canvas."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self._following = True
        self._use_look()
        context.preferences.changed.connect(self._follow)
        QGuiApplication.styleHints().colorSchemeChanged.connect(self._follow_desktop)

    def action_specs(self) -> Sequence[ActionSpec]:
        """The choices."""
        return [
            ActionSpec(name=f"theme_{name}", menu="View", text=text, do=partial(self._choose, name), tip=tip,
                       group=STATE, checked=name == self._chosen, holds=partial(self._holds, name), gap=index == 0)
            for index, (name, text, tip, _) in enumerate(_CHOICES)
        ]  # fmt: skip

    def theme(self) -> theme.Theme:
        """The chosen theme, or that of the desktop."""
        chosen = {name: made for name, _, _, made in _CHOICES}.get(self._chosen)
        return chosen or theme.system_theme()

    def close(self) -> bool:
        """Stop following the desktop."""
        if self._following:
            self._following = False
            QGuiApplication.styleHints().colorSchemeChanged.disconnect(self._follow_desktop)
        return True

    @property
    def _chosen(self) -> str:
        return self.context.preferences.value(THEME)

    def _choose(self, name: str) -> None:
        self.context.preferences.choose(THEME, name)

    def _follow(self, key: str) -> None:
        if key == THEME.name:
            self.context.use_theme(self.theme())
            # The actions must show the new choice.
            self.context.refresh()
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

    def _holds(self, name: str, situation: Situation) -> bool:
        return name == self._chosen

    def _follow_desktop(self) -> None:
        if self._chosen == "system":
            self.context.use_theme(self.theme())
