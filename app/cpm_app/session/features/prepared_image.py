"""An image of a project that is run before it is opened, so that its contours and proposals are there at once."""

from __future__ import annotations

import math
import os
import sys
from dataclasses import field, replace
from pathlib import Path

from cpm_app.model.document.document import ImageReference
from cpm_app.model.document.saving import from_session_file
from cpm_app.session.features.kept_pages import run_recorded
from cpm_app.session.features.selector import MAX_OFFERED_PIXELS, find_proposals
from cpm_app.session.scene import Proposal
from cpm_app.session.tasks.tasks import BackgroundTask
from cpm_core import load_image
from cpm_core.formats import SessionFile, adapt_reading
from cpm_core.formats.images.reading import DEFAULT_READING
from cpm_core.numerics.types import JsonObject, record
from cpm_core.pages import limit_scales

_BACKGROUND_NICENESS = 10
"""How much the thread gives way to others, as the system counts it."""


@record
class PreparedImage:
    """The run of an image that is not open yet, with what it proposes; made with the `settings` that new images get.

    `proposals` are None, and there are no `runs`, where that would take too long.
    """

    path: Path
    sha256: str
    settings: SessionFile
    proposals: tuple[Proposal, ...] | None = None
    runs: JsonObject = field(default_factory=dict)

    @property
    def settings_with_runs(self) -> SessionFile:
        """The settings with the runs, which are used unless the image has changed."""
        known = self.settings.image and replace(self.settings.image, sha256=self.sha256)
        return replace(self.settings, image=known, runs=self.runs)


def prepare_proposals(path: Path, settings: SessionFile, task: BackgroundTask) -> PreparedImage:
    """Run an image with settings from everywhere, and find its objects as the window does; for use on a thread."""
    if sys.platform == "linux":  # elsewhere it would hold for the whole program
        os.setpriority(os.PRIO_PROCESS, 0, _BACKGROUND_NICENESS)
    reading = DEFAULT_READING if settings.image is None else settings.image.reading
    image = load_image(path, check_cancelled=task.check_cancelled, **adapt_reading(path, reading))
    if math.prod(image.shape) > MAX_OFFERED_PIXELS:
        return PreparedImage(path, image.file_sha256, settings)
    parameters = limit_scales(settings.parameters, image.shape)
    document = from_session_file(settings, ImageReference.from_image(path, image), parameters)
    result, runs = run_recorded(image, document, task)
    proposals = find_proposals(result, task) if result.contours else ()
    return PreparedImage(path, image.file_sha256, settings, proposals, runs)
