"""An image of a project that is run before it is opened, so that its proposals are there at once."""

from __future__ import annotations

import math
import os
import sys
from pathlib import Path

from cpm_app.model.document.contours import run_document
from cpm_app.model.document.document import ImageReference
from cpm_app.model.document.saving import from_session_file
from cpm_app.session.features.selector import MAX_OFFERED_PIXELS, find_all_objects
from cpm_app.session.scene import Proposal
from cpm_app.session.tasks.tasks import BackgroundTask
from cpm_core import Engine, load_image, partition
from cpm_core.formats import SessionFile, adapt_reading
from cpm_core.formats.images.reading import DEFAULT_READING
from cpm_core.numerics.types import record
from cpm_core.pages import limit_scales
from cpm_core.shapes import SeedCache

_BACKGROUND_NICENESS = 10
"""How much the thread gives way to others, as the system counts it."""


@record
class PreparedImage:
    """Proposals on an image that is not open yet, made with the `settings`; None where that would take too long."""

    path: Path
    sha256: str
    settings: SessionFile
    proposals: tuple[Proposal, ...] | None


def prepare_proposals(path: Path, settings: SessionFile, task: BackgroundTask) -> PreparedImage:
    """Run an image with settings from everywhere, and find its objects as the window does; for use on a thread."""
    if sys.platform == "linux":  # elsewhere it would hold for the whole program
        os.setpriority(os.PRIO_PROCESS, 0, _BACKGROUND_NICENESS)
    reading = DEFAULT_READING if settings.image is None else settings.image.reading
    image = load_image(path, task.check_cancelled, **adapt_reading(path, reading))
    if math.prod(image.shape) > MAX_OFFERED_PIXELS:
        return PreparedImage(path, image.file_sha256, settings, None)
    parameters = limit_scales(settings.parameters, image.shape)
    document = from_session_file(settings, ImageReference.from_image(path, image), parameters)
    engine = Engine(image, parameters, document.regions)
    seeds = document.find_image_seeds(SeedCache(image))
    result = run_document(engine, document, seeds, lambda _: task.check_cancelled())
    proposals = find_all_objects(partition(result), task) if result.contours else ()
    return PreparedImage(path, image.file_sha256, settings, proposals)
