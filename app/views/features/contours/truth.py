"""The comparison with a ground truth."""

from __future__ import annotations

from collections.abc import Sequence

from app.model.display.truth.differences import Difference
from app.model.state.situation import Situation, has_image
from app.model.text.language import tr
from app.views.panels.contour_table.truth_panel import TruthPanel
from app.views.widgets.action_spec import ActionSpec
from app.views.window.feature import Feature, FeatureContext, Panel
from app.views.window.file_dialogs import Files, all_files
from cpm_core.formats import READABLE, SURFACES_READABLE
from cpm_core.formats.contours.reading.contour_file import CONTOURS_READABLE

_SPAN = 48.0
"""Minimum side of the part of the image that is shown around a difference [px]."""


class TruthFeature(Feature):
    """Comparison of the contours with a ground truth."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.truth = context.workspace.truth
        self.panel = TruthPanel(self.truth)
        self.panel.load_requested.connect(self._load)
        self.panel.jump_requested.connect(self._jump)
        self.truth.changed.connect(context.refresh)
        self.truth.compared.connect(context.refresh)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Load, show differences, remove."""
        return (
            ActionSpec(name="load_truth", menu="Contours", text=tr("Compare with ground &truth…"), do=self._load,
                       shortcuts=("Ctrl+Shift+T",),
                       tip=tr("Load a mask or contours as ground truth, and measure the agreement."),
                       gap=True, when=has_image),
            ActionSpec(name="worst_place", menu="Contours", text=tr("Sho&w largest difference"),
                       do=self.panel.jump_to_worst,
                       tip=tr("Show where contours and ground truth are farthest apart."), when=self._differs),
            ActionSpec(name="next_place", menu="Contours", text=tr("Show next differen&ce"),
                       do=self.panel.jump_to_next, shortcuts=("Shift+W",),
                       tip=tr("Show the next difference between contours and ground truth."), when=self._differs),
            ActionSpec(name="forget_truth", menu="Contours", text=tr("Remo&ve ground truth"), do=self.truth.forget,
                       tip=tr("Remove the ground truth."), when=lambda situation: self.truth.truth is not None),
        )  # fmt: skip

    def panels(self) -> Sequence[Panel]:
        """The measures."""
        return (
            Panel(name="truth", title=tr("Ground truth"), widget=self.panel, tab="settings", shown=False,
                  shortcut="F12"),
        )  # fmt: skip

    def close(self) -> bool:
        """Stop the thread of comparisons."""
        self.truth.close()
        return True

    def _differs(self, situation: Situation) -> bool:
        return self.truth.verified is not None and bool(self.truth.verified.differences)

    def _load(self) -> None:
        self.context.reveal("truth")
        kinds = (
            (Files(tr("Label volumes and surfaces"), (*READABLE, *SURFACES_READABLE)), all_files())
            if self.truth.in_volume
            else (
                Files(tr("Masks and contours"), tuple(dict.fromkeys((*READABLE, *CONTOURS_READABLE)))),
                Files(tr("Masks"), tuple(READABLE)),
                Files(tr("Contours"), tuple(CONTOURS_READABLE)),
                all_files(),
            )
        )
        chosen = self.context.files.ask_for_file("truth", tr("Compare with ground truth"), kinds)
        if chosen is not None:
            self.truth.load(str(chosen))

    def _jump(self, difference: Difference) -> None:
        slices = self.context.workspace.slices
        slices.through(difference.place)
        points = difference.points if slices.now is None else slices.now.current.flattened(difference.points)
        low, high = points.min(axis=0), points.max(axis=0)
        span = max(_SPAN, 1.4 * float((high - low).max()))
        row, col = (0.5 * (low + high)).tolist()
        if slices.now is not None:
            row, col = slices.now.current.within(difference.place)
        self.context.canvas_area.canvas.look_at((row, col), span)
