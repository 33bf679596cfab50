"""The size of a pixel or of a voxel, set by hand where a file does not tell it."""

from __future__ import annotations

from collections.abc import Sequence

from app.model.display.lengths import size_text
from app.model.document import edits
from app.model.state.situation import Situation, has_image, has_volume
from app.model.text.language import tr
from app.session.exchange.messages import Opened
from app.views.features.file.offering import OfferingFeature
from app.views.files.pixel_size_dialog import PixelSizeDialog
from app.views.widgets.action_spec import ActionSpec
from app.views.window.feature import FeatureContext


class PixelSizeFeature(OfferingFeature):
    """Asks for the size, offers to where a volume tells none, and makes it an edit that can be undone."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.dialog: PixelSizeDialog | None = None
        self._told: tuple[tuple[float, ...], str | None] | None = None

    def action_specs(self) -> Sequence[ActionSpec]:
        """Ask for the size."""
        return (
            ActionSpec(name="pixel_size", menu="Edit", text=tr("Size of a p&ixel…"), do=self.ask, gap=True,
                       tip=tr("Set how far apart rows and columns are, and planes of a volume, and in which unit."),
                       when=has_image, worded=_text),
        )  # fmt: skip

    def offer(self, opened: Opened) -> None:
        """Offer to set the size where a volume tells none: the particles take its voxels for cubes."""
        parts, ndim = opened.parts, opened.image.ndim
        self._told = None if parts is None else (parts.spacing[-ndim:], parts.unit)
        if ndim == 3 and opened.image.unit is None and opened.saved is None:
            sentence = tr("{name} does not tell the size of a voxel: its voxels are taken for cubes. Set the size?")
            self.bar.offer(sentence.format(name=opened.path.name), (tr("Set the size…"), self.ask))

    def ask(self) -> None:
        """Ask for the size."""
        image = self.context.session.document.image
        if image is None:
            return
        told = "" if self._told is None or self._told[1] is None else size_text(*self._told)
        self.dialog = PixelSizeDialog(self.context.window, image.spacing, image.unit, told)
        self.dialog.reset_button.setEnabled(self._told is not None and image.reading.spacing is not None)
        self.dialog.chosen.connect(self._use)
        self.dialog.reset.connect(self._reset)
        self.dialog.finished.connect(self.dialog.deleteLater)
        self.dialog.open()

    def _use(self, spacing: tuple[float, ...], unit: str) -> None:
        name = tr("size of a voxel") if len(spacing) == 3 else tr("size of a pixel")
        self.context.session.edit(name, lambda document: edits.set_pixel_size(document, spacing, unit))

    def _reset(self) -> None:
        if self._told is not None:
            spacing, unit = self._told
            name = tr("size as the file tells")
            self.context.session.edit(name, lambda document: edits.use_told_size(document, spacing, unit))


def _text(situation: Situation) -> str:
    return tr("Size of a vo&xel…") if has_volume(situation) else tr("Size of a p&ixel…")
