"""How the program looks: light or dark, lines and points on the canvas, and units."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from PySide6.QtGui import QGuiApplication

from app.model.preferences.table import CONTOUR_WIDTH, INKS, POINT_SIZE, SHAPE_WIDTH, THEME, UNIT
from app.model.state.situation import Situation
from app.model.text.language import tr
from app.views.theme import theme
from app.views.theme.look import Look, use_look
from app.views.widgets.action_spec import STATE, ActionSpec
from app.views.window.feature import Feature, FeatureContext

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
