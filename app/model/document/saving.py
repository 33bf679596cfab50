"""Conversion between documents and session files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from app.model.document.document import Document, ImageReference
from app.model.document.modes import mode_called
from cpm_core.formats.sessions.session_file import ImageFile, SessionFile
from cpm_core.parameters import Parameters

View = Mapping[str, Any]
"""View settings of the window, as plain JSON."""


def to_file(document: Document, view: View, before: SessionFile | None = None) -> SessionFile:
    """The session file of a document; `before`, as it was read, gives the content that a document does not hold."""
    image = document.image
    return replace(
        before or SessionFile(),
        image=ImageFile(image.path, image.sha256, image.shape) if image else None,
        shapes=document.shapes,
        parameters=document.parameters,
        marks=document.marks,
        learning=document.learning,
        mode=document.mode,
        hand_edits=document.hand_edits,
        objects=document.objects,
        outlined=document.outlined,
        view=view,
        notes=(),
    )


def restored(file: SessionFile, image: ImageReference, parameters: Parameters) -> Document:
    """The document of a session file on its image, with parameters that suit the image."""
    mode = mode_called(file.mode)
    return Document(
        image,
        file.shapes,
        parameters,
        file.marks,
        file.learning,
        mode,
        hand_edits=file.hand_edits,
        objects=file.objects,
        outlined=file.outlined,
    )
