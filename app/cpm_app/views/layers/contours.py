"""The layers of the contours and of the ground truth."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pyqtgraph as pg

from cpm_app.model.text.language import tr
from cpm_app.session.scene import ContourItem, Scene
from cpm_app.views.items.curves import Curves
from cpm_app.views.items.item import Markers, TextLabels
from cpm_app.views.layers.layer import Layer, LegendEntry, Sign, SwitchOption
from cpm_app.views.theme import theme
from cpm_core import Truth
from cpm_core.contours import contour_midpoint
from cpm_core.numerics import Array

_SHORT_FRACTION = 0.06
"""Length of a short open contour, as a fraction of the diagonal of the image."""

_SHORT_OPACITY = 0.6
"""Opacity of short open contours, so that noise and texture recede behind outlines."""

_CONTOUR_KINDS: tuple[tuple[str, str, str, Sign], ...] = (
    (tr("found"), tr("Lines that particles have found, closed and open ones; short open ones are pale."),
     theme.CONTOUR_COLOR, "line"),
    (tr("bridged"), tr("Gaps in edges that contours bridge."), theme.CONTOUR_COLOR, "dashed"),
    (tr("by hand"), tr("Segments drawn by hand."), theme.BY_HAND_COLOR, "dashed"),
    (tr("kept"), tr("Contours that are kept through all slider changes and runs."), theme.CONTOUR_COLOR, "check"),
    (tr("rejected"), tr("Contours that are not exported."), theme.REJECTED_COLOR, "dashed"),
)  # fmt: skip
"""Text, tip, color and sign of each kind of contour in the legend."""


class ContourLayer(Layer):
    """Shows contours as reviewed, in thin lines of one neutral color; short open ones recede.

    Rejected contours are faint and dashed or hidden, selected ones have a bright rim. Where a contour bridges a gap,
    its line is dashed.
    """

    name = "contours"
    title = tr("Contours")
    tip = tr("Closed, open, and drawn by hand.")
    shortcut = "Alt+4"
    shown_in_slices = True
    colors = (theme.CONTOUR_COLOR, theme.BY_HAND_COLOR)
    options = (
        SwitchOption("rejected", tr("Rejected ones, dashed"), True, tr("Show rejected contours, faint and dashed.")),
        SwitchOption("names", tr("Names"), True, tr("Show the names of contours.")),
        SwitchOption("junctions", tr("Junctions"), False, tr("Mark the points where contours meet.")),
    )

    def create_items(self) -> None:
        """Create the items of the layer."""
        self._hovered = Curves(theme.HOVERED_COLOR, 3.7, width=7.0, halo=0.0)
        self._selected = Curves(theme.SELECTED_COLOR, 3.8, width=6.5, halo=8.5)
        self.rejected = Curves(theme.REJECTED_COLOR, 3.9, width=1.2, halo=0.0, dashed=True)
        self.short = Curves(theme.CONTOUR_COLOR, 3.95, width=1.0, halo=0.0)
        self._curves, self._colored = (
            Curves(theme.CONTOUR_COLOR, 4.1, width=1.5, halo=3.2),
            Curves(theme.CONTOUR_COLOR, 4.12),
        )
        self.bridges = Curves(theme.CANVAS_HALO_COLOR, 4.2, width=1.5, halo=0.0, dashed=True)
        self.by_hand = Curves(theme.BY_HAND_COLOR, 4.25, halo=0.0, dashed=True)
        self._names = TextLabels(5.7)
        self.junctions = Markers(
            5.5, size=8.0, symbol="d", pen=pg.mkPen(theme.CANVAS_HALO_COLOR), brush=pg.mkBrush(theme.JUNCTION_COLOR)
        )
        self.add_items(
            self._hovered, self._selected, self.short, self._curves, self._colored, self.bridges, self.by_hand
        )
        self.add_items(self.rejected, switch="rejected")
        self.add_items(self._names, switch="names")
        self.add_items(self.junctions, switch="junctions")
        self.apply_visibility()
        self.apply_opacity()

    @property
    def counts(self) -> tuple[int, int]:
        """Numbers of closed and open contours that are not rejected."""
        closed = [item.contour.closed for item in self._counted_items]
        return sum(closed), len(closed) - sum(closed)

    def legend_entries(self) -> Sequence[LegendEntry]:
        """Return an entry for each kind of contour."""
        kept = sum(item.reviewed.verdict == "kept" for item in self.scene.contours.items)
        rejected = self.rejected.count if self.option_values["rejected"] else 0
        counts = (sum(self.counts), self.bridges.count, self.by_hand.count, kept, rejected)
        return [LegendEntry(count, *kind) for count, kind in zip(counts, _CONTOUR_KINDS, strict=True)]

    def apply_opacity(self) -> None:
        """Set the opacity; short open contours are paler."""
        super().apply_opacity()
        self.short.setOpacity(_SHORT_OPACITY * self.opacity)

    def show_scene(self, before: Scene) -> None:
        """Show other contours, or another selection."""
        scene = self.scene
        other = scene.contours is not before.contours
        if other:
            self._show_contours()
        if other or scene.selected_contours is not before.selected_contours:
            self._selected.show_paths(
                _contour_paths([item for item in scene.contours.items if item.key in scene.selected_contours])
            )
        if other or scene.hovered_contour != before.hovered_contour:
            self._hovered.show_paths(
                _contour_paths([item for item in scene.contours.items if item.key == scene.hovered_contour])
            )

    def _show_contours(self) -> None:
        items, counting = self.scene.contours.items, self._counted_items
        self.rejected.show_paths(_contour_paths([item for item in items if item.reviewed.rejected]))
        for curves in (self.short, self._curves):
            curves.show_paths(_contour_paths([item for item in counting if self._curves_for(item) is curves]))
        other = [item for item in counting if self._curves_for(item) is self._colored]
        self._colored.show_paths(_contour_paths(other), [item.contour.color or theme.CONTOUR_COLOR for item in other])
        result = self.scene.contours.result
        self.bridges.show_paths([bridge.points for bridge in result.bridges] if result is not None else [])
        self.by_hand.show_paths([stretch for item in counting for stretch in item.contour.by_hand])
        named = [item.contour for item in counting if item.contour.name]
        self._names.show_texts([(contour_midpoint(c), c.name, c.color or "#ffffff") for c in named])
        ends = [item.contour.points[end] for item in items for end in (0, -1) if item.contour.junctions[end]]
        self.junctions.show_markers({(float(row), float(col)) for row, col in ends})

    def _curves_for(self, item: ContourItem) -> Curves:
        """Return the item that draws a contour: for colored or hand-edited, short open unnamed, or other contours."""
        contour, image = item.contour, self.scene.image
        if contour.color or contour.by_hand:
            return self._colored
        wanted = contour.closed or contour.name or item.reviewed.verdict == "kept"
        if wanted or image is None or contour.length >= _SHORT_FRACTION * math.hypot(*image.shape):
            return self._curves
        return self.short

    @property
    def _counted_items(self) -> list[ContourItem]:
        """Contours that are not rejected."""
        return [item for item in self.scene.contours.items if not item.reviewed.rejected]


def _contour_paths(items: Sequence[ContourItem]) -> list[Array]:
    return [item.contour.path for item in items]


class TruthLayer(Layer):
    """Shows the ground truth, and the differences by color and line style."""

    name = "truth"
    title = tr("Ground truth")
    tip = tr("True boundaries; missing contours dashed, wrong contours wide.")
    shown_in_slices = True
    colors = (theme.TRUTH_COLOR, theme.MISSING_COLOR, theme.WRONG_COLOR)

    def create_items(self) -> None:
        """Create the items of the layer."""
        self._boundary = Curves(theme.TRUTH_COLOR, 3.95, width=1.6, halo=0.0)
        self._missing = Curves(theme.MISSING_COLOR, 4.3, width=3.4, halo=5.0, dashed=True)
        self._wrong = Curves(theme.WRONG_COLOR, 4.4, width=5.0, halo=7.0)
        self.add_items(self._boundary, self._missing, self._wrong)

    @property
    def counts(self) -> tuple[int, int, int]:
        """Numbers of boundaries, missing pieces and wrong pieces shown."""
        return self._boundary.count, self._missing.count, self._wrong.count

    def legend_entries(self) -> Sequence[LegendEntry]:
        """Return the entries of boundaries and differences."""
        true, missing, wrong = self.counts
        return (
            LegendEntry(true, tr("true"), tr("Boundaries of the ground truth."), theme.TRUTH_COLOR),
            LegendEntry(
                missing, tr("missing"), tr("True boundaries without a contour."), theme.MISSING_COLOR, "dashed"
            ),
            LegendEntry(wrong, tr("wrong"), tr("Contours away from true boundaries."), theme.WRONG_COLOR),
        )

    def show_scene(self, before: Scene) -> None:
        """Show another ground truth, or other differences."""
        truth = self.scene.truth
        if truth is not before.truth:
            self._boundary.show_paths([contour.path for contour in truth.contours] if isinstance(truth, Truth) else [])
        if self.scene.differences is not before.differences:
            for curves, kind in ((self._missing, "missing"), (self._wrong, "wrong")):
                curves.show_paths([each.points for each in self.scene.differences if each.kind == kind])
