"""Presets: named settings of all parameters, those of the program and those of the user, and their files."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cache
from typing import Any

from app.model.text.language import reason, tr
from cpm_core.formats.sessions.plain_values import parameters_from_plain
from cpm_core.parameters import PLANE_PRESETS, Parameters

SUFFIX = ".cpmpreset"

_FORMAT, _VERSION = "CPM preset", 1
_LONGEST_NAME, _LONGEST_ABOUT = 60, 1000
_LARGEST = 4_000_000
"""Maximum length of a preset file [bytes]."""

_BUILT_IN = {
    "shape": (tr("Shape recovery"), tr("Finds the whole outline of what a start is drawn in or around.")),
    "automatic": (tr("Automatic segmentation"), tr("Starts everywhere and keeps the contours of sure edges.")),
    "vessels": (tr("Vessels"), tr("Finds both sides of what is long and thin, darker or brighter than around it.")),
    "noisy": (tr("Noisy image"), tr("Chooses the smoothing from the noise of the image.")),
    "fluorescence": (
        tr("Fluorescence"),
        tr("Finds bright objects on a dark background, without their texture."),
    ),
    "angiogram": (tr("Angiogram"), tr("Finds vessels with a contrast medium, and leaves out faint lines.")),
    "ultrasound": (
        tr("Ultrasound"),
        tr("Finds the strongest outlines on a very smooth image, without speckle."),
    ),
}


@dataclass(frozen=True, slots=True)
class Preset:
    """Named settings; `key` is the name among the core's `PRESETS`, empty for a preset of the user."""

    name: str
    parameters: Parameters
    about: str = ""
    key: str = ""

    @property
    def own(self) -> bool:
        """Whether it is a preset of the user."""
        return not self.key


@cache
def built_in() -> tuple[Preset, ...]:
    """The presets of the program, for images."""
    presets = []
    for key, parameters in PLANE_PRESETS.items():
        name, about = _BUILT_IN[key]
        presets.append(Preset(name, parameters, about, key))
    return tuple(presets)


def checked_name(name: str) -> str:
    """A name without surplus spaces; ValueError when it is empty, too long, or that of a preset of the program."""
    name = " ".join(name.split())
    if not name:
        raise ValueError(tr("A preset needs a name: type one."))
    if len(name) > _LONGEST_NAME:
        message = tr("The name has {length} letters but a preset's may have {most} at most: shorten it.")
        raise ValueError(message.format(length=len(name), most=_LONGEST_NAME))
    if any(name == preset.name for preset in built_in()):
        raise ValueError(tr("“{name}” comes with the program: choose another name.").format(name=name))
    return name


def written(preset: Preset) -> bytes:
    """The content of a preset file."""
    kept = {
        "format": _FORMAT,
        "version": _VERSION,
        "name": preset.name,
        "about": preset.about,
        "parameters": asdict(preset.parameters),
    }
    return (json.dumps(kept, indent=1, ensure_ascii=False) + "\n").encode("utf-8")


def read(content: bytes, source: str) -> Preset:
    """The preset in a file, whose name is used in error messages.

    ValueError when it is not a valid preset file.
    """
    kept = _opened(content, source)
    version = kept.get("version")
    if not isinstance(version, int) or version < 1:
        raise ValueError(tr("{file} does not give its version: it is damaged.").format(file=source))
    if version > _VERSION:
        message = tr("{file} has version {version} but this program reads up to {most}: a newer CPM opens it.")
        raise ValueError(message.format(file=source, version=version, most=_VERSION))
    name, about = kept.get("name", ""), kept.get("about", "")
    if not (isinstance(name, str) and isinstance(about, str)):
        raise ValueError(tr("{file} is damaged: its name is not text.").format(file=source))
    try:
        if len(about) > _LONGEST_ABOUT:
            raise ValueError(tr("its description is too long."))
        return Preset(checked_name(name), _parameters(kept.get("parameters")), about)
    except (TypeError, ValueError) as error:
        raise ValueError(tr("{file} cannot be used: {reason}").format(file=source, reason=reason(error))) from error


def _opened(content: bytes, source: str) -> Mapping[str, Any]:
    try:
        kept = json.loads(content.decode("utf-8")) if len(content) <= _LARGEST else None
    except (UnicodeDecodeError, json.JSONDecodeError, RecursionError):
        kept = None
    if not isinstance(kept, dict) or kept.get("format") != _FORMAT:
        raise ValueError(
            tr("{file} is not a preset of CPM: choose a file that was exported as one.").format(file=source)
        )
    return kept


def _parameters(kept: object) -> Parameters:
    """Parameters from a file; missing ones have their defaults."""
    if not isinstance(kept, dict):
        raise ValueError(tr("it holds no parameters."))
    parameters, unknown = parameters_from_plain(kept)
    if unknown:
        raise ValueError(tr("there is no parameter {name}.").format(name=unknown[0]))
    return parameters
