"""The window of gray values: by dragging in any view of the image, all of them, or all but the most extreme."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from app.model.state.situation import Condition, has_image
from app.model.text.language import tr
from app.model.text.numbers import written
from app.views.canvas.layers.image.image import AUTOMATIC, WHOLE
from app.views.widgets.action_spec import STATE, ActionSpec
from app.views.window.feature import Feature, FeatureContext

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
