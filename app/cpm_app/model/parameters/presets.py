"""Presets: named settings of all parameters, those of the program and those of the user, and their files."""

from __future__ import annotations

import json
from dataclasses import asdict
from functools import cache

from cpm_app.model.text.language import tr
from cpm_core import Parameters
from cpm_core.formats import parameters_from_plain
from cpm_core.numerics.types import frozen
from cpm_core.parameters import PLANE_PRESETS

SUFFIX = ".cpmpreset"

_LONGEST_NAME, _LONGEST_ABOUT = 60, 1000
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


@frozen
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
    return tuple(Preset(_BUILT_IN[key][0], known, _BUILT_IN[key][1], key) for key, known in PLANE_PRESETS.items())


def checked_name(name: str) -> str:
    """A name without surplus spaces; ValueError when it is empty, too long, or that of a preset of the program."""
    name = " ".join(name.split())
    if not name:
        raise ValueError(tr("A preset needs a name: type one."))
    if len(name) > _LONGEST_NAME:
        message = tr("The name has {length} characters, but at most {most} are allowed: shorten it.")
        raise ValueError(message.format(length=len(name), most=_LONGEST_NAME))
    if any(name == preset.name for preset in built_in()):
        raise ValueError(tr("“{name}” is built in: choose another name.", name=name))
    return name


def written(preset: Preset) -> bytes:
    """The content of a preset file."""
    kept = {"name": preset.name, "about": preset.about, "parameters": asdict(preset.parameters)}
    return (json.dumps(kept, indent=1, ensure_ascii=False) + "\n").encode("utf-8")


def read(content: bytes) -> Preset:
    """The preset in a file; parameters that it lacks have their defaults. ValueError when there is none in it."""
    try:
        kept = json.loads(content.decode("utf-8"))
        parameters, _ = parameters_from_plain(kept["parameters"])
        return Preset(checked_name(str(kept["name"])), parameters, str(kept.get("about", ""))[:_LONGEST_ABOUT])
    except (AttributeError, KeyError, TypeError, RecursionError) as error:
        raise ValueError("not a preset of CPM") from error
