"""Documents and session files: the one from the other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from app.model.document.document import Document, ImageReference
from app.model.document.modes import mode_called
from cpm_core.formats.sessions.session_file import ImageFile, SessionFile
from cpm_core.parameters import Parameters

View = Mapping[str, Any]
"""How the window looks at a document, as plain JSON."""


def to_file(document: Document, view: View, before: SessionFile | None = None) -> SessionFile:
    """What is to be saved of a document.

    Parameters
    ----------
    document : Document
        What the user means.
    view : mapping
        How the window looks at it.
    before : SessionFile, optional
        What the session file held when it was read, for all that a document does not hold.
    """
    image = document.image
    return replace(
        before or SessionFile(),
        image=ImageFile(image.path, image.sha256, image.shape) if image else None,
        shapes=document.shapes,
        parameters=document.parameters,
        marks=document.marks,
        mode=document.mode,
        view=view,
        notes=(),
    )


def restored(file: SessionFile, image: ImageReference, parameters: Parameters) -> Document:
    """The document of a session file on an image that has been opened, with the parameters that it has room for."""
    return Document(image, file.shapes, parameters, file.marks, mode_called(file.mode))
