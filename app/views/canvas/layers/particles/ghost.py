"""The layer of the compared branch of the timeline: its particles and contours."""

from __future__ import annotations

from collections.abc import Sequence

import pyqtgraph as pg

from app.model.text.language import tr
from app.session.scene import Scene
from app.views.canvas.items.curves import Curves
from app.views.canvas.items.discs import NO_POSITIONS, Discs
from app.views.canvas.layers.layer import Layer, Requests
from app.views.canvas.layers.legend_entry import LegendEntry
from app.views.theme import theme
from cpm_core.numerics.types import Array


class GhostLayer(Layer):
    """Another branch at the same step, below the current one."""

    name = "ghost"
    title = tr("Compared branch")
    tip = tr("Particles and contours of the compared branch.")
    in_slices = True
    colors = (theme.GHOST,)

    def __init__(self, view: pg.ViewBox, requests: Requests) -> None:
        super().__init__(view, requests)
        self._particles = Discs(theme.GHOST, 5.0, 2.9)
        self._contours = Curves(theme.GHOST, 3.9, dashed=True)
        self.add(self._particles, self._contours)
        self._step: tuple[int | None, int] | None = None

    @property
    def position(self) -> Array:
        """Where particles are shown (row, col), shape (N, 2)."""
        return self._particles.position

    @property
    def count(self) -> int:
        """Number of particles shown."""
        return self._particles.count

    @property
    def contours(self) -> int:
        """Number of contours shown."""
        return self._contours.count

    def legend_entries(self) -> Sequence[LegendEntry]:
        """Contours of the compared branch."""
        tip = tr("Contours of the compared branch.")
        return (LegendEntry(self.contours, tr("compared"), tip, theme.GHOST, "dashed"),)

    def follow(self, before: Scene) -> None:
        """Show the branch as it is at this step."""
        compared = self.scene.compared
        if compared is before.compared:
            return
        position = compared.position if compared is not None else None
        self._particles.show(NO_POSITIONS if position is None else position)
        step = (compared.branch, compared.state.step) if compared is not None and compared.state is not None else None
        if compared is not None and compared.result is not None:
            self._contours.show([contour.path for contour in compared.result.contours])
        elif step != self._step:  # during playback only the particles are updated
            self._contours.show([])
        self._step = step
