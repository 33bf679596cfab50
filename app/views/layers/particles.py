"""The layer of the particles."""

from __future__ import annotations

import pyqtgraph as pg

from app.model.language import tr
from app.model.shades import Shades
from app.session.messages import Snapshot
from app.session.session import Session
from app.views import theme
from app.views.discs import NO_POSITIONS, Discs
from app.views.layers.layer import Layer
from cpm_core.image import Image


class ParticleLayer(Layer):
    """The particles, those at rest in a colour of their own."""

    name = "particles"
    title = tr("Particles")
    tip = tr("Moving, and nearly at rest.")
    shortcut = "Ctrl+1"
    colours = (theme.MOVING, theme.RESTING)

    def __init__(self, view: pg.ViewBox, session: Session) -> None:
        super().__init__(view, session)
        # Contours run over the particles at rest, so that both are seen, and under those that still move.
        self._resting = Discs(theme.RESTING, 7.0, 3.0)
        self._moving = Discs(theme.MOVING, 6.0, 6.0)
        self.add(self._resting, self._moving)
        session.image_changed.connect(self._use_image)
        session.snapshot_changed.connect(self._show)

    @property
    def count(self) -> int:
        """Number of particles shown."""
        return self._resting.count + self._moving.count

    def _use_image(self, _: Image, shades: Shades) -> None:
        for item in (self._resting, self._moving):
            item.use_shape(shades.shape)

    def _show(self, snapshot: Snapshot | None) -> None:
        if snapshot is None:
            self._resting.show(NO_POSITIONS)
            self._moving.show(NO_POSITIONS)
        else:
            self._resting.show(snapshot.position[snapshot.resting])
            self._moving.show(snapshot.position[~snapshot.resting])
