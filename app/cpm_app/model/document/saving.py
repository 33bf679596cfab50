"""Conversion between documents and session files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

from cpm_app.model.document.document import Document, ImageReference, Mode
from cpm_app.model.document.modes import MODES, switch_mode
from cpm_app.model.document.objects import with_taken_numbers
from cpm_app.model.text.language import tr
from cpm_core import Parameters
from cpm_core.formats import ImageFile, SessionFile, locate_file
from cpm_core.numerics.types import Texts

_DOCUMENT_PART_NAMES = {
    "shapes": tr("the shapes"),
    "parameters": tr("the parameters"),
    "objects": tr("the objects"),
    "second": tr("the second image"),
}
"""Attributes of a document in words."""

View = Mapping[str, Any]
"""View settings of the window, as plain JSON."""


def to_session_file(document: Document, view: View, before: SessionFile | None = None) -> SessionFile:
    """Convert a document to a session file; `before` is the file as read, for content that a document does not hold."""
    image = document.image
    return replace(
        before or SessionFile(),
        image=ImageFile(str(Path(image.path).absolute()), image.sha256, image.shape, reading=image.reading)
        if image
        else None,
        shapes=document.shapes,
        parameters=document.parameters,
        mode=document.mode,
        objects=document.objects,
        outlined=document.outlined,
        second=document.second,
        view=view,
        notes=(),
    )


def describe_changes(document: Document, known: Document | None) -> Texts:
    """Describe what differs from the `known` document, in words; a change of the mode alone is no work.

    Objects are counted; numbers that those of other pages take are no change. Without a known document, as after a
    crash, everything differs.
    """
    known = known and with_taken_numbers(known, document.objects.taken)
    if document == known:  # as it mostly is, and the rest takes longer
        return ()
    begun = document == switch_mode(document, document.mode)
    if known and begun and switch_mode(document, "shape") == switch_mode(known, "shape"):
        return ()
    before = known or Document(document.image, parameters=document.parameters, mode=document.mode)
    saved = {item.number: item for item in before.objects.items}
    count = sum(saved.get(item.number) != item for item in document.objects.items)
    counted = tr("1 object") if count == 1 else tr("{count} objects", count=count)
    found = tuple(
        counted if count and name == "objects" else words
        for name, words in _DOCUMENT_PART_NAMES.items()
        if getattr(document, name) != getattr(before, name)
    )
    return found or (tr("your choices"),)


def from_session_file(
    file: SessionFile, image: ImageReference, parameters: Parameters, folder: Path | None = None
) -> Document:
    """Convert a session file in a folder to a document on its image, with parameters that suit the image."""
    second = file.second
    if second is not None:
        second = replace(second, path=str(locate_file(second, folder or Path(image.path).parent)), absolute="")
    return Document(
        image,
        file.shapes,
        parameters,
        cast("Mode", file.mode) if file.mode in MODES else "shape",
        objects=file.objects,
        outlined=file.outlined,
        second=second,
    )
