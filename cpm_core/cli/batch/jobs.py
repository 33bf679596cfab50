"""One image of a batch: the job, its result, and the function that processes it in any process."""

from __future__ import annotations

import logging
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from cpm_core.cli.arguments import notes_on, with_room
from cpm_core.cli.outcome import outcome_of
from cpm_core.contours.result import Result
from cpm_core.contours.review import apply
from cpm_core.formats import encoded, load_image, omission
from cpm_core.formats.common.content import fingerprint_if_read
from cpm_core.formats.common.provenance import with_shapes
from cpm_core.formats.images.reading import DEFAULT
from cpm_core.formats.sessions.chosen_part import part_for
from cpm_core.formats.sessions.session_file import SessionFile
from cpm_core.parameters import Parameters
from cpm_core.segmentation.evolve import segment, with_hand_edits
from cpm_core.shapes.document_shapes import charges_of, regions_of, seeds_on

_LOG = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Job:
    """A run on one image."""

    number: int  # index of the image
    path: str
    session: SessionFile  # start, regions, charges and review
    parameters: Parameters
    max_steps: int | None
    suffixes: tuple[str, ...]  # formats to write


@dataclass(frozen=True, slots=True)
class Done:
    """Result of a job; when it failed, `error` is one sentence and the rest is empty."""

    number: int  # index of the image
    facts: dict[str, object] = field(default_factory=dict)  # as in ``cpm run --json``
    files: dict[str, bytes] = field(default_factory=dict)  # suffix -> content
    error: str = ""
    notes: tuple[str, ...] = ()  # what was changed on reading, or left out of a file
    sha256: str = ""  # of the image file


def do(job: Job) -> Done:
    """Find the contours of one image; the files are only encoded, and the batch writes them together."""
    try:
        began = time.perf_counter()
        shown, shapes = job.session.image, job.session.shapes
        image = load_image(job.path, **part_for(Path(job.path), DEFAULT if shown is None else shown.reading))
        parameters, small = with_room(job.parameters, image)
        seeds = seeds_on(image, shapes, parameters.smoothing, parameters.channel)
        found = segment(
            image,
            seeds,
            parameters,
            max_steps=job.max_steps,
            regions=regions_of(shapes, job.session.objects.barriers),
            charges=charges_of(shapes),
        )
        edited = with_hand_edits(found, image, parameters, job.session.hand_edits)
        result = apply(with_shapes(edited, shapes), job.session.marks)
        facts = outcome_of(result, time.perf_counter() - began)
        files, notes = _files(result, job.suffixes)
        return Done(job.number, facts, files, notes=(*notes_on(image, parameters), *small, *notes), sha256=image.sha256)
    except Exception as error:
        return Done(job.number, error=_reason(error), sha256=fingerprint_if_read(Path(job.path)))


def _reason(error: Exception) -> str:
    """Why an image has failed; a defect of the program, too, is told, since it does not concern the other images."""
    if isinstance(error, ValueError):
        return str(error)
    if isinstance(error, MemoryError):
        return "There is not enough memory for this image."
    _LOG.info("an unexpected error", exc_info=error)
    return f"Something unexpected happened: {type(error).__name__}: {error}."


def _files(result: Result, suffixes: Sequence[str]) -> tuple[dict[str, bytes], list[str]]:
    """The files of a result by suffix, and why some hold less than it or cannot be made; ValueError when none can."""
    files: dict[str, bytes] = {}
    notes: list[str] = []
    failure = ""
    for suffix in suffixes:
        try:
            files[suffix] = encoded(result, suffix)
        except ValueError as error:
            failure = failure or str(error)
            notes.append(f"{suffix} was not written: {error}")
            continue
        notes += filter(None, [omission(result, suffix)])
    if failure and not files:
        raise ValueError(failure)
    return files, notes
