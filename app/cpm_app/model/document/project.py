"""The images of a project: what new ones begin with, how far the work on each is, and which is next."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from cpm_app.model.document.document import Document
from cpm_app.model.text.language import tr
from cpm_core.formats import ImageFile, ImageState, Project, Reading, SessionFile
from cpm_core.numerics.types import record
from cpm_core.objects.segmented import SegmentedObjects
from cpm_core.shapes import Everywhere


class StateWords(NamedTuple):
    """Sign and word of a state."""

    sign: str
    word: str

    def __str__(self) -> str:
        return f"{self.sign} {self.word}"


STATE_WORDS: Mapping[ImageState, StateWords] = {
    "untouched": StateWords("○", tr("untouched")),
    "begun": StateWords("◐", tr("begun")),
    "done": StateWords("●", tr("done")),
    "doubtful": StateWords("?", tr("doubtful")),
}
"""Sign and word of each state, in the order in which work on an image goes on."""

TO_PROPOSE = StateWords("◌", tr("to propose"))
"""Sign and word of an untouched image that is run as soon as it is opened."""


@record
class ImageRow:
    """An image of a project: its place from 1, its file, its state, and how many objects it has, None if unknown."""

    place: int
    path: Path
    state: ImageState
    objects: int | None
    is_proposed: bool = False

    @property
    def words(self) -> StateWords:
        """Sign and word of its state."""
        return TO_PROPOSE if self.is_proposed else STATE_WORDS[self.state]


def list_images_of(images: Sequence[Path], project: Project, sessions: Collection[str]) -> tuple[ImageRow, ...]:
    """List the images of a project with their states.

    Parameters
    ----------
    images : sequence of Path
        The images.
    project : Project
        What is known of them.
    sessions : collection of str
        Names of the images with a session; such an image has been begun, even if the project does not know it.
    """
    rows = []
    for place, path in enumerate(images, start=1):
        known = project.images.get(path.name)
        state: ImageState = "begun" if path.name in sessions else "untouched"
        objects = known.objects if known is not None else None if path.name in sessions else 0
        state = known.state if known is not None else state
        rows.append(ImageRow(place, path, state, objects, project.proposes and state == "untouched"))
    return tuple(rows)


def find_next_undone(rows: Sequence[ImageRow], current: Path | None) -> Path | None:
    """Find the first image after the current one, and again from the start, about which the user has said nothing.

    None if there is no other one.
    """
    here = next((index for index, row in enumerate(rows) if row.path == current), -1)
    others = (*rows[here + 1 :], *rows[: max(here, 0)])
    return next((row.path for row in others if row.state in ("untouched", "begun")), None)


def settings_of(document: Document) -> SessionFile | None:
    """Return what other images begin with: mode, parameters, classes, and starts that suit any image.

    A channel and a pixel size set by hand are among it, but nothing that was drawn, and no object. None for a volume,
    whose settings suit no image.
    """
    image, objects = document.image, document.objects
    if image is None or image.is_volume:
        return None
    reading = Reading(channel=image.reading.channel, spacing=image.reading.spacing, unit=image.reading.unit)
    return SessionFile(
        ImageFile(image.name, reading=reading),
        tuple(shape for shape in document.shapes if isinstance(shape, Everywhere)),
        document.parameters,
        mode=document.mode,
        objects=SegmentedObjects(classes=objects.classes, category=objects.category),
    )


def has_own_work(document: Document) -> bool:
    """Tell whether a document holds work on its image: objects, clicks, or something drawn."""
    objects = document.objects
    drawn = any(not isinstance(shape, Everywhere) for shape in document.shapes)
    return drawn or bool(objects.items or objects.clicks or objects.rejected or objects.deleted)
