"""Presets: named settings of all parameters, those of the program and those of the user, and their files."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from functools import cache

from app.model.text.language import reason, tr
from cpm_core import Parameters
from cpm_core.formats import parameters_from_plain
from cpm_core.parameters import PLANE_PRESETS, shown

SUFFIX = ".cpmpreset"

_FORMAT, _VERSION = "CPM preset", 1
_LONGEST_NAME, _LONGEST_ABOUT = 60, 1000
_LARGEST = 4_000_000
"""Maximum length of a preset file [bytes]."""

_BUILT_IN = {
    "shape": (tr("Shape recovery"), tr("Finds the whole outline of an object from a start in or around it.")),
    "automatic": (tr("Automatic segmentation"), tr("Starts everywhere and keeps the contours of clear edges.")),
    "vessels": (
        tr("Vessels"),
        tr("Finds both sides of anything long and thin, darker or brighter than its surroundings."),
    ),
    "noisy": (tr("Noisy image"), tr("Chooses the smoothing from the noise of the image.")),
    "fluorescence": (
        tr("Fluorescence"),
        tr("Finds bright objects on a dark background, without their texture."),
    ),
    "angiogram": (tr("Angiogram"), tr("Finds vessels filled with contrast medium, and leaves out faint lines.")),
    "ultrasound": (
        tr("Ultrasound"),
        tr("Finds the strongest outlines in a heavily smoothed image, without speckle."),
    ),
}


@dataclass(frozen=True)
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
        message = tr("The name has {length} characters, but at most {most} are allowed: shorten it.")
        raise ValueError(message.format(length=len(name), most=_LONGEST_NAME))
    if any(name == preset.name for preset in built_in()):
        raise ValueError(tr("“{name}” is built in: choose another name.").format(name=name))
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

    Parameters that the file lacks have their defaults. ValueError when it is not a valid preset file.
    """
    try:
        kept = json.loads(content.decode("utf-8")) if len(content) <= _LARGEST else {}
        known = kept["format"] == _FORMAT and isinstance(kept["parameters"], dict)
    except (ValueError, TypeError, KeyError, RecursionError):
        known = False
    if not known:
        message = tr("{file} is not a preset of CPM: choose a file that was exported as one.")
        raise ValueError(message.format(file=source))
    if kept.get("version") != _VERSION:
        message = tr("{file} has version {version}, but this program reads version {most}.")
        raise ValueError(message.format(file=source, version=shown(kept.get("version")), most=_VERSION))
    try:
        parameters, unknown = parameters_from_plain(kept["parameters"])
        if unknown:
            raise ValueError(tr("there is no parameter {name}.").format(name=unknown[0]))
        return Preset(checked_name(str(kept["name"])), parameters, str(kept.get("about", ""))[:_LONGEST_ABOUT])
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise ValueError(tr("{file} cannot be used: {reason}").format(file=source, reason=reason(error))) from error
