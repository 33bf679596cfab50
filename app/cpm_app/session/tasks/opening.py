"""Opening an image or a session on a separate thread; it can be cancelled, and the open image stays usable."""

from __future__ import annotations

import os
import re
from dataclasses import replace
from pathlib import Path

from cpm_app.model.display.display_image import build_display_image
from cpm_app.model.export import EXPORT_TITLES
from cpm_app.model.text.language import explain_error, tr
from cpm_app.model.volume.parts import FileParts
from cpm_app.session.exchange.messages import (
    ImageOpened,
    ImageReady,
    OpeningFailed,
    Report,
    SavedSession,
)
from cpm_app.session.tasks.tasks import ENDED_TASK, BackgroundTask, TaskManager
from cpm_core import PRESETS, RUN_METHODS, Image, Parameters, load_image, load_volume
from cpm_core.formats import (
    SESSION_SUFFIX,
    Reading,
    SessionFile,
    UnreadableError,
    adapt_reading,
    find_session_image,
    find_sibling_dicom_files,
    is_image_name,
    load_session,
    natural_sort_key,
    open_stack,
)
from cpm_core.formats.images import raster
from cpm_core.formats.images.ome_zarr import is_zarr
from cpm_core.formats.images.reading import DEFAULT_READING
from cpm_core.image import MINIMUM_SIDE
from cpm_core.numerics.types import Callback, Texts, frozen
from cpm_core.pages import limit_scales
from cpm_core.shapes import check_axes

_MASK_ENDINGS = ("cp_masks", "cp_outlines", "gt", "labels?", "masks?", "seg", "segmentation")
"""Ends of the names of masks that other programs write next to an image, as regular expressions."""

_DERIVED_NAME = re.compile(
    rf"(.+?)(?:_(?:{'|'.join(EXPORT_TITLES)})|[_-](?:{'|'.join(_MASK_ENDINGS)}))\.", re.IGNORECASE
)
"""Names of files made for an image, exports and masks, whose stem is the first group."""


def sibling_images(image: Path) -> tuple[Path, ...]:
    """List the images in the folder of an image, including itself, in natural order: 2 comes before 10."""
    return tuple(sorted({*list_images(image.parent), image}, key=lambda path: natural_sort_key(path.name)))


def list_images(folder: Path) -> tuple[Path, ...]:
    """List the images in a folder, without exports and masks made for them; none if it cannot be read."""
    try:
        with os.scandir(folder) as entries:
            names = [entry.name for entry in entries if _is_image(entry)]
    except OSError:
        return ()
    stems = {stem for name in names for stem in (Path(name).stem, name.partition(".")[0])}
    derived = {name for name in names if (parts := _DERIVED_NAME.match(name)) and parts[1] in stems}
    return tuple(folder / name for name in sorted({*names} - derived, key=natural_sort_key))


def is_image_folder(path: Path) -> bool:
    """Return whether a path is a folder of images: one with images, and no single image of many files."""
    if not path.is_dir() or is_zarr(path):
        return False
    images = list_images(path)
    return bool(images) and len(find_sibling_dicom_files(images[0], MINIMUM_SIDE)) < MINIMUM_SIDE


def find_adjacent_session(image: Path) -> Path | None:
    """Find the session file next to an image, of the same name; None if there is none that can be used."""
    path = image.with_suffix(SESSION_SUFFIX)
    if path == image or not path.is_file():
        return None
    try:
        file = load_session(path).image
        found, _ = find_session_image(file, path.absolute().parent) if file is not None else (None, ())
    except ValueError:
        return None
    return path if found is not None and found == image.resolve() else None


def _is_image(entry: os.DirEntry[str]) -> bool:
    return is_image_name(entry.name) and (entry.is_file() or is_zarr(Path(entry)))


PAGED_SUFFIXES = frozenset({".tif", ".tiff", *raster.FILE_KINDS})
"""Suffixes of files whose pages are usually separate images."""


def inspect_file(path: Path, reading: Reading) -> tuple[FileParts | None, Reading]:
    """Return the contents of a file, None if it cannot be read, and how it is read: the first of several images.

    Errors of a file are reported later, when it is read.
    """
    paged = path.suffix.lower() in PAGED_SUFFIXES
    try:
        try:
            stack = open_stack(path, reading.series)
            # the folder, if both the file and enough files next to it are DICOM
            series = path.parent if len(find_sibling_dicom_files(path, MINIMUM_SIDE)) >= MINIMUM_SIDE else None
            return FileParts.from_stack(stack, paged, series), reading
        except UnreadableError as error:
            if not error.images:
                raise
            first = replace(reading, series=error.images[0] + 1)
            return FileParts.from_stack(open_stack(path, first.series), paged), first
    except ValueError:
        return None, reading


@frozen
class OpenRequest:
    """A request to open an image or a session file at `path`.

    A session has its own parameters. If `saved` has its content, `path` is only its location. The `notes` are shown
    once it is open. An image that `resumes` is opened with the session next to it, if there is one. A stack of planes
    is opened `as_volume`, or one plane as an image; None leaves that to the kind of file. `reading` says which part of
    the file is read. An image without a session begins with the `settings`, if they are given; a volume does not.
    """

    path: Path
    parameters: Parameters
    saved: SavedSession | None = None
    notes: Texts = ()
    resumes: bool = False
    as_volume: bool | None = None
    reading: Reading = DEFAULT_READING
    settings: SessionFile | None = None


