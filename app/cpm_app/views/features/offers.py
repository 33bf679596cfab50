"""Offers for an opened image: other parts of its file, its pixel size, settings that suit it."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from cpm_app.model.display.lengths import format_pixel_size
from cpm_app.model.document import edits
from cpm_app.model.document.document import Document
from cpm_app.model.document.modes import PRESET_OFFERS, switch_mode
from cpm_app.model.document.samples import find_copied_sample
from cpm_app.model.preferences.table import KEEP_PARAMETERS, OFFER_SETTINGS
from cpm_app.model.state.situation import has_image, has_volume
from cpm_app.model.text.language import localize_number, tr, translate_core_text
from cpm_app.model.volume.parts import FileParts
from cpm_app.session.exchange.messages import ImageOpened, WorkFinished
from cpm_app.session.features.background import LatestOnlyWorker
from cpm_app.session.tasks.opening import inspect_file
from cpm_app.session.worker.commands import CommandContext, WorkerCommand
from cpm_app.views.features.files import OpenSaveFeature
from cpm_app.views.files.part_dialog import PartDialog
from cpm_app.views.files.pixel_size_dialog import PixelSizeDialog
from cpm_app.views.widgets.actions import ActionSpec
from cpm_app.views.window.window import Feature
from cpm_core import PRESETS
from cpm_core.formats import Reading
from cpm_core.image import ImageKind, guess_kind
from cpm_core.numerics.types import Sides
from cpm_core.segmentation import LargeImageSettings, large_image_settings


class InitialSettingsFeature(Feature):
    """Initial parameters of an image, and offers of earlier work and of settings that suit it."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        self.session.store.add_listener(ImageOpened, self._on_image_opened)
        self.window.preferences.call_on_change(KEEP_PARAMETERS, self._on_preference_changed)

    def _on_image_opened(self, opened: ImageOpened) -> None:
        """Find out which settings suit the image, which is shown in the meantime."""

        def inspect_image(context: CommandContext) -> None:
            kind, settings, image = None, None, opened.image
            if image.ndim == 2:
                kind, settings = guess_kind(image.values), large_image_settings(image.values)
            context.report(WorkFinished(partial(self._offer_settings, opened, kind, settings)))

        if opened.saved is None:
            self.session.post_command(WorkerCommand(inspect_image, tr("looking at the image"), "kind"))

    def _offer_settings(self, opened: ImageOpened, kind: ImageKind | None, settings: LargeImageSettings | None) -> None:
        session, offers, session_path = self.session, self.window.offers, opened.adjacent_session
        if session.image is not opened.image or session.status.started:
            return
        of_sample = find_copied_sample(opened.path) is not None
        if session_path is not None and not of_sample:
            earlier = tr("{name} contains earlier work on this image. Continue it?", name=session_path.name)
            offers.add_offer(earlier, (tr("Open session"), partial(self.window.open_image, session_path)))
        elif (
            kind is not None
            and kind in PRESET_OFFERS
            and not of_sample
            and session.document.mode != "skeleton"
            and self.window.preferences.read_preference(OFFER_SETTINGS)
        ):
            preset, words = PRESETS[kind], tr("settings for the kind of image")
            use_settings = partial(
                session.edit, words, lambda document: edits.apply_preset(switch_mode(document, "automatic"), preset)
            )
            offers.add_offer(PRESET_OFFERS[kind], (tr("Use these settings"), use_settings))
        document = session.document
        if settings is not None and _apply_large_image_settings(document, settings) != document:
            sentence = tr(
                "This image is large: {scales} scales and smoothing {smoothing} find its objects more "
                "reliably. Use them?",
                scales=settings.scales,
                smoothing=localize_number(f"{settings.smoothing:g}"),
            )
            enlarge = partial(_apply_large_image_settings, settings=settings)
            offers.add_offer(
                sentence, (tr("Use them"), partial(session.edit, tr("settings for a large image"), enlarge))
            )

    def _on_preference_changed(self) -> None:
        self.session.keeps_parameters = self.window.preferences.read_preference(KEEP_PARAMETERS)


def _apply_large_image_settings(document: Document, settings: LargeImageSettings) -> Document:
    """Return the document with settings for a large image; neither scales nor smoothing decrease."""
    now = document.parameters
    smoothing = now.smoothing if now.smoothing == "auto" else max(now.smoothing, settings.smoothing)
    return edits.set_parameters(document, replace(now, scales=max(now.scales, settings.scales), smoothing=smoothing))


