"""The layers of the contours and of the ground truth."""

from __future__ import annotations

import math
from collections.abc import Sequence

from cpm_app.model.text.language import tr
from cpm_app.session.scene import Scene
from cpm_app.views.items.curves import Curves
from cpm_app.views.layers.layer import Layer, LegendEntry
from cpm_app.views.theme import theme
from cpm_core import Truth

_SHORT_FRACTION = 0.06
"""Length of a short open contour, as a fraction of the diagonal of the image."""

_SHORT_OPACITY = 0.6
"""Opacity of short open contours, so that noise and texture recede behind outlines."""


class ContourLayer(Layer):
    """Shows the contours of the run in thin lines of one neutral color; short open ones recede.

    Selected ones have a bright rim. Where a contour bridges a gap, its line is dashed.
    """

    name = "contours"
    title = tr("Contours")
    tip = tr("Closed and open contours of the run.")
    shortcut = "Alt+4"
    colors = (theme.CONTOUR_COLOR,)

    def create_items(self) -> None:
        """Create the items of the layer."""
        self._hovered = Curves(theme.HOVERED_COLOR, 3.7, width=7.0, halo=0.0)
        self._selected = Curves(theme.SELECTED_COLOR, 3.8, width=6.5, halo=8.5)
        self.short = Curves(theme.CONTOUR_COLOR, 3.95, width=1.0, halo=0.0)
        self._curves = Curves(theme.CONTOUR_COLOR, 4.1, width=1.5, halo=3.2)
        self.bridges = Curves(theme.CANVAS_HALO_COLOR, 4.2, width=1.5, halo=0.0, dashed=True)
        self.add_items(self._hovered, self._selected, self.short, self._curves, self.bridges)
        self.apply_opacity()

    def legend_entries(self) -> Sequence[LegendEntry]:
        """Return the entries of the contours, in a slice of the sections of the surface, and of gaps."""
        text, tip = tr("sections"), tr("What this slice shows of the surface that particles have found.")
        if self.scene.whole is None:
            text = tr("contours")
            tip = tr("Lines that particles have found, closed and open ones; short open ones are pale.")
        gaps = tr("Gaps in edges that contours bridge.")
        return [
            LegendEntry(len(self.scene.contours), text, tip, theme.CONTOUR_COLOR),
            LegendEntry(self.bridges.count, tr("bridges"), gaps, theme.CONTOUR_COLOR, "dashed"),
        ]

    def apply_opacity(self) -> None:
        """Set the opacity; short open contours are paler."""
        super().apply_opacity()
        self.short.setOpacity(_SHORT_OPACITY * self.opacity)

    def show_scene(self, before: Scene) -> None:
        """Show other contours, or another selection."""
        scene, contours = self.scene, self.scene.contours
        other = contours is not before.contours
        if other:
            self._show_contours()
        if other or scene.selected_contours is not before.selected_contours:
            self._selected.show_paths(
                [contours[index].path for index in scene.selected_contours if index < len(contours)]
            )
        if other or scene.hovered_contour != before.hovered_contour:
            hovered = scene.hovered_contour
            self._hovered.show_paths([] if hovered is None or hovered >= len(contours) else [contours[hovered].path])

    def _show_contours(self) -> None:
        contours, image, result = self.scene.contours, self.scene.image, self.scene.result
        least = 0.0 if image is None else _SHORT_FRACTION * math.hypot(*image.shape)
        short = [not contour.closed and contour.length < least for contour in contours]
        for curves, pale in ((self.short, True), (self._curves, False)):
            curves.show_paths([one.path for one, recedes in zip(contours, short, strict=True) if recedes == pale])
        self.bridges.show_paths([bridge.points for bridge in result.bridges] if result is not None else [])


class TruthLayer(Layer):
    """Shows the ground truth, and the differences by color and line style."""

    name = "truth"
    title = tr("Ground truth")
    tip = tr("True boundaries; missing contours dashed, wrong contours wide.")
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
