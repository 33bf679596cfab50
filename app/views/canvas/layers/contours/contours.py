"""The layer of the contours: closed and open ones in two colors or in their own, with names, junctions and bridges."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg

from app.model.text.language import tr
from app.session.scene import Item, Scene
from app.views.canvas.coordinates import to_xy
from app.views.canvas.items.curves import Curves
from app.views.canvas.items.item import Markers
from app.views.canvas.items.names import Names
from app.views.canvas.layers.layer import Layer, Requests
from app.views.canvas.layers.options import Switch
from app.views.theme import theme
from cpm_core.contours.review import middle


class ContourLayer(Layer):
    """Shows contours as reviewed: rejected ones faint and dashed or hidden, selected ones with a bright rim."""

    name = "contours"
    title = tr("Contours")
    tip = tr("Closed, open, and drawn by hand.")
    shortcut = "Ctrl+2"
    colors = (theme.CLOSED, theme.OPEN, theme.BY_HAND)
    options = (
        Switch("rejected", tr("Rejected ones, dashed"), True, tr("Show rejected contours, faint and dashed.")),
        Switch("names", tr("Names"), True, tr("Show the names of contours.")),
    )

    def __init__(self, view: pg.ViewBox, requests: Requests) -> None:
        super().__init__(view, requests)
        self._hovered = Curves(theme.HOVERED, 3.7, width=7.0, halo=0.0)
        self._chosen = Curves(theme.CHOSEN, 3.8, width=6.5, halo=8.5)
        self._rejected = Curves(theme.REJECTED, 3.9, width=1.8, halo=2.8, dashed=True)
        self._curves = {True: Curves(theme.CLOSED, 4.0), False: Curves(theme.OPEN, 4.1)}
        self._edited = {True: Curves(theme.CLOSED, 4.12), False: Curves(theme.OPEN, 4.11)}
        self._own: dict[str, Curves] = {}
        self._bridges = Curves(theme.BRIDGE, 4.2, dashed=True)
        self._by_hand = Curves(theme.BY_HAND, 4.25, halo=0.0, dashed=True)
        self._names = Names(5.7)
        self._junctions = Markers(size=8.0, symbol="d", pen=pg.mkPen(theme.HALO), brush=pg.mkBrush(theme.JUNCTION))
        self._junctions.setZValue(5.5)
        self.add(self._hovered, self._chosen, self._rejected, *self._curves.values(), *self._edited.values())
        self.add(self._bridges, self._by_hand)
        self.add(self._names, self._junctions)

    @property
    def counts(self) -> tuple[int, int]:
        """Numbers of closed and of open contours that are not rejected."""
        counted = [item.contour.closed for item in self.scene.contours.items if not item.reviewed.rejected]
        return sum(counted), len(counted) - sum(counted)

    @property
    def rejected(self) -> int:
        """Number of rejected contours shown."""
        return self._rejected.count

    @property
    def bridged(self) -> int:
        """Number of bridged gaps shown."""
        return self._bridges.count

    @property
    def drawn_by_hand(self) -> int:
        """Number of stretches drawn by hand that are shown."""
        return self._by_hand.count

    def show_or_hide(self) -> None:
        """Show or hide all items."""
        super().show_or_hide()
        self._names.set_shown(self.shown and bool(self.chosen["names"]))

    def follow_choice(self, name: str) -> None:
        """Show or hide rejected contours or names."""
        if name == "rejected":
            self._show_rejected()
        else:
            self.show_or_hide()

    def follow(self, before: Scene) -> None:
        """Show other contours, or another selection."""
        scene = self.scene
        other = scene.contours is not before.contours
        if other:
            self._show()
        if other or scene.selected_contours is not before.selected_contours:
            self._chosen.show(_paths([item for item in scene.contours.items if item.key in scene.selected_contours]))
        if other or scene.hovered_contour != before.hovered_contour:
            self._hovered.show(_paths([item for item in scene.contours.items if item.key == scene.hovered_contour]))

    def _show(self) -> None:
        items = self.scene.contours.items
        counting = [item for item in items if not item.reviewed.rejected]
        for closed, curves in self._curves.items():
            seen = [item for item in counting if item.contour.closed == closed and not item.contour.color]
            curves.show(_paths([item for item in seen if not item.contour.by_hand]))
            self._edited[closed].show(_paths([item for item in seen if item.contour.by_hand]))
        self._show_own([item for item in counting if item.contour.color])
        self._show_rejected()
        result = self.scene.contours.result
        self._bridges.show([bridge.points for bridge in result.bridges] if result is not None else [])
        self._by_hand.show([stretch for item in counting for stretch in item.contour.by_hand])
        named = [item.contour for item in counting if item.contour.name]
        self._names.show([(middle(c), c.name, c.color or "#ffffff") for c in named])
        ends = [item.contour.points[end] for item in items for end in (0, -1) if item.contour.junctions[end]]
        x, y = to_xy(np.unique(np.array(ends, dtype=float).reshape(-1, 2), axis=0))
        self._junctions.setData(x=x, y=y)

    def _show_rejected(self) -> None:
        rejected = [item for item in self.scene.contours.items if item.reviewed.rejected]
        self._rejected.show(_paths(rejected) if self.chosen["rejected"] else [])

    def _show_own(self, items: Sequence[Item]) -> None:
        """Draw the contours of each color that the user has chosen by one item."""
        for color in {item.contour.color for item in items} - self._own.keys():
            curves = self._own[color] = Curves(color, 4.15)
            if self.scene.image is not None:
                curves.use_shape(self.scene.image.shape)
            curves.set_shown(self.shown)
            curves.setOpacity(self.opacity)
            self.add(curves)
        for color, curves in self._own.items():
            curves.show(_paths([item for item in items if item.contour.color == color]))


def _paths(items: Sequence[Item]) -> list[np.ndarray]:
    return [item.contour.path for item in items]
