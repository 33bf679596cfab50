"""What is offered for an image when it has been opened: other parts of its file, its size, settings that suit it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from app.model.display.lengths import size_text
from app.model.document import edits
from app.model.document.document import Document
from app.model.document.modes import ADVICE, use_kind
from app.model.document.samples import sample_at
from app.model.preferences.table import KEEP_PARAMETERS, OFFER_SETTINGS
from app.model.state.situation import Situation, has_image, has_volume
from app.model.text.language import from_core, tr, written
from app.model.volume.parts import Parts
from app.session.exchange.messages import Opened
from app.session.features.background import LatestOnlyWorker
from app.session.tasks.opening import parts_of
from app.views.files.part_dialog import PartDialog
from app.views.files.pixel_size_dialog import PixelSizeDialog
from app.views.widgets.actions import ActionSpec
from app.views.widgets.containers import OfferBar
from app.views.window.feature import Feature, FeatureContext
from cpm_core.formats import Reading
from cpm_core.segmentation import LargeImageSettings


def offering(context: FeatureContext, offer: Callable[[Opened], None]) -> OfferBar:
    """A line above the image in which `offer` may offer something for each image that is opened.

    An offer is withdrawn when a run begins or another image is opened. Of several offers one is shown at a time.
    """
    bar, session, offers = OfferBar(), context.session, context.canvas_area.offers

    def begin(opened: Opened) -> None:
        bar.end()
        offer(opened)

    def withdraw() -> None:
        if bar.waiting and session.status.started:
            bar.end()

    def take_turns() -> None:
        items = [item for place in range(offers.count()) if (item := offers.itemAt(place)) is not None]
        bars = [one for item in items if isinstance(one := item.widget(), OfferBar)]
        first = next((one for one in bars if one.waiting), None)
        for one in bars:
            one.setVisible(one is first)

    bar.changed.connect(take_turns)
    offers.addWidget(bar)
    session.listen(Opened, begin)
    session.status_changed.connect(withdraw)
    return bar


class BeginningFeature(Feature):
    """The parameters that an image begins with, and what is offered for it in a line above it."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.bar = offering(context, self.offer)
        context.preferences.follow(KEEP_PARAMETERS, self._use)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Parameters of the last image."""
        session = self.context.session
        return (
            ActionSpec("former_parameters", "Run", tr("Use parameters of the &last image"),
                       tr("Set all parameters as they were for the image that was open before this one."),
                       session.use_former_parameters, when=self._differ),
        )  # fmt: skip

    def offer(self, opened: Opened) -> None:
        """Offer earlier work on an image, or the settings for its kind."""
        session, kind = self.context.session, opened.kind
        if opened.saved is not None or sample_at(opened.path) is not None:
            return
        if opened.beside is not None:
            beside = opened.beside
            earlier = tr("{name} holds earlier work on this image. Continue it?").format(name=beside.name)
            self.bar.offer(earlier, (tr("Open session"), lambda: self.context.open_file(beside, False)))
        elif (
            kind is not None
            and kind in ADVICE
            and session.document.mode != "skeleton"
            and self.context.preferences.value(OFFER_SETTINGS)
        ):
            take = partial(session.edit, tr("settings for the kind of image"), partial(use_kind, kind=kind))
            self.bar.offer(ADVICE[kind].sentence, (tr("Use these settings"), take))

    def _differ(self, situation: Situation) -> bool:
        former, document = self.context.session.former_parameters, situation.document
        return former is not None and document.fitting(former) != document.parameters

    def _use(self) -> None:
        self.context.session.keeps_parameters = self.context.preferences.value(KEEP_PARAMETERS)


class LargeImageFeature(Feature):
    """Offers the scales and the smoothing that suit a large image; nothing is changed before the user agrees."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.bar = offering(context, self.offer)

    def offer(self, opened: Opened) -> None:
        """Offer what a large image wants."""
        settings, document = opened.large, self.context.session.document
        if settings is None or opened.saved is not None or _with(document, settings) == document:
            return
        sentence = tr(
            "This image is large: {scales} scales and smoothing {smoothing} find its objects more surely. Use them?"
        ).format(scales=settings.scales, smoothing=written(f"{settings.smoothing:g}"))
        name = tr("settings for a large image")
        self.bar.offer(
            sentence,
            (tr("Use them"), lambda: self.context.session.edit(name, lambda document: _with(document, settings))),
        )


def _with(document: Document, settings: LargeImageSettings) -> Document:
    """The document with settings for a large image, and with no less of either than it has."""
    now = document.parameters
    smoothing = now.smoothing if now.smoothing == "auto" else max(now.smoothing, settings.smoothing)
    wanted = replace(now, scales=max(now.scales, settings.scales), smoothing=smoothing)
    return edits.set_parameters(document, wanted)


class StackFeature(Feature):
    """Says what else a file holds when a part of it is opened, and opens another part."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.bar = offering(context, self.offer)
        self.dialog: PartDialog | None = None
        self._opened: Opened | None = None
        self._looking = LatestOnlyWorker(context.session, "cpm-parts", tr("looking into the file"))

    def action_specs(self) -> Sequence[ActionSpec]:
        """The other way to open a stack, and the choice of a part."""
        return (
            ActionSpec("open_stack", "File", tr("Open all pages as one volu&me"),
                       tr("Open a stack of pages as one volume, or one page of it as an image."), self._open_otherwise,
                       when=lambda _: self._parts is not None and self._parts.fit_a_volume, worded=_stack_text),
            ActionSpec("choose_part", "File", tr("Choose part of the &file…"),
                       tr("Choose page, channel, point in time and series of a file that holds several."), self.ask,
                       when=lambda _: self._parts is not None and self._parts.several),
            ActionSpec("open_series", "File", tr("Open the &whole series"),
                       tr("Open all slices in the folder of this DICOM file as one volume."), self._open_series,
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
            # What is wrong with a volume is said as long as nobody works on it.
            answers = [(tr("Choose…"), self.ask)]
            if parts.planes == parts.pages:  # all were taken, and only how far apart they are is in doubt
                answers.insert(0, (tr("Size of a voxel…"), lambda: self.context.do("pixel_size")))
            self.bar.offer(f"{opened.path.name}: {' '.join(map(from_core, parts.doubts))}", *answers)
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

    def _look(self, series: int) -> None:
        if self._opened is not None:
            self._looking.ask(partial(_looked, self._opened.path, series), self._show_parts)

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


def _stack_text(situation: Situation) -> str:
    if has_volume(situation):
        return tr("Open one page as an i&mage")
    return tr("Open all pages as one volu&me")


class PixelSizeFeature(Feature):
    """Asks for the size, offers to where a volume tells none, and makes it an edit that can be undone."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.bar = offering(context, self.offer)
        self.dialog: PixelSizeDialog | None = None
        self._told: tuple[tuple[float, ...], str | None] | None = None

    def action_specs(self) -> Sequence[ActionSpec]:
        """Ask for the size."""
        return (
            ActionSpec("pixel_size", "Edit", tr("Size of a p&ixel…"),
                       tr("Set how far apart rows and columns are, and planes of a volume, and in which unit."),
                       self.ask, gap=True, when=has_image, worded=_size_text),
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


def _size_text(situation: Situation) -> str:
    return tr("Size of a vo&xel…") if has_volume(situation) else tr("Size of a p&ixel…")
