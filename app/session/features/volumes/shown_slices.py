"""The slices that are shown: moved and turned by slider, keys and wheel; no part of the document."""

from __future__ import annotations

from dataclasses import replace

from app.model.volume.slices import Slices
from app.session.session import Session
from cpm_core.numerics.types import Place


class ShownSlices:
    """Chooses the slices of the volume that is open; without a volume there are none, and nothing happens."""

    def __init__(self, session: Session) -> None:
        self._session = session

    @property
    def now(self) -> Slices | None:
        """The slices that are shown; None while no volume is open."""
        return self._session.scene.slices

    def go(self, by: int) -> None:
        """Show the slice so many further along its axis."""
        if self.now is not None:
            self._use(self.now.at(self.now.current.index + by))

    def at(self, index: int) -> None:
        """Show the slice at an index along its axis."""
        if self.now is not None:
            self._use(self.now.at(index))

    def turn(self, axis: int) -> None:
        """Work on the slice across another axis."""
        if self.now is not None:
            self._use(self.now.turned(axis))

    def through(self, place: Place) -> None:
        """Show the slices through a place of the volume."""
        if self.now is not None:
            self._use(self.now.through(place))

    def _use(self, slices: Slices) -> None:
        if slices != self.now:
            self._session.show(replace(self._session.scene, slices=slices))
