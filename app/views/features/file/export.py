"""Exporting the contours."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from app.model.state.situation import has_contours
from app.model.text.language import tr
from app.session.exchange.messages import Exported, Opened
from app.views.widgets.action_spec import ActionSpec
from app.views.window.dialogs import ask_for_export
from app.views.window.feature import Feature, FeatureContext

_FOLDER = "files/exports"
"""Preference: folder of the last export."""


class ExportFeature(Feature):
    """Export of the contours to files."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self._exported: Path | None = None
        context.session.listen(Opened, self._forget)
        context.session.listen(Exported, self._remember)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Export, and export again to the same file."""
        return (
            ActionSpec(name="export", menu="File", text=tr("&Export contours…"), short=tr("Export"), do=self._export,
                       shortcuts=("Ctrl+E",), tip=tr("Export the contours to a file."), icon="export", gap=True,
                       when=has_contours),
            ActionSpec(name="export_again", menu="File", text=tr("Export a&gain"), do=self._export_again,
                       shortcuts=("Ctrl+Shift+E",), tip=tr("Export the contours to the last file again."),
                       when=lambda situation: has_contours(situation) and self._exported is not None,
                       worded=lambda situation: self._again_text()),
        )  # fmt: skip

    def _again_text(self) -> str:
        if self._exported is None:
            return tr("Export a&gain")
        return tr("Export a&gain to {name}").format(name=self._exported.name.replace("&", "&&"))

    def _export(self) -> None:
        image, last = self.context.session.document.image, self._exported
        suffix = "".join(last.suffixes[-1:]) if last else ".svg"
        stem = Path(image.name).stem if image else "contours"
        folder = Path(self.context.preferences.get(_FOLDER, ""))
        chosen = ask_for_export(self.context.window, str(folder / f"{stem}_contours{suffix}"))
        if chosen:
            self.context.session.export(chosen)

    def _export_again(self) -> None:
        if self._exported is not None:
            self.context.session.export(self._exported)

    def _forget(self, _: Opened) -> None:
        self._exported = None

    def _remember(self, exported: Exported) -> None:
        self._exported = exported.path
        self.context.preferences.put(_FOLDER, str(exported.path.absolute().parent))
        self.context.refresh()
