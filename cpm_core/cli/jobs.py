"""One image of a batch: what is asked for, what comes of it, and how it is done wherever there is a process for it."""

from __future__ import annotations

import time
from dataclasses import dataclass, field

from cpm_core.contours.review import apply
from cpm_core.formats import encoded, load_image
from cpm_core.formats.sessions.session_file import SessionFile
from cpm_core.parameters import Parameters
from cpm_core.segmentation.segment import segment
from cpm_core.shapes.document_shapes import charges_of, regions_of, seeds_on


@dataclass(frozen=True, slots=True)
class Job:
    """What is to be done.

    Attributes
    ----------
    number : int
        Its place among the images.
    path : str
        File of the image.
    session : SessionFile
        Start, regions, charges and marks.
    parameters : Parameters
        Parameters of the run.
    max_steps : int or None
        Steps after which it is stopped.
    suffixes : tuple of str
        Formats that are wanted.
    """

    number: int
    path: str
    session: SessionFile
    parameters: Parameters
    max_steps: int | None
    suffixes: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Done:
    """What came of it.

    Attributes
    ----------
    number : int
        Its place among the images.
    facts : dict
        Figures of the run, as ``cpm run --json`` tells them; empty when it failed.
    files : dict of str to bytes
        What is to be written, by suffix.
    trouble : str
        What went wrong, in one sentence; empty when nothing did.
    """

    number: int
    facts: dict[str, object] = field(default_factory=dict)
    files: dict[str, bytes] = field(default_factory=dict)
    trouble: str = ""


def do(job: Job) -> Done:
    """Find the contours of one image. Nothing is written here; the batch writes all files of an image at once."""
    try:
        began = time.perf_counter()
        image, shapes = load_image(job.path), job.session.shapes
        seeds = seeds_on(image, shapes, job.parameters.smoothing)
        found = segment(
            image,
            seeds,
            job.parameters,
            max_steps=job.max_steps,
            regions=regions_of(shapes),
            charges=charges_of(shapes),
        )
        result = apply(found, job.session.marks)
        facts = {
            "particles": len(result.particles),
            "contours": len(result.contours),
            "closed": sum(contour.closed for contour in result.contours),
            "steps": result.steps,
            "converged": result.converged,
            "stop_reason": result.stop_reason,
            "seconds": round(time.perf_counter() - began, 3),
        }
        return Done(job.number, facts, {suffix: encoded(result, suffix) for suffix in job.suffixes})
    except ValueError as error:
        return Done(job.number, trouble=str(error))
    except MemoryError:
        return Done(job.number, trouble="There is not enough memory for this image.")
