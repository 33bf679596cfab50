"""The layer of the ground truth: its boundaries, and where contours are missing or wrong."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray

from app.model.text.language import tr
from app.session.scene import Scene
from app.views.canvas.items.curves import Curves
from app.views.canvas.layers.layer import Layer, Requests
from app.views.canvas.layers.legend_entry import LegendEntry
from app.views.theme import theme
from cpm_core.contours.ground_truth import Truth


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
