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
from app.views.window.dialog_feature import DialogFeature

_LEAST_SEEN = 0.02
"""Fraction of the image that must be visible for the tiles to show only the visible part."""


class MosaicFeature(DialogFeature[MosaicDialog]):
    """A sweep of two parameters."""

    def action_specs(self) -> Sequence[ActionSpec]:
        """Open it."""
        return (
            ActionSpec(name="mosaic", menu="Run", text=tr("&Mosaic of two parameters…"), do=self.open,
                       shortcuts=("Ctrl+M",),
                       tip=tr("Compare runs with several values of two parameters and choose the best."),
                       gap=True, when=has_image),
        )  # fmt: skip

    def made(self) -> MosaicDialog | None:
        """The dialog; tiles show the visible part of the image."""
        context, display = self.context, self.context.session.scene.display
        if display is None:
            return None
        return MosaicDialog(context.window, context.session, context.workspace.sweep, display, self._crop(display))

    def _crop(self, display: DisplayImage) -> QRectF:
        whole = image_rectangle(display.shape)
        seen = self.context.canvas_area.canvas.view.viewRect().intersected(whole)
        enough = seen.width() * seen.height() > _LEAST_SEEN * whole.width() * whole.height()
        return seen if enough else whole
