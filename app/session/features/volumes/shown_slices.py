"""The slices that are shown: moved and turned by slider, keys and wheel; no part of the document."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from app.model.volume.slices import Slices
from app.session.session import Session
from cpm_core.numerics.types import Place

_FAR = 10**6
"""Largest index that is taken from a file [voxels]."""


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

    def pass_on(self, axis: int, by: int) -> None:
        """Show the slice so many further along an axis, whichever is worked on."""
        if self.now is not None:
            self._use(self.now.turned(axis).at(self.now.voxel[axis] + by).turned(self.now.axis))

    def turn(self, axis: int) -> None:
        """Work on the slice across another axis."""
        if self.now is not None:
            self._use(self.now.turned(axis))

    def through(self, place: Place) -> None:
        """Show the slices through a place of the volume."""
        if self.now is not None:
            self._use(self.now.through(place))

    def view_state(self) -> dict[str, object]:
        """Where the slices are, as plain JSON for a session file; empty for an image."""
        now = self.now
        return {} if now is None else {"slices": {"voxel": list(now.voxel), "axis": now.axis}}

    def use_view_state(self, state: Mapping[str, Any]) -> None:
        """Restore the slices from a session file; missing or invalid entries change nothing."""
        kept = state.get("slices")
        if self.now is None or not isinstance(kept, Mapping):
            return
        axis, voxel = kept.get("axis"), kept.get("voxel")
        if axis in (0, 1, 2) and not isinstance(axis, bool):
            self.turn(int(axis))
        known = voxel if isinstance(voxel, list) and len(voxel) == len(self.now.voxel) else []
        if known and all(isinstance(at, int) and abs(at) <= _FAR for at in known):
            self.through(tuple(known))

    def _use(self, slices: Slices) -> None:
        if slices != self.now:
            self._session.show(replace(self._session.scene, slices=slices))
