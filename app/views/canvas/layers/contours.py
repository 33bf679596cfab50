"""The layers of the contours and of the ground truth."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray

from app.model.text.language import tr
from app.session.scene import Item, Scene
from app.views.canvas.items.curves import Curves, Fills
from app.views.canvas.items.item import Markers, Names, to_xy
from app.views.canvas.layers.layer import Amount, Layer, LegendEntry, Requests, Sign, Switch
from app.views.theme import theme
from cpm_core import Truth
from cpm_core.contours import middle

_SHORT = 0.06
"""Length of a short open contour, as a fraction of the diagonal of the image."""

_SHORT_OPACITY = 0.6
"""Opacity of short open contours: noise and texture recede behind outlines."""

_KINDS: tuple[tuple[str, str, str, Sign, float], ...] = (
    (tr("closed"), tr("Contours that bound a region."), theme.CLOSED, "line", 2.2),
    (tr("open"), tr("Contours with two ends; short ones are thin and pale."), theme.OPEN, "line", 1.5),
    (tr("bridged"), tr("Gaps in edges that contours bridge."), theme.BRIDGE, "dashed", 1.4),
    (tr("by hand"), tr("Stretches that were drawn by hand."), theme.BY_HAND, "dashed", 2.0),
    (tr("kept"), tr("Contours that stay through all sliders and runs."), theme.CLOSED, "check", 2.0),
    (tr("rejected"), tr("Contours that are left out of files."), theme.REJECTED, "dashed", 1.2),
)
"""Text, tip, color, sign and width of each kind of contour in the legend."""


class ContourLayer(Layer):
    """Shows contours as reviewed; closed ones lead, long open ones follow, short open ones recede.

    Rejected contours are faint and dashed or hidden, selected ones have a bright rim. Where a contour bridges a gap,
    its line is dashed.
    """

    name = "contours"
    title = tr("Contours")
    tip = tr("Closed, open, and drawn by hand.")
    shortcut = "Alt+4"
    in_slices = True
    colors = (theme.CLOSED, theme.OPEN, theme.BY_HAND)
    options = (
        Amount("fill", tr("Area"), 0.0, 1.0, 0.05, 0.1, tr("Opacity of the areas of closed contours.")),
        Switch("rejected", tr("Rejected ones, dashed"), True, tr("Show rejected contours, faint and dashed.")),
        Switch("names", tr("Names"), True, tr("Show the names of contours.")),
        Switch("junctions", tr("Junctions"), False, tr("Mark the points where contours meet.")),
    )

    def __init__(self, view: pg.ViewBox, requests: Requests) -> None:
        super().__init__(view, requests)
        self._hovered = Curves(theme.HOVERED, 3.7, width=7.0, halo=0.0)
        self._chosen = Curves(theme.CHOSEN, 3.8, width=6.5, halo=8.5)
        self._areas = Fills(2.9)
        self.rejected = Curves(theme.REJECTED, 3.9, width=1.2, halo=0.0, dashed=True)
        self.short = Curves(theme.OPEN, 3.95, width=1.0, halo=0.0)
        self._curves = {True: Curves(theme.CLOSED, 4.1, width=2.2), False: Curves(theme.OPEN, 4.0, width=1.5, halo=2.6)}
        self._other = Curves(theme.CLOSED, 4.12)
        self.bridges = Curves(theme.BRIDGE, 4.2, width=1.3, halo=0.0, dashed=True)
        self.by_hand = Curves(theme.BY_HAND, 4.25, halo=0.0, dashed=True)
        self._names = Names(5.7)
        self.junctions = Markers(size=8.0, symbol="d", pen=pg.mkPen(theme.HALO), brush=pg.mkBrush(theme.JUNCTION))
        self.junctions.setZValue(5.5)
        self.add(self._areas, self._hovered, self._chosen, self.rejected, self.short)
        self.add(*self._curves.values(), self._other, self.bridges, self.by_hand)
        self.add(self._names, self.junctions)
        self.show_or_hide()
        self.fade()

    @property
    def counts(self) -> tuple[int, int]:
        """Numbers of closed and of open contours that are not rejected."""
        counted = [item.contour.closed for item in self.scene.contours.items if not item.reviewed.rejected]
        return sum(counted), len(counted) - sum(counted)

    def legend_entries(self) -> Sequence[LegendEntry]:
        """Kinds of contours."""
        (closed, opened), items = self.counts, self.scene.contours.items
        kept = sum(item.reviewed.verdict == "kept" for item in items)
        counts = (closed, opened, self.bridges.count, self.by_hand.count, kept, self.rejected.count)
        return [LegendEntry(count, *kind) for count, kind in zip(counts, _KINDS, strict=True)]

    def show_or_hide(self) -> None:
        """Show or hide all items."""
        super().show_or_hide()
        self._names.set_shown(self.shown and bool(self.chosen["names"]))
        self.junctions.setVisible(self.shown and bool(self.chosen["junctions"]))

    def fade(self) -> None:
        """Set the opacity; short open contours are paler."""
        super().fade()
        self.short.setOpacity(_SHORT_OPACITY * self.opacity)

    def follow_choice(self, name: str) -> None:
        """Show areas in another opacity, or show or hide rejected contours, names or junctions."""
        if name == "rejected":
            self._show_rejected()
        elif name == "fill":
            self._show_areas()
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
        for curves in (self.short, *self._curves.values()):
            curves.show(_paths([item for item in counting if self._curves_of(item) is curves]))
        other = [item for item in counting if self._curves_of(item) is self._other]
        plain = {True: theme.CLOSED, False: theme.OPEN}
        self._other.show(_paths(other), [item.contour.color or plain[item.contour.closed] for item in other])
        self._show_areas()
        self._show_rejected()
        result = self.scene.contours.result
        self.bridges.show([bridge.points for bridge in result.bridges] if result is not None else [])
        self.by_hand.show([stretch for item in counting for stretch in item.contour.by_hand])
        named = [item.contour for item in counting if item.contour.name]
        self._names.show([(middle(c), c.name, c.color or "#ffffff") for c in named])
        ends = [item.contour.points[end] for item in items for end in (0, -1) if item.contour.junctions[end]]
        x, y = to_xy(np.unique(np.array(ends, dtype=float).reshape(-1, 2), axis=0))
        self.junctions.setData(x=x, y=y)

    def _curves_of(self, item: Item) -> Curves:
        """Where a contour is drawn: with a color or edited by hand, short and without a name, or closed or open."""
        contour, image = item.contour, self.scene.image
        if contour.color or contour.by_hand:
            return self._other
        wanted = contour.closed or contour.name or item.reviewed.verdict == "kept"
        if wanted or image is None or contour.length >= _SHORT * math.hypot(*image.shape):
            return self._curves[contour.closed]
        return self.short

    def _show_areas(self) -> None:
        """Tint the areas that closed contours bound; one inside another bounds a hole, as in the masks."""
        closed = [item for item in self.scene.contours.items if item.contour.closed and not item.reviewed.rejected]
        fill = self.number("fill")
        tints = {item.contour.color or theme.CLOSED for item in closed} if fill else ()
        areas = {
            tint: [item.contour.points for item in closed if (item.contour.color or theme.CLOSED) == tint]
            for tint in sorted(tints)
        }
        self._areas.show([(curves, tint, fill) for tint, curves in areas.items()])

    def _show_rejected(self) -> None:
        rejected = [item for item in self.scene.contours.items if item.reviewed.rejected]
        self.rejected.show(_paths(rejected) if self.chosen["rejected"] else [])


def _paths(items: Sequence[Item]) -> list[np.ndarray]:
    return [item.contour.path for item in items]


class TruthLayer(Layer):
    """Shows the ground truth, and the differences by color and line style."""

    name = "truth"
    title = tr("Ground truth")
    tip = tr("True boundaries; missing contours dashed, wrong contours wide.")
    in_slices = True
    colors = (theme.TRUTH, theme.MISSING, theme.WRONG)

    def __init__(self, view: pg.ViewBox, requests: Requests) -> None:
        super().__init__(view, requests)
        self._boundary = Curves(theme.TRUTH, 3.95, width=1.6, halo=0.0)
        self._missing = Curves(theme.MISSING, 4.3, width=3.4, halo=5.0, dashed=True)
        self._wrong = Curves(theme.WRONG, 4.4, width=5.0, halo=7.0)
        self.add(self._boundary, self._missing, self._wrong)

    @property
    def counts(self) -> tuple[int, int, int]:
        """Numbers of boundaries, missing and wrong pieces shown."""
        return self._boundary.count, self._missing.count, self._wrong.count

    def legend_entries(self) -> Sequence[LegendEntry]:
        """Boundaries and differences."""
        true, missing, wrong = self.counts
        return (
            LegendEntry(true, tr("true"), tr("Boundaries of the ground truth."), theme.TRUTH, "line", 1.6),
            LegendEntry(missing, tr("missing"), tr("True boundaries without a contour."), theme.MISSING, "dashed", 3.4),
            LegendEntry(wrong, tr("wrong"), tr("Contours away from true boundaries."), theme.WRONG, "line", 4.0),
        )

    def follow(self, before: Scene) -> None:
        """Show another truth, or other differences."""
        truth = self.scene.truth
        if truth is not before.truth:
            self._boundary.show([contour.path for contour in truth.contours] if isinstance(truth, Truth) else [])
        if self.scene.differences is not before.differences:
            self._missing.show(self._pieces("missing"))
            self._wrong.show(self._pieces("wrong"))

    def _pieces(self, kind: Literal["missing", "wrong"]) -> list[NDArray[np.float64]]:
        return [difference.points for difference in self.scene.differences if difference.kind == kind]
