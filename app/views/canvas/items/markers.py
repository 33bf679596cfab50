"""Markers on the canvas: symbols of one size, few of them."""

from __future__ import annotations

from typing import Any

import pyqtgraph as pg


class Markers(pg.ScatterPlotItem):  # type: ignore[misc]  # pyqtgraph has no type hints
    """A scatter plot that costs nothing in a frame where it shows nothing, as pyqtgraph's own does."""

    def paint(self, painter: Any, *rest: Any) -> None:
        """Draw the markers, if there are any."""
        if len(self.data):
            super().paint(painter, *rest)
