"""Messages of the worker: the newest snapshot wins, reports are never lost."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpm_app.model.display.display_image import DisplayImage, DisplayVolume
from cpm_app.model.display.plots import RunMetrics
from cpm_app.model.document.document import Document
from cpm_app.model.state.surface_figures import format_surface_figures
from cpm_app.model.text.language import explain_error, tr
from cpm_app.model.volume.parts import FileParts
from cpm_app.model.volume.slices import SampledForce
from cpm_app.session.timeline.timeline import TimelineState
from cpm_core import (
    Image,
    Method,
    Parameters,
    Result,
    Skeleton,
)
from cpm_core.formats import Reading, SessionFile
from cpm_core.formats.images.reading import DEFAULT_READING
from cpm_core.numerics import Array
from cpm_core.numerics.types import Callback, Mask, Texts, frozen, record
from cpm_core.segmentation import MethodState
from cpm_core.shapes import ImageSeeds

log = logging.getLogger(__name__)


def explain_failure(error: Exception, activity: str) -> str:
    """Describe in one sentence what went wrong during an activity such as ``tr("opening {name}")``.

    The text of a `ValueError` or `OSError` is used. Any other error, except for lack of memory, is a defect of the
    program and is logged with its traceback.
    """
    if isinstance(error, ValueError | OSError):
        text = explain_error(error)
    elif isinstance(error, MemoryError):
        text = tr(
            "There was not enough memory while {activity}: close other programs, or use a smaller image",
            activity=activity,
        )
    else:
        log.error("unexpected error while %s", activity, exc_info=error)
        text = tr(
            "An unexpected error occurred while {activity}: {error}",
            activity=activity,
            error=str(error) or type(error).__name__,
        )
    text = " ".join(text.split())
    if text.partition(" ")[0].isalpha():  # file names are not changed
        text = text[:1].upper() + text[1:]
    return text if text.endswith(_SENTENCE_ENDS) else f"{text}."


_SENTENCE_ENDS = (".", "!", "?", "。", "！", "？")
"""Punctuation that ends a sentence, in all languages of the window."""


# Snapshots: the newest wins.


@record
class Snapshot:
    """The particles after a step, as the window shows them.

    Attributes
    ----------
    generation : int
        The run.
    method : str
        Name of the method.
    state : MethodState
        State of the run, which is never changed.
    position : ndarray, shape (N, 2)
        (row, col) in px of the image.
    resting : ndarray of bool, shape (N,)
        Whether each particle is at rest.
    steps_per_second : float
        Measured speed.
    metrics : RunMetrics
        The run so far.
    timeline : TimelineState
        The branches of the run.
    """

    generation: int
    method: str
    state: MethodState
    position: Array
    resting: Mask
    steps_per_second: float
    metrics: RunMetrics
    timeline: TimelineState


@record
class Reconstruction:
    """The contours of a recent snapshot."""

    generation: int
    result: Result | Skeleton

    @classmethod
    def from_result(cls, generation: int, result: Result | Skeleton) -> Reconstruction:
        """Make the message of a result, and measure its surface on this thread."""
        if isinstance(result, Result):
            format_surface_figures(result.surface)
        return cls(generation, result)


@frozen
class ReconstructionFailed:
    """The contours of a recent snapshot could not be reconstructed; the last ones stay."""

    generation: int
    message: str


OverlayData = NDArray[np.generic] | DisplayImage | DisplayVolume | SampledForce
"""Data of an overlay: an array or an image, or for a volume the data that its slices are made from."""


@record
class Overlays:
    """The requested overlays by name, for the image opened as `generation`.

    See `cpm_app.session.worker.prepared_methods`.

    `error` is the error of those that are missing.
    """

    generation: int
    arrays: Mapping[str, OverlayData]
    error: str = ""


# Reports: ordered, few.


class Report:
    """A message that the window must not miss; each kind is passed to its listeners."""


@frozen
class WorkFinished(Report):
    """Work on another thread is done; `callback` is called on the window's thread."""

    callback: Callback


@frozen
class SavedSession(Report):
    """A session file has been written or read; `path` is None for work that has none yet.

    If `recovered`, it was found after a crash and is not saved yet. If `is_other_page`, it is another page of the open
    stack, and `saved_document` is the document of that page in the file, None if the file has a different one.
    """

    path: Path | None
    file: SessionFile
    recovered: bool = False
    is_other_page: bool = False
    saved_document: Document | None = None


@record
class ImageOpened(Report):
    """An image is opened: it has been read, and a method is ready.

    `parameters` have as many of the requested `scales` as the image has room for. `folder_images` are the images of its
    folder, including itself; `adjacent_session` is a session of it that has not been opened with it. A volume has no
    `display`; each view makes one of its slice. `parts` are the contents of the file, None if unknown, and `reading`
    says which of them is open.
    """

    image: Image
    method: Method[Any]
    display: DisplayImage | None
    path: Path
    parameters: Parameters
    notes: Texts
    sha256: str = ""
    saved: SavedSession | None = None
    scales: int = 1
    folder_images: tuple[Path, ...] = ()
    adjacent_session: Path | None = None
    parts: FileParts | None = None
    reading: Reading = DEFAULT_READING


@record
class ImageReady(Report):
    """An image has been prepared and can replace the one that is open."""

    opened: ImageOpened


@frozen
class OpeningFailed(Report):
    """An image could not be used; the open one stays."""

    message: str


@record
class RunsKept(Report):
    """The runs on the timeline while none of them is shown, for example after a reset."""

    generation: int
    timeline: TimelineState


@frozen
class RunFailed(Report):
    """A run could not start or continue."""

    generation: int
    message: str


@frozen
class RunContinued(Report):
    """A run that had ended continues after an intervention."""

    generation: int


@record
class SeedsFound(Report):
    """Seeds that depend on the image opened as `generation`, or an error message."""

    generation: int
    image_seeds: ImageSeeds
    message: str = ""


@frozen
class FilesExported(Report):
    """Some files have been written, of which `path` is the first; `counts` says how much they contain."""

    path: Path
    counts: str = ""
    files: int = 1


@frozen
class CommandFailed(Report):
    """A command failed and nothing changed; `category` is the category of the message."""

    message: str
    category: str = ""


@frozen
class CompilationProgress(Report):
    """Compiling the kernels has come this far."""

    percent: int


@frozen
class WarmedUp(Report):
    """The kernels are ready."""
