"""The layer of the particles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np
import pyqtgraph as pg
from PySide6.QtGui import QColor

from app.model.display.coloring import QUANTITIES, SHADES, InsertionTimes, colored
from app.model.text.language import tr
from app.session.exchange.messages import Snapshot
from app.session.scene import Scene
from app.views.canvas.items.discs import NO_POSITIONS, Discs
from app.views.canvas.layers.layer import Layer, Requests
from app.views.canvas.layers.legend_entry import LegendEntry
from app.views.canvas.layers.options import Choice
from app.views.canvas.layers.particles.color_legend import BEGIN, UNKNOWN, ColorLegend
from app.views.theme import color_maps, theme
from cpm_core.numerics.types import Array

_SMALL, _SAME, _HIDDEN = "small", "same", "hidden"
_RECEDING, _PALE = 0.55, 0.4
"""Factors of the diameter and of the opacity of particles after the end of a run."""

_ABOVE, _BELOW = 6.0, 3.1
"""Places in the stack of the moving particles: above the contours during a run, and below them after its end."""

_FADED = 0.85
"""How much of its opacity a particle has lost where it is so far from a slice that it is not shown any more."""

_STATE = "state"
_COLORS = ("viridis", "cividis", "magma")


class ParticleLayer(Layer):
    """The particles, colored by state (moving or at rest) or by a quantity.

    They lead during a run; after its end they recede behind what has been found.
    """

    name = "particles"
    title = tr("Particles")
    tip = tr("Moving, and nearly at rest.")
    shortcut = "Alt+1"
    in_slices = True
    colors = (theme.MOVING, theme.RESTING)
    ways: ClassVar = {_STATE: tr("Moving or at rest"), **{name: kind.title for name, kind in QUANTITIES.items()}}
    """Names and titles of what the color can show."""
    options = (
        Choice("colour", tr("Color by"), ways, _STATE, " ".join(quantity.tip for quantity in QUANTITIES.values())),
        Choice(
            "map",
            tr("Colors"),
            {name: color_maps.MAPS[name] for name in _COLORS},
            "viridis",
            tr("Colors from low to high."),
        ),
        Choice(
            "done",
            tr("After a run"),
            {_SMALL: tr("Small and pale"), _SAME: tr("As during the run"), _HIDDEN: tr("Hidden")},
            _SMALL,
            tr("How particles are shown when a run has ended."),
        ),
    )

    def __init__(self, view: pg.ViewBox, requests: Requests) -> None:
        super().__init__(view, requests)
        # Contours lie above the particles at rest and below those that still move.
        self._resting = Discs(theme.RESTING, 7.0, 3.0)
        self._moving = Discs(theme.MOVING, 6.0, _ABOVE)
        self.legend = ColorLegend(view)
        self.add(self._resting, self._moving)
        self.pin(self.legend)

    @property
    def position(self) -> Array:
        """Where particles are shown (row, col), shape (N, 2)."""
        return np.concatenate([self._resting.position, self._moving.position])

    @property
    def count(self) -> int:
        """Number of particles shown."""
        return self._resting.count + self._moving.count

    @property
    def receding(self) -> bool:
        """Whether the run has ended, and the particles are shown less than during the run."""
        return _ended(self.scene) and self.word("done") != _SAME

    def size_of(self, snapshot: Snapshot) -> float:
        """Factor for the diameter of the particles of a snapshot; 0 where they are hidden after its run."""
        if not snapshot.state.stop_reason:
            return 1.0
        return {_SAME: 1.0, _SMALL: _RECEDING, _HIDDEN: 0.0}[self.word("done")]

    def legend_entries(self) -> Sequence[LegendEntry]:
        """Particles by state during a run; those colored by a quantity have a legend on the canvas."""
        if _ended(self.scene) or self.word("colour") != _STATE:
            return ()
        kinds = (
            (self._moving, tr("moving"), tr("Particles that move."), theme.MOVING),
            (self._resting, tr("at rest"), tr("Particles that hardly move."), theme.RESTING),
        )
        return [LegendEntry(discs.count, text, tip, color, "dot", 6.0) for discs, text, tip, color in kinds]

    def show_or_hide(self) -> None:
        """Show or hide the particles and the legend."""
        super().show_or_hide()
        hidden = self.receding and self.word("done") == _HIDDEN
        for discs in (self._resting, self._moving):
            discs.set_shown(self.shown and not hidden)
        self._show_legend()

    def fade(self) -> None:
        """Set opacity, size and place in the stack."""
        small = self.receding
        for discs in (self._resting, self._moving):
            discs.setOpacity(self.opacity * (_PALE if small else 1.0))
            discs.shrink(_RECEDING if small else 1.0)
        self._moving.setZValue(_BELOW if small else _ABOVE)

    def acts(self, name: str) -> bool:
        """Colors from low to high act only where a quantity is shown."""
        return name != "map" or self.word("colour") != _STATE

    def follow_choice(self, name: str) -> None:
        """Change the colors, or how the particles are shown after a run."""
        if name == "done":
            self._recede()
            return
        palette = [] if self.word("colour") == _STATE else _palette(self.word("map"))
        for discs in (self._resting, self._moving):
            discs.use_palette(palette)
        self._show()

    def follow(self, before: Scene) -> None:
        """Show the newest particles."""
        if self.scene.snapshot is not before.snapshot:  # another slice shows others of the same particles
            self._show()
            if _ended(self.scene) != _ended(before):
                self._recede()

    def _show(self) -> None:
        snapshot, near = self.scene.snapshot, self.scene.near
        opacity = None if near is None else 1.0 - _FADED * near.away
        if snapshot is None:
            self._resting.show(NO_POSITIONS)
            self._moving.show(NO_POSITIONS)
        elif self.word("colour") == _STATE:
            for discs, which in ((self._resting, snapshot.resting), (self._moving, ~snapshot.resting)):
                discs.show(snapshot.position[which], None, None if opacity is None else opacity[which])
        else:
            quantity = QUANTITIES[self.word("colour")]
            shown = colored(quantity, snapshot.state, InsertionTimes(snapshot.metrics.step, snapshot.metrics.numbered))
            marks = shown.marks if near is None else shown.marks[near.index]
            for discs, which in ((self._resting, snapshot.resting), (self._moving, ~snapshot.resting)):
                discs.show(snapshot.position[which], marks[which], None if opacity is None else opacity[which])
            partly = bool((shown.marks == SHADES).any())
            self.legend.show_range(quantity.title, shown.low, shown.high, self.word("map"), partly)
        self._show_legend()

    def _recede(self) -> None:
        self.fade()
        self.show_or_hide()

    def _show_legend(self) -> None:
        self.legend.setVisible(self.shown and self.scene.snapshot is not None and self.word("colour") != _STATE)


def _ended(scene: Scene) -> bool:
    return scene.snapshot is not None and bool(scene.snapshot.state.stop_reason)


def _palette(name: str) -> list[str]:
    """Colors from low to high, and one for unknown values."""
    return [QColor(*map(int, row)).name() for row in color_maps.table(name, SHADES, BEGIN)] + [UNKNOWN]
