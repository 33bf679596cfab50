"""Runs by session files: the same result for an image wherever a session is applied to it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from os import PathLike
from pathlib import Path

from numpy.typing import ArrayLike

from cpm_core.formats.common.content import AnyPath
from cpm_core.formats.common.provenance import record_drawn_shapes
from cpm_core.formats.images.readers import load_image, load_volume
from cpm_core.formats.images.reading import DEFAULT_READING
from cpm_core.formats.sessions.session_file import SessionFile, adapt_reading, load_session
from cpm_core.image.image import Image, as_image
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.model.state import State
from cpm_core.pages.follow import limit_scales
from cpm_core.parameters import Parameters
from cpm_core.results.result import Result
from cpm_core.segmentation.evolve import DEFAULT_METHOD, find_seeded_methods, segment
from cpm_core.shapes import Shape
from cpm_core.shapes.document_shapes import collect_charges, collect_regions, compute_seeds, select_starts


def run(
    values: ArrayLike | Image | AnyPath,
    session: SessionFile | AnyPath,
    parameters: Parameters | None = None,
    max_steps: int | None = None,
    progress: Callable[[State], object] | None = None,
) -> Result:
    """Run a saved session on an image: what the window finds with it, and ``cpm batch``.

    Parameters
    ----------
    values : array_like, shape (H, W) or (P, H, W), or Image, or path-like
        Image or volume; a file is read as that of the session.
    session : path-like or SessionFile
        Session file, as the window and ``cpm run --save-session`` write it, or its content.
    parameters : Parameters, optional
        Parameters in place of those of the session. An image with too little room for its scales is run with fewer.
    max_steps : int, optional
        Greatest number of steps.
    progress : callable, optional
        Called with every `State`.

    Returns
    -------
    Result
        Its `Result.objects` are the objects that the window proposes.

    Raises
    ------
    ValueError
        When the session or the image cannot be used, or the session has no start.

    Examples
    --------
    >>> from cpm_core.formats import SessionFile
    >>> from cpm_core.shapes import Everywhere
    >>> cpm.run(cpm.example("disks"), SessionFile(shapes=(Everywhere("grid"),))).objects
    (<Selection 302 px, 1 contour, 0 gaps, 92 % sure>, <Selection 302 px, 1 contour, 0 gaps, 92 % sure>)
    """
    known = session if isinstance(session, SessionFile) else load_session(Path(session))
    if not select_starts(known.shapes):
        named = "The session" if isinstance(session, SessionFile) else str(session)
        raise ValueError(f"{named} has no start: draw one, or start everywhere, and save it again.")
    image = load_session_image(values, known) if isinstance(values, str | PathLike) else as_image(values)
    wanted = parameters or known.parameters
    wanted = limit_scales(wanted, image.shape) if image.ndim == 2 else wanted
    found = segment_shapes(image, known.shapes, wanted, known, max_steps=max_steps, progress=progress)
    return record_drawn_shapes(found, known.shapes)


def load_session_image(path: AnyPath, session: SessionFile) -> Image:
    """Load an image, or for the session of a volume a volume, read as the session reads its own."""
    reading = DEFAULT_READING if session.image is None else session.image.reading
    load = load_volume if is_volume_session(session) else load_image
    return load(path, **adapt_reading(Path(path), reading))


def is_volume_session(session: SessionFile) -> bool:
    """Tell whether a session is about a volume."""
    return session.image is not None and len(session.image.shape) == 3


def segment_shapes(
    image: Image,
    shapes: Sequence[Shape],
    parameters: Parameters,
    session: SessionFile,
    *,
    max_steps: int | None = None,
    progress: Callable[[State], object] | None = None,
    regions: AnyRegions | None = None,
) -> Result:
    """Run from shapes to a result, by the method of a session, with its barriers unless there are `regions`."""
    return segment(
        image,
        compute_seeds(image, shapes, parameters.smoothing, parameters.channel),
        parameters,
        max_steps=max_steps,
        progress=progress,
        regions=regions or collect_regions(shapes, session.objects.barriers),
        charges=collect_charges(shapes),
        method=method_of(session),
    )


def method_of(session: SessionFile) -> str:
    """Return the name of the method that runs from seeds in a session: that of its mode, if it has one of its own."""
    return session.mode if session.mode in find_seeded_methods() else DEFAULT_METHOD
