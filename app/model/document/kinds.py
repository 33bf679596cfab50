"""Settings for kinds of images, offered where the kind is guessed and they are better than the usual ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from app.model.document.document import Document
from app.model.document.edits import use_preset
from app.model.document.modes import use_mode
from app.model.text.language import tr
from cpm_core.image.kind import Kind
from cpm_core.parameters import PRESETS


@dataclass(frozen=True, slots=True)
class Advice:
    """The preset for a kind of image, among the core's `PRESETS`, and the sentence that offers it."""

    preset: str
    sentence: str


ADVICE: Mapping[Kind, Advice] = MappingProxyType(
    {
        "fluorescence": Advice(
            "fluorescence",
            tr("This looks like a fluorescence image. Find all objects with settings for fluorescence?"),
        ),
        "angiogram": Advice(
            "angiogram", tr("This looks like an X-ray image of vessels. Find all vessels with settings for them?")
        ),
        "ultrasound": Advice(
            "ultrasound", tr("This looks like an ultrasound image. Find strong outlines with settings for ultrasound?")
        ),
    }
)
"""Kinds that are not listed do best with the usual settings."""


def use_kind(document: Document, kind: Kind) -> Document:
    """The document in the mode Automatic with the settings for a kind of image."""
    return use_preset(use_mode(document, "automatic"), PRESETS[ADVICE[kind].preset])
