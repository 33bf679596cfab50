"""A file that holds several images: as one volume or one of them; which page, channel, point in time and series."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from app.model.state.situation import Situation, has_volume
from app.model.text.language import from_core, tr
from app.model.volume.parts import Parts
from app.session.exchange.messages import Opened
from app.session.features.latest import Latest
from app.session.tasks.opening import parts_of
from app.views.features.file.offering import OfferingFeature
from app.views.files.part_dialog import PartDialog
from app.views.widgets.action_spec import ActionSpec
from app.views.window.feature import FeatureContext
from cpm_core.formats.images.reading import Reading


class StackFeature(OfferingFeature):
    """Says what else a file holds when a part of it is opened, and opens another part."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.dialog: PartDialog | None = None
        self._opened: Opened | None = None
        self._looking = Latest(context.session, "cpm-parts", tr("looking into the file"))
        self._looking.done.connect(self._show_parts)

    def action_specs(self) -> Sequence[ActionSpec]:
        """The other way to open a stack, and the choice of a part."""
        return (
            ActionSpec(name="open_stack", menu="File", text=tr("Open all pages as one volu&me"),
                       do=self._open_otherwise,
                       tip=tr("Open a stack of pages as one volume, or one page of it as an image."),
                       when=lambda _: self._holds_volume, worded=_text),
            ActionSpec(name="choose_part", menu="File", text=tr("Choose part of the &file…"), do=self.ask,
                       tip=tr("Choose page, channel, point in time and series of a file that holds several."),
                       when=lambda _: self._parts is not None and self._parts.several),
            ActionSpec(name="open_series", menu="File", text=tr("Open the &whole series"), do=self._open_series,
                       tip=tr("Open all slices in the folder of this DICOM file as one volume."),
                       when=lambda _: self._parts is not None and self._parts.series_around is not None),
        )  # fmt: skip

    def close(self) -> bool:
        """End the thread."""
        self._looking.close()
        return True

    def offer(self, opened: Opened) -> None:
        """Say what the file holds, and offer other parts of it."""
        self._opened, parts = opened, opened.parts
        if parts is None or opened.saved is not None:
            return
        volume = opened.image.ndim == 3
        if parts.series_around is not None:
            sentence = tr("{name} seems to be one slice of a series in the folder {folder}.").format(
                name=opened.path.name, folder=parts.series_around.name
            )
            self.bar.offer(sentence, (tr("Open the series"), self._open_series))
            return
        if parts.doubts and (volume or not parts.fit_a_volume):
            self._say_doubts(opened, parts)
            return
        if not (parts.several_volumes or (parts.several and not volume)):
            return
        sentence = tr("{name} holds {parts}. Open now: {open}.").format(
            name=opened.path.name, parts=parts.counted, open=parts.taken(opened.reading, volume)
        )
        answers = [(tr("Choose…"), self.ask)]
        if parts.fit_a_volume and not volume:
            answers.insert(0, (tr("Open as volume"), self._open_otherwise))
        self.bar.offer(sentence, *answers)

    def _say_doubts(self, opened: Opened, parts: Parts) -> None:
        """Say what is wrong with a volume as long as nobody works on it, and offer what may be better."""
        answers = [(tr("Choose…"), self.ask)]
        if parts.planes == parts.pages:  # all were taken, and only how far apart they are is in doubt
            answers.insert(0, (tr("Size of a voxel…"), lambda: self.context.do("pixel_size")))
        self.bar.offer(f"{opened.path.name}: {' '.join(map(from_core, parts.doubts))}", *answers)

    def ask(self) -> None:
        """Ask which part is to be opened."""
        opened, parts = self._opened, self._parts
        if opened is None or parts is None:
            return
        image = opened.image
        colored = image.colors is not None or opened.reading.color != "luminance"
        self.dialog = PartDialog(self.context.window, opened.path.name, parts, opened.reading, image.ndim == 3, colored)
        self.dialog.asked.connect(self._look)
        self.dialog.chosen.connect(self._open)
        self.dialog.finished.connect(self.dialog.deleteLater)
        self.dialog.open()

    # Internal

    @property
    def _parts(self) -> Parts | None:
        return None if self._opened is None else self._opened.parts

    @property
    def _holds_volume(self) -> bool:
        return self._parts is not None and self._parts.fit_a_volume

    def _look(self, series: int) -> None:
        if self._opened is not None:
            self._looking.ask(partial(_looked, self._opened.path, series))

    def _show_parts(self, found: object) -> None:
        if self.dialog is not None and isinstance(found, Parts):
            self.dialog.show_parts(found)

    def _open(self, as_volume: bool, reading: Reading) -> None:
        if self._opened is None:
            return
        if as_volume != (self._opened.image.ndim == 3):  # a size by hand has as many numbers as there are axes
            reading = replace(reading, spacing=None, unit=None)
        self.context.open_part(self._opened.path, as_volume, reading)

    def _open_series(self) -> None:
        parts = self._parts
        if parts is not None and parts.series_around is not None:
            self.context.open_file(parts.series_around, False)

    def _open_otherwise(self) -> None:
        if self._opened is not None:
            volume = self._opened.image.ndim == 3
            color = "luminance" if volume else self._opened.reading.color
            self._open(not volume, replace(self._opened.reading, page=None, color=color))


def _looked(path: Path, series: int) -> Parts | None:
    """What a series of a file holds."""
    return parts_of(path, Reading(series=series))[0]


def _text(situation: Situation) -> str:
    if has_volume(situation):
        return tr("Open one page as an i&mage")
    return tr("Open all pages as one volu&me")
