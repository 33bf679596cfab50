"""The layer of the branch of the timeline that is compared with: its particles and contours."""

from __future__ import annotations

import pyqtgraph as pg

from app.model.display.display_image import DisplayImage
from app.model.text.language import tr
from app.session.exchange.messages import Report
from app.session.session import Session
from app.session.worker.commands.timeline import Compared
from app.views.canvas.items.curves import Curves
from app.views.canvas.items.discs import NO_POSITIONS, Discs
from app.views.canvas.layers.layer import Layer
from app.views.theme import theme
from cpm_core.image.image import Image


class GhostLayer(Layer):
    """Another branch at the same step, below the one that is shown."""

    name = "ghost"
    title = tr("Compared branch")
    tip = tr("Particles and contours of the branch that is compared with.")
    colours = (theme.GHOST,)

    def __init__(self, view: pg.ViewBox, session: Session) -> None:
        super().__init__(view, session)
        self._particles = Discs(theme.GHOST, 5.0, 2.9)
        self._contours = Curves(theme.GHOST, 3.9, dashed=True)
        self.add(self._particles, self._contours)
        self._step: tuple[int | None, int] | None = None
        session.image_changed.connect(self._use_image)
        session.snapshot_changed.connect(lambda snapshot: self._show(None) if snapshot is None else None)
        session.reported.connect(self._hear)

    @property
    def count(self) -> int:
        """Number of particles shown."""
        return self._particles.count

    @property
    def contours(self) -> int:
        """Number of contours shown."""
        return self._contours.count

    def show_or_hide(self) -> None:
        """Show or hide both."""
        self._particles.setVisible(self.shown)
        self._contours.set_wanted(self.shown)

    def _use_image(self, _: Image, shades: DisplayImage) -> None:
        for item in (self._particles, self._contours):
            item.use_shape(shades.shape)

    def _hear(self, report: Report) -> None:
        if isinstance(report, Compared) and report.generation == self.session.generation:
            self._show(report)

    def _show(self, compared: Compared | None) -> None:
        position = compared.position if compared is not None else None
        self._particles.show(NO_POSITIONS if position is None else position)
        step = (compared.branch, compared.state.step) if compared is not None and compared.state is not None else None
        if compared is not None and compared.result is not None:
            self._contours.show([contour.path for contour in compared.result.contours])
        elif step != self._step:  # while steps go by only the particles are looked at
            self._contours.show([])
        self._step = step
