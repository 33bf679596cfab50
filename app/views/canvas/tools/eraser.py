"""The tool that takes away what is drawn, and particles."""

from __future__ import annotations

from app.model.text.language import tr
from app.views.canvas.tools.ringed import Ringed
from app.views.theme import theme
from cpm_core.numerics.types import Position


class EraserTool(Ringed):
    """Erases the points in its ring, the other shapes that it touches, and the particles of a run in it."""

    name = "eraser"
    colour = theme.CHOSEN
    guidance = tr("Drag over points, shapes or particles to erase them; < and > make the ring smaller and larger.")
    by_keys = tr("Enter begins to erase, arrow keys go on, Enter ends; < and > change the ring.")

    def work(self, path: tuple[Position, ...], gesture: str) -> None:
        """Erase along the way of the ring."""
        left = self._session.live.erase(path, self.radius)
        self._session.edit(tr("erase"), lambda _: left, gesture)
