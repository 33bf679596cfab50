"""Copying contours and the view."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from PySide6.QtCore import QMimeData
from PySide6.QtWidgets import QApplication

from app.model.state.situation import has_contours, has_image
from app.model.text.language import tr
from app.session.worker.commands.run import Copied
from app.views.widgets.action_spec import ActionSpec
from app.views.window.feature import Feature, FeatureContext

_KINDS = (
    ("copy_svg", tr("Copy contours as &SVG"), ".svg", ("Ctrl+C",)),
    ("copy_csv", tr("Copy contours as &CSV"), ".csv", ()),
    ("copy_geojson", tr("Copy contours as &GeoJSON"), ".geojson", ()),
)

_MIME = {".svg": "image/svg+xml", ".csv": "text/csv", ".geojson": "application/geo+json"}


class ClipboardFeature(Feature):
    """Copies for other programs."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        context.session.listen(Copied, self._put_contours)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Contours in several formats, and the view."""
        contours = [
            ActionSpec(name=name, menu="Edit", text=text, do=partial(self.context.session.copy_contours, suffix),
                       shortcuts=shortcuts, tip=tr("Copy the contours to the clipboard."),
                       gap=suffix == ".svg", when=has_contours)
            for name, text, suffix, shortcuts in _KINDS
        ]  # fmt: skip
        view = ActionSpec(name="copy_view", menu="Edit", text=tr("Copy &view as image"), do=self._copy_view,
                          shortcuts=("Ctrl+Shift+P",),
                          tip=tr("Copy the visible part of the image with its overlays to the clipboard."),
                          when=has_image)  # fmt: skip
        return (*contours, view)

    def _copy_view(self) -> None:
        QApplication.clipboard().setImage(self.context.canvas_area.canvas.grab().toImage())
        self.context.session.say(tr("The view is on the clipboard."))

    def _put_contours(self, report: Copied) -> None:
        data = QMimeData()
        data.setText(report.content.decode())  # most programs take text only
        data.setData(_MIME[report.suffix], report.content)
        QApplication.clipboard().setMimeData(data)
        self.context.session.say(tr("The contours are on the clipboard."))
