"""The layer of the contours: closed and open ones in two colours, bridged gaps, and the junctions of contours."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg

from app.model.language import tr
from app.model.shades import Shades
from app.session.session import Session
from app.views import theme
from app.views.coordinates import to_xy
from app.views.curves import Curves
from app.views.layers.layer import Layer
from cpm_core.image import Image
from cpm_core.result import Result


class ContourLayer(Layer):
    """Shows contours."""

    name = "contours"
    title = tr("Contours")
    tip = tr("Closed, and open.")
    shortcut = "Ctrl+2"
    colours = (theme.CLOSED, theme.OPEN)

    def __init__(self, view: pg.ViewBox, session: Session) -> None:
        super().__init__(view, session)
        self._curves = {True: Curves(theme.CLOSED, 4.0), False: Curves(theme.OPEN, 4.1)}
        self._bridges = Curves(theme.BRIDGE, 4.2, dashed=True)
        self._junctions = pg.ScatterPlotItem(
            size=8.0, symbol="d", pen=pg.mkPen(theme.HALO), brush=pg.mkBrush(theme.JUNCTION)
        )
        self._junctions.setZValue(5.5)
        self._lines = (*self._curves.values(), self._bridges)
        self.add(*self._lines, self._junctions)
        session.image_changed.connect(self._use_image)
        session.contours_changed.connect(self._show)

    @property
    def counts(self) -> tuple[int, int]:
        """Closed and open contours shown."""
        return self._curves[True].count, self._curves[False].count

    @property
    def bridged(self) -> int:
        """Bridged gaps shown."""
        return self._bridges.count

    def show_or_hide(self) -> None:
        """Show or hide them all."""
        for item in self._lines:
            item.set_wanted(self.shown)
        self._junctions.setVisible(self.shown)

    def _use_image(self, _: Image, shades: Shades) -> None:
        for item in self._lines:
            item.use_shape(shades.shape)

    def _show(self, result: Result | None) -> None:
        contours = result.contours if result is not None else ()
        bridges = result.bridges if result is not None else ()
        for closed, item in self._curves.items():
            item.show([contour.path for contour in contours if contour.closed == closed])
        self._bridges.show([bridge.points for bridge in bridges])
        ends = [contour.points[end] for contour in contours for end in (0, -1) if contour.junctions[end]]
        x, y = to_xy(np.unique(np.array(ends, dtype=float).reshape(-1, 2), axis=0))
        self._junctions.setData(x=x, y=y)
