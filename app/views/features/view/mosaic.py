"""The mosaic of two parameters."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QRectF

from app.model.display.display_image import DisplayImage
from app.model.state.situation import has_image
from app.model.text.language import tr
from app.views.canvas.coordinates import image_rectangle
from app.views.mosaic import MosaicDialog
from app.views.widgets.action_spec import ActionSpec
from app.views.window.feature import Feature, FeatureContext

_LEAST_SEEN = 0.02
"""Fraction of the image that must be visible for the tiles to show only the visible part."""


class MosaicFeature(Feature):
    """A sweep of two parameters."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.sweep = context.workspace.sweep
        self.dialog: MosaicDialog | None = None

    def action_specs(self) -> Sequence[ActionSpec]:
        """Open it."""
        return (
            ActionSpec(name="mosaic", menu="Run", text=tr("&Mosaic of two parameters…"), do=self.open,
                       shortcuts=("Ctrl+M",),
                       tip=tr("Compare runs with several values of two parameters and choose the best."),
                       gap=True, when=has_image),
        )  # fmt: skip

    def open(self) -> None:
        """Open the dialog, or bring it to the front; tiles show the visible part of the image."""
        display = self.context.session.scene.display
        if self.dialog is None and display is not None:
            self.dialog = MosaicDialog(
                self.context.window, self.context.session, self.sweep, display, self._crop(display)
            )
            self.dialog.finished.connect(self._forget)
        if self.dialog is not None:
            self.dialog.show()
            self.dialog.raise_()
            self.dialog.activateWindow()

    def close(self) -> bool:
        """Close the dialog and cancel its runs."""
        if self.dialog is not None:
            self.dialog.close()
        self.sweep.cancel()
        return True

    def _crop(self, display: DisplayImage) -> QRectF:
        whole = image_rectangle(display.shape)
        seen = self.context.canvas_area.canvas.view.viewRect().intersected(whole)
        enough = seen.width() * seen.height() > _LEAST_SEEN * whole.width() * whole.height()
        return seen if enough else whole

    def _forget(self, _: int) -> None:
        self.dialog = None
