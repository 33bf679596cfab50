"""Export of the contours to files and to the clipboard."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from PySide6.QtCore import QMimeData
from PySide6.QtWidgets import QApplication

from app.model.document.modes import needs_start
from app.model.export.order import ExportOrder, can_be_exported
from app.model.state.situation import Situation, has_contours, has_image, has_volume
from app.model.text.language import tr
from app.session.exchange.messages import Exported, Opened
from app.session.features.skeleton import description_of
from app.session.signals import EXPORTING
from app.session.worker.commands import Copied
from app.views.export.dialog import ExportDialog
from app.views.export.surface import SurfaceDialog
from app.views.widgets.action_spec import ActionSpec
from app.views.window.feature import Feature, FeatureContext
from cpm_core.formats import FOR_SKELETONS, WRITABLE, suffix_of

_SUFFIX = "files/export_suffix"
"""Preference: suffix of the last export."""


class ExportFeature(Feature):
    """Export of the contours to files."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self._exported: Path | None = None
        self._order = ExportOrder()
        self.dialog: ExportDialog | SurfaceDialog | None = None
        context.session.listen(Opened, self._forget)
        context.session.listen(Exported, self._remember)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Export, and export again to the same file."""
        return (
            ActionSpec(name="export", menu="File", text=tr("&Export contours…"), short=tr("Export"), do=self._export,
                       shortcuts=("Ctrl+E", "Ctrl+Shift+K"), tip=tr("Export the contours, or the skeleton, to a file."),
                       icon="export", gap=True, when=_can_export, worded=_export_text),
            ActionSpec(name="export_again", menu="File", text=tr("Export a&gain"), do=self._export_again,
                       shortcuts=("Ctrl+Shift+E",), tip=tr("Export the contours to the last file again."),
                       when=lambda situation: _can_export(situation) and self._exported is not None,
                       worded=lambda situation: self._again_text()),
        )  # fmt: skip

    def _again_text(self) -> str:
        if self._exported is None:
            return tr("Export a&gain")
        return tr("Export a&gain to {name}").format(name=self._exported.name.replace("&", "&&"))

    def _export(self) -> None:
        session, review = self.context.session, self.context.workspace.review
        image, preferences = session.document.image, self.context.preferences
        if image is None or self.dialog is not None:
            return
        if session.scene.slices is not None:
            self._export_surface(Path(image.path))
            return
        suffix = suffix_of(self._exported) if self._exported else preferences.get(_SUFFIX, ".svg")
        suffix = suffix if suffix in WRITABLE else ".svg"
        kind = "contours"
        if session.scene.skeleton is not None:
            kind, suffix = "skeleton", suffix if suffix in FOR_SKELETONS else ".svg"
        place = self.context.files.begin("export") / f"{Path(image.name).stem}_{kind}"
        selected = frozenset(item.measures.number for item in review.chosen)
        self._open(ExportDialog(self.context.window, session, selected, place, suffix))

    def _export_surface(self, image: Path) -> None:
        """Ask where and as what to write the surface of a volume."""
        session = self.context.session
        figures = session.status.surface
        objects = sum(not item.hidden for item in session.document.objects.items)
        volume = session.image
        if volume is not None and session.scene.skeleton is not None:
            lines = description_of(session.scene.skeleton, volume)
            place = self.context.files.begin("export") / f"{image.name.partition('.')[0]}_lines"
            self._open(SurfaceDialog(self.context.window, None, 0, volume, image, place, ".swc", lines))
            return
        if volume is None or (figures is None and not objects):
            return
        place = self.context.files.begin("export") / f"{image.name.partition('.')[0]}_surface"
        suffix = suffix_of(self._exported) if self._exported else ".ply"
        self._open(SurfaceDialog(self.context.window, figures, objects, volume, image, place, suffix))

    def _open(self, dialog: ExportDialog | SurfaceDialog) -> None:
        self.dialog = dialog
        dialog.ordered.connect(self._write)
        dialog.finished.connect(self._end)
        dialog.open()

    def _write(self, path: Path, order: ExportOrder) -> None:
        self._order = order
        self.context.session.export(path, order)

    def _end(self) -> None:
        self.dialog = None

    def _export_again(self) -> None:
        if self._exported is not None:
            self.context.session.export(self._exported, self._order)

    def _forget(self, _: Opened) -> None:
        self._exported, self._order = None, ExportOrder()
        if self.dialog is not None:
            self.dialog.reject()

    def _remember(self, exported: Exported) -> None:
        self.context.files.remember("export", exported.path)
        if exported.counts is None:  # an animation, or a strip
            return
        self._exported = exported.path
        self.context.preferences.put(_SUFFIX, suffix_of(exported.path))
        self.context.refresh()


def _can_export(situation: Situation) -> bool:
    return has_contours(situation) or situation.status.surface is not None or can_be_exported(situation.document)


def _export_text(situation: Situation) -> str:
    if has_volume(situation) and situation.document.mode != "skeleton":
        return tr("&Export surface…")
    return tr("&Export contours…") if needs_start(situation.document.mode) else tr("&Export skeleton…")


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
        self.context.session.say(tr("The view is on the clipboard."), topic=EXPORTING)

    def _put_contours(self, report: Copied) -> None:
        data = QMimeData()
        data.setText(report.content.decode())  # most programs take text only
        data.setData(_MIME[report.suffix], report.content)
        QApplication.clipboard().setMimeData(data)
        self.context.session.say(tr("The contours are on the clipboard."), topic=EXPORTING)