def prepare_image(request: OpenRequest, check_cancelled: Callback) -> ImageOpened:
    """Read an image and prepare the charged particles for it, with as many scales as it has room for.

    `check_cancelled` is called between the steps, and raises if the task has been cancelled. Raises ValueError if the
    image or the session cannot be used.
    """
    path, parameters, saved, notes, named = request.path, request.parameters, request.saved, request.notes, None
    beside = find_adjacent_session(path) if saved is None else None
    if beside is not None and request.resumes:
        path, beside = beside, None
    if saved is None and path.suffix.lower() == SESSION_SUFFIX:
        saved = SavedSession(path, load_session(path))
    if saved is not None:
        parameters, named = saved.file.parameters, saved.file.image
        if named is None:
            raise ValueError(tr("{name} does not name an image.", name=path.name))
        path, warnings = find_session_image(named, path.absolute().parent, check_cancelled)
        notes = (*notes, *saved.file.notes, *warnings)
    settings, reading = request.settings if saved is None else None, request.reading
    if named is not None:
        reading = named.reading
    elif settings is not None and settings.image is not None:
        reading = _read_alike(path, settings.image.reading)
    parts, reading = inspect_file(path, reading)
    check_cancelled()
    asked = request.as_volume if named is None or not named.shape else len(named.shape) == 3
    # that only the first channel is taken would be no true note on a composite of all of them
    chosen = replace(reading, channel=reading.channel or 1) if parts is not None and parts.has_composite else reading
    if parts is not None:  # nor that only one page is, where all can be gone to
        chosen = replace(chosen, page=chosen.page or parts.default_page)
    image, refused = _read_image(path, chosen, asked, parts, check_cancelled)
    notes = (*refused, *notes)
    check_cancelled()
    if saved is not None:
        _check_session_axes(saved, image)
    elif settings is not None and image.ndim == 2:
        saved, parameters = SavedSession(None, settings), settings.parameters
    elif image.ndim == 3:
        parameters = PRESETS["volume"]
    scales, parameters = parameters.scales, limit_scales(parameters, image.shape)
    if scales > parameters.scales:
        notes = (*notes, tr("The image is small: the scales are set to {most}.", most=parameters.scales))
    method = RUN_METHODS["cpm"](image, parameters, None)
    check_cancelled()
    display = build_display_image(image) if image.ndim == 2 else None
    return ImageOpened(
        image, method, display, path, parameters, (*image.notes, *notes), image.file_sha256, saved, scales,
        sibling_images(path), beside, parts, reading,
    )  # fmt: skip


def _read_alike(path: Path, reading: Reading) -> Reading:
    """Return how a file is read as another one is; by default if its content differs too much."""
    try:
        return replace(DEFAULT_READING, **adapt_reading(path, reading))
    except ValueError:
        return DEFAULT_READING


def _check_session_axes(saved: SavedSession, image: Image) -> None:
    """Raise ValueError if the content of a session is for a volume and its file is an image, or vice versa."""
    check_axes(saved.file.shapes, image.shape, image.source)
    if any(item.region.ndim != image.ndim for item in saved.file.objects.items):
        text = tr("{name} contains objects of a volume, but {image} is an image: put the volume back in its place.")
        if image.ndim == 3:
            text = tr("{name} contains objects of an image, but {image} is a volume: put the image back in its place.")
        name = saved.path.name if saved.path is not None else tr("The session")
        raise ValueError(text.format(name=name, image=image.source))


def _read_image(
    path: Path,
    reading: Reading,
    as_volume: bool | None,
    parts: FileParts | None,
    check_cancelled: Callback,
) -> tuple[Image, Texts]:
    """Read the image or the volume of a file and compute its range of gray levels.

    If the volume of a file cannot be used and was not explicitly requested by `as_volume`, one plane of it is read, and
    the message says why.
    """
    chosen, refused, image = reading.arguments, tuple[str, ...](), None
    if as_volume or (as_volume is None and parts is not None and parts.pages >= MINIMUM_SIDE and parts.is_volume):
        in_volume = {name: given for name, given in chosen.items() if name != "page"}
        try:
            image = load_volume(path, check_cancelled=check_cancelled, **in_volume)
        except ValueError as error:
            if as_volume:
                raise
            refused = (explain_error(error),)
    if image is None:
        image = load_image(path, check_cancelled=check_cancelled, **chosen)
    image.shown_range, image.is_ct  # noqa: B018 - cached here, because the window needs them
    return image, refused


class Opener:
    """Opens one image at a time; a later request replaces an earlier one that is not ready yet."""

    def __init__(self, tasks: TaskManager) -> None:
        self._tasks = tasks
        self._task = ENDED_TASK
        self._afterwards: list[Callback] = []
        tasks.changed.connect(self._on_tasks_changed)

    @property
    def opening_name(self) -> str:
        """Name of the task as it is shown; empty when nothing is being opened."""
        return "" if self._task.is_over else self._task.name

    def start_opening(self, request: OpenRequest) -> BackgroundTask:
        """Start to open an image or a session."""
        self._task.cancel()
        name = request.path.name

        def read_and_prepare(task: BackgroundTask) -> Report:
            return ImageReady(prepare_image(request, task.check_cancelled))

        self._task = self._tasks.start_task(
            tr("Opening {name}…", name=name),
            read_and_prepare,
            tr("opening {name}", name=name),
            OpeningFailed,
        )
        return self._task

    def call_when_opened(self, callback: Callback) -> None:
        """Call `callback` as soon as no image is being opened."""
        self._afterwards.append(callback)
        self._on_tasks_changed()

    def _on_tasks_changed(self) -> None:
        if not self.opening_name:
            waiting, self._afterwards = self._afterwards, []
            for do in waiting:
                do()
