"""The comparison with a ground truth."""

from __future__ import annotations

from app.model.display.differences import Difference
from app.model.state.situation import Situation, has_image
from app.model.text.language import tr
from app.views.panels.truth import TruthPanel
from app.views.widgets.actions import ActionSpec
from app.views.window.dialogs import ALL_FILES, Files
from app.views.window.docks import Panel
from app.views.window.window import Feature, MainWindow
from cpm_core.formats import CONTOURS_READABLE, READABLE, SURFACES_READABLE

_SPAN = 48.0
"""Minimum side of the part of the image that is shown around a difference [px]."""


class TruthFeature(Feature):
    """Comparison of the contours with a ground truth."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.truth = truth = window.workspace.truth
        self.panel = TruthPanel(truth, self._load, self._jump)
        self.panels = (
            Panel("truth", "Ground truth", self.panel, tab="settings", shown=False, shortcut="F12"),
        )  # fmt: skip
        truth.changed.connect(window.refresh)
        truth.compared.connect(window.refresh)

        def differs(_: Situation) -> bool:
            return truth.verified is not None and bool(truth.verified.differences)

        self.actions = (
            ActionSpec("load_truth", "Run", "Compare with ground &truth…",
                       "Load a mask or contours as ground truth, and measure the agreement.", self._load,
                       "Ctrl+Shift+T", gap=True, when=has_image),
            ActionSpec("worst_place", "Run", "Sho&w largest difference",
                       "Show where contours and ground truth are farthest apart.", self.panel.jump_to_worst,
                       when=differs),
            ActionSpec("next_place", "Run", "Show next differen&ce",
                       "Show the next difference between contours and ground truth.", self.panel.jump_to_next,
                       "Shift+W", when=differs),
            ActionSpec("forget_truth", "Run", "Remo&ve ground truth", "Remove the ground truth.", truth.forget,
                       when=lambda _: truth.truth is not None),
        )  # fmt: skip

    def close(self) -> bool:
        """Stop the thread of comparisons."""
        self.truth.close()
        return True

    def _load(self) -> None:
        self.window.docks.reveal("truth")
        kinds = (
            (Files(tr("Label volumes and surfaces"), (*READABLE, *SURFACES_READABLE)), ALL_FILES)
            if self.truth.in_volume
            else (
                Files(tr("Masks and contours"), tuple(dict.fromkeys((*READABLE, *CONTOURS_READABLE)))),
                Files(tr("Masks"), tuple(READABLE)),
                Files(tr("Contours"), tuple(CONTOURS_READABLE)),
                ALL_FILES,
            )
        )
        chosen = self.window.files.ask_for_file("truth", tr("Compare with ground truth"), kinds)
        if chosen is not None:
            self.truth.load(str(chosen))

    def _jump(self, difference: Difference) -> None:
        slices = self.window.workspace.slices
        slices.through(difference.place)
        points = difference.points if slices.now is None else slices.now.current.flattened(difference.points)
        low, high = points.min(axis=0), points.max(axis=0)
        span = max(_SPAN, 1.4 * float((high - low).max()))
        row, col = (0.5 * (low + high)).tolist()
        if slices.now is not None:
            row, col = slices.now.current.within(difference.place)
        self.window.canvas_area.canvas.look_at((row, col), span)
