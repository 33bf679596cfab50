"""The layer of the particles, and the legend of their colors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from PySide6.QtCore import QUrl
from PySide6.QtGui import QColor, QTextDocument

from cpm_app.model.display.coloring import QUANTITIES, SHADE_COUNT, color_particles
from cpm_app.model.text.language import localize_number, tr
from cpm_app.session.exchange.messages import Snapshot
from cpm_app.session.scene import Scene
from cpm_app.views.items.discs import Discs
from cpm_app.views.items.item import PinnedText
from cpm_app.views.layers.layer import Layer, LegendEntry, Option
from cpm_app.views.theme import color_maps, theme
from cpm_core.numerics import Array
from cpm_core.numerics.types import NO_POINTS, Texts

_QUANTITY_MAP = "viridis"
"""Color map for quantities."""

_DARK_MAP_FRACTION = 0.18
"""Fraction of the color maps that is too dark to stand out from a dark image."""

_LEGEND_WIDTH = 154
"""Width of the legend [px]."""

_STRIP_HEIGHT = 8
"""Height of the strip of colors in the legend [px]."""

_LEGEND_HTML = (
    f"<table width='{_LEGEND_WIDTH}' cellspacing='0' cellpadding='1'>"
    "<tr><td colspan='3' align='center'>{title}</td></tr>"
    f"<tr><td colspan='3'><img src='{_QUANTITY_MAP}' width='{_LEGEND_WIDTH}' height='{_STRIP_HEIGHT}'></td></tr>"
    f"<tr><td>0</td><td align='center' style='color:{theme.UNKNOWN_COLOR}'>{{unknown}}</td>"
    "<td align='right'>{high}</td></tr></table>"
)
"""Template of the legend: title, a strip of colors, and the values at its ends."""

_ENDED_DIAMETER_FACTOR = 0.55
"""Factor of the diameter of particles after the end of a run."""

_ENDED_OPACITY_FACTOR = 0.4
"""Factor of the opacity of particles after the end of a run."""

_RUNNING_Z = 6.0
"""Place of moving particles in the stack during a run, above the contours."""

_ENDED_Z = 3.1
"""Place of moving particles in the stack after the end of a run, below the contours."""

_OFF_SLICE_FADING = 0.85
"""Fraction of its opacity that a particle has lost at the largest distance from a slice at which it is shown."""

_BY_STATE = "state"
"""Value of the option that colors particles by state."""


class ParticleLayer(Layer):
    """The particles, colored by state (moving or at rest) or by a quantity.

    During a run they lie in front; after its end they recede behind the contours.
    """

    name = "particles"
    title = tr("Particles")
    tip = tr("Moving, and nearly at rest.")
    shortcut = "Alt+1"
    colors = (theme.MOVING_COLOR, theme.RESTING_COLOR)
    color_choices: ClassVar = {
        _BY_STATE: tr("Moving or at rest"),
        **{name: kind.title for name, kind in QUANTITIES.items()},
    }
    """Names and titles of the quantities that the color can show."""
    options = (
        Option(
            "colour",
            tr("Color by"),
            _BY_STATE,
            " ".join(quantity.tip for quantity in QUANTITIES.values()),
            color_choices,
        ),
    )

    def create_items(self) -> None:
        """Create the items of the layer."""
        # Contours lie above the particles at rest and below those that still move.
        self._resting = Discs(theme.RESTING_COLOR, 7.0, 3.0)
        self._moving = Discs(theme.MOVING_COLOR, 6.0, _RUNNING_Z)
        self.legend = PinnedText(self.view, (1.0, 1.0))
        strip = color_maps.draw_color_strip(_QUANTITY_MAP, 2 * _LEGEND_WIDTH, 2 * _STRIP_HEIGHT, _DARK_MAP_FRACTION)
        kind, address = QTextDocument.ResourceType.ImageResource, QUrl(_QUANTITY_MAP)
        self.legend.textItem.document().addResource(kind, address, strip)
        self._discs = (self._resting, self._moving)
        self.add_items(*self._discs, self.legend)

    @property
    def position(self) -> Array:
        """Positions (row, col) of the shown particles, shape (N, 2)."""
        return np.concatenate([discs.position for discs in self._discs])

    @property
    def count(self) -> int:
        """Number of particles shown."""
        return sum(discs.count for discs in self._discs)

    @staticmethod
    def diameter_factor(snapshot: Snapshot | None) -> float:
        """Return the factor for the diameter of the particles of a snapshot."""
        return _ENDED_DIAMETER_FACTOR if snapshot is not None and snapshot.state.stop_reason else 1.0

    def legend_entries(self) -> Sequence[LegendEntry]:
        """Return the entries of the states during a run; quantities have a legend on the canvas."""
        snapshot = self.scene.snapshot
        if self.get_choice("colour") != _BY_STATE or (snapshot is not None and snapshot.state.stop_reason):
            return ()
        kinds = (
            (self._moving, tr("moving"), tr("Particles that move."), theme.MOVING_COLOR),
            (self._resting, tr("at rest"), tr("Particles that hardly move."), theme.RESTING_COLOR),
        )
        return [LegendEntry(discs.count, text, tip, color, "dot") for discs, text, tip, color in kinds]

    def apply_visibility(self) -> None:
        """Show or hide the particles and the legend."""
        for discs in self._discs:
            discs.setVisible(self.shown)
        by_quantity = self.scene.snapshot is not None and self.get_choice("colour") != _BY_STATE
        self.legend.setVisible(self.shown and by_quantity)

    def apply_opacity(self) -> None:
        """Set opacity, size and place in the stack."""
        factor = self.diameter_factor(self.scene.snapshot)
        recede = factor < 1.0
        for discs in self._discs:
            discs.setOpacity(self.opacity * (_ENDED_OPACITY_FACTOR if recede else 1.0))
            discs.set_size_factor(factor)
        self._moving.setZValue(_ENDED_Z if recede else _RUNNING_Z)

    def apply_option(self, _: str) -> None:
        """Change the colors."""
        palette = () if self.get_choice("colour") == _BY_STATE else build_quantity_palette()
        for discs in self._discs:
            discs.set_palette(palette)
        self._show_particles()

    def show_scene(self, before: Scene) -> None:
        """Show the newest particles."""
        if self.scene.snapshot is not before.snapshot:  # another slice has a snapshot of its own
            self._show_particles()

    def _show_particles(self) -> None:
        snapshot, near, marks = self.scene.snapshot, self.scene.near_particles, None
        opacity = None if near is None else 1.0 - _OFF_SLICE_FADING * near.distance
        if snapshot is not None and self.get_choice("colour") != _BY_STATE:
            quantity = QUANTITIES[self.get_choice("colour")]
            marks, high = color_particles(quantity, snapshot.state, snapshot.metrics)
            unknown = tr("● too new") if (marks == SHADE_COUNT).any() else ""
            marks, end = marks if near is None else marks[near.index], localize_number(f"{high:g}")
            self.legend.show_html(_LEGEND_HTML.format(title=quantity.title, high=end, unknown=unknown))
        for discs in self._discs:
            if snapshot is None:
                discs.show_discs(NO_POINTS)
            else:
                which = snapshot.resting if discs is self._resting else ~snapshot.resting
                color = None if marks is None else marks[which]
                discs.show_discs(snapshot.position[which], color, None if opacity is None else opacity[which])
        self.apply_opacity()
        self.apply_visibility()


def build_quantity_palette() -> Texts:
    """Build the palette: colors from low to high, and one for unknown values."""
    table = color_maps.color_table(_QUANTITY_MAP, SHADE_COUNT, _DARK_MAP_FRACTION)
    return (*(QColor(*map(int, row)).name() for row in table), theme.UNKNOWN_COLOR)