class FilePartsFeature(Feature):
    """Offer and dialog of the other parts of a file of which one part is open."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        self.dialog: PartDialog | None = None
        self._opened: ImageOpened | None = None
        self._part_reader = LatestOnlyWorker(self.session, "cpm-parts", tr("inspecting the file"))
        self.session.store.add_listener(ImageOpened, self._on_image_opened)
        self.actions = (
            ActionSpec("parts", "File", "&Parts of the file…",
                       "Open all pages as a volume or one as an image, another channel, time or series.",
                       self.ask_for_part, when=lambda _: self._parts is not None
                       and (self._parts.has_choice or self._parts.series_around is not None)),
        )  # fmt: skip

    def ask_for_part(self) -> None:
        """Ask which part to open."""
        opened, parts = self._opened, self._parts
        if opened is None or parts is None:
            return
        image = opened.image
        colored = image.colors is not None or opened.reading.color != "luminance"
        self.dialog = dialog = PartDialog(
            self.window, opened.path.name, parts, opened.reading, image.ndim == 3, colored
        )

        def inspect_series(series: int) -> None:
            self._part_reader.submit(lambda: inspect_file(opened.path, Reading(series=series))[0], show_found_parts)

        def show_found_parts(found: object) -> None:
            if isinstance(found, FileParts):
                dialog.show_parts(found)

        dialog.series_requested.connect(inspect_series)
        dialog.part_selected.connect(self._open_part)
        dialog.finished.connect(self._part_reader.drop_waiting)
        dialog.finished.connect(dialog.deleteLater)
        dialog.open()

    # Internal

    @property
    def _parts(self) -> FileParts | None:
        return None if self._opened is None else self._opened.parts

    def _on_image_opened(self, opened: ImageOpened) -> None:
        """Describe the contents of the file, and offer other parts of it."""
        self._opened, parts = opened, opened.parts
        if parts is None or opened.saved is not None:
            return
        offer, volume = self.window.offers.add_offer, opened.image.ndim == 3
        answers = [(tr("Choose…"), self.ask_for_part)]
        if parts.series_around is not None:
            sentence = tr(
                "{name} seems to be one slice of a series in the folder {folder}.",
                name=opened.path.name,
                folder=parts.series_around.name,
            )
            offer(sentence, (tr("Open the series"), partial(self._open_part, None, opened.reading)))
        elif parts.doubts and (volume or not parts.can_be_volume):
            # Doubts about a volume are reported only until somebody has worked on it.
            if parts.volume_planes == parts.pages:  # all were read, and only their distance is in doubt
                answers.insert(0, (tr("Voxel size…"), partial(self.window.trigger_action, "pixel_size")))
            offer(f"{opened.path.name}: {' '.join(map(translate_core_text, parts.doubts))}", *answers)
        elif parts.has_volume_choice or (parts.has_choice and not volume):
            if parts.can_be_volume and not volume:
                answers.insert(
                    0, (tr("Open as volume"), partial(self._open_part, True, replace(opened.reading, page=None)))
                )
            sentences = [tr("{name} contains {parts}.", name=opened.path.name, parts=parts.count_text)]
            if shown := parts.describe_reading(opened.reading, volume):
                sentences.append(tr("Open now: {open}.", open=shown))
            if parts.has_composite:
                sentences.append(tr("Runs and clicks work on channel {number}.", number=opened.reading.channel or 1))
            offer(" ".join(sentences), *answers)

    def _open_part(self, as_volume: bool | None, reading: Reading) -> None:
        """Open a part as a volume or as an image, or, for None, the series in the folder."""
        if self._opened is None or self._parts is None:
            return
        if as_volume is None:
            self.window.open_image(self._parts.series_around or self._opened.path)
            return
        if as_volume != (self._opened.image.ndim == 3):  # a size entered by hand has one number per axis
            reading = replace(reading, spacing=None, unit=None)
        self.window.get_feature(OpenSaveFeature).open_part(self._opened.path, as_volume, reading)


class PixelSizeFeature(Feature):
    """Dialog of the pixel size, which is also offered for volumes without one; setting it can be undone."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        self.dialog: PixelSizeDialog | None = None
        self._stated_size: tuple[tuple[float, ...], str | None] | None = None
        self.session.store.add_listener(ImageOpened, self._on_image_opened)
        self.actions = (
            ActionSpec("pixel_size", "Edit", "P&ixel size…",
                       "Set the distance between rows, columns and planes, and its unit.", self.ask_for_size,
                       gap=True, when=has_image,
                       text_for=lambda situation: tr("Vo&xel size…") if has_volume(situation)
                       else tr("P&ixel size…")),
        )  # fmt: skip

    def _on_image_opened(self, opened: ImageOpened) -> None:
        """Offer to set the size if a volume has none: its voxels are then assumed to be cubes."""
        parts, ndim = opened.parts, opened.image.ndim
        self._stated_size = None if parts is None else (parts.spacing[-ndim:], parts.unit)
        if ndim == 3 and opened.image.unit is None and opened.saved is None:
            name = opened.path.name
            sentence = tr("{name} contains no voxel size: its voxels are assumed to be cubes. Set the size?", name=name)
            self.window.offers.add_offer(sentence, (tr("Set the size…"), self.ask_for_size))

    def ask_for_size(self) -> None:
        """Ask for the pixel size."""
        image = self.session.document.image
        if image is None:
            return
        stated = (
            "" if self._stated_size is None or self._stated_size[1] is None else format_pixel_size(*self._stated_size)
        )
        self.dialog = PixelSizeDialog(self.window, image.spacing, image.unit, stated)
        self.dialog.reset_button.setEnabled(self._stated_size is not None and image.reading.spacing is not None)
        self.dialog.size_selected.connect(self._set_pixel_size)
        self.dialog.reset_requested.connect(
            lambda: self._set_pixel_size(*self._stated_size, by_hand=False) if self._stated_size else None
        )
        self.dialog.finished.connect(self.dialog.deleteLater)
        self.dialog.open()

    def _set_pixel_size(self, spacing: Sides, unit: str | None, by_hand: bool = True) -> None:
        name = tr("voxel size") if len(spacing) == 3 else tr("pixel size")
        self.session.edit(
            name if by_hand else tr("size in the file"),
            lambda document: edits.set_pixel_size(document, spacing, unit, by_hand=by_hand),
        )
