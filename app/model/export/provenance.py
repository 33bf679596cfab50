"""Provenance of what the window writes: what was drawn when a run began, and what is known without a run."""

from __future__ import annotations

from app.model.document.document import Document
from app.model.document.modes import MODES
from cpm_core.formats.common.provenance import facts_on, plain_shapes, text_of
from cpm_core.parameters.provenance import Provenance, taken
from cpm_core.segmentation.method import METHODS


def comment_on(document: Document, *, steered: bool) -> str:
    """How the pictures of a run came about, for the file of an animation; empty without an image."""
    if document.image is None:
        return ""
    method = METHODS[MODES[document.mode].method]
    parameters = taken(document.parameters, method.parameters)
    shapes = plain_shapes(document.shapes)
    made = Provenance(method.name, parameters, shapes=shapes, steered=steered, sha256=document.image.sha256)
    return text_of(facts_on(document.image.name, made))
