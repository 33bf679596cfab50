"""The layer of the contours: closed and open ones in two colours, bridged gaps, and the junctions of contours."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pyqtgraph as pg

from app.views import theme
from app.views.coordinates import to_xy
from app.views.curves import Curves
from cpm_core.bridge import Bridge
from cpm_core.contour import Contour


class ContourLayer:
    """Shows contours."""

    def __init__(self, view: pg.ViewBox) -> None:
        self._curves = {True: Curves(theme.CLOSED, 4.0), False: Curves(theme.OPEN, 4.1)}
        self._bridges = Curves(theme.BRIDGE, 4.2, dashed=True)
        self._junctions = pg.ScatterPlotItem(
            size=8.0, symbol="d", pen=pg.mkPen(theme.HALO), brush=pg.mkBrush(theme.JUNCTION)
        )
        self._junctions.setZValue(5.5)
        self._lines = (*self._curves.values(), self._bridges)
        for item in (*self._lines, self._junctions):
            view.addItem(item, ignoreBounds=True)

    @property
    def counts(self) -> tuple[int, int]:
        """Closed and open contours shown."""
        return self._curves[True].count, self._curves[False].count

    @property
    def bridged(self) -> int:
        """Bridged gaps shown."""
        return self._bridges.count

    def use_shape(self, shape: tuple[int, ...]) -> None:
        """Make room for an image of this shape."""
        for item in self._lines:
            item.use_shape(shape)

    def show(self, contours: Iterable[Contour], bridges: Iterable[Bridge] = ()) -> None:
        """Show contours, and over them the gaps that were bridged."""
        contours = tuple(contours)
        for closed, item in self._curves.items():
            item.show([contour.path for contour in contours if contour.closed == closed])
        self._bridges.show([bridge.points for bridge in bridges])
        ends = [contour.points[end] for contour in contours for end in (0, -1) if contour.junctions[end]]
        x, y = to_xy(np.unique(np.array(ends, dtype=float).reshape(-1, 2), axis=0))
        self._junctions.setData(x=x, y=y)

    def set_visible(self, visible: bool) -> None:
        """Show or hide them all."""
        for item in self._lines:
            item.set_wanted(visible)
        self._junctions.setVisible(visible)
