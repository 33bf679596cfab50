"""Presets: named settings of all parameters, built in or by the user, and their files."""

from __future__ import annotations

import json
from dataclasses import asdict
from functools import cache

from cpm_app.model.text.language import tr
from cpm_core import Parameters
from cpm_core.formats import parameters_from_json
from cpm_core.numerics.types import frozen
from cpm_core.parameters import PLANE_PRESETS

PRESET_SUFFIX = ".cpmpreset"
"""Suffix of preset files."""

_MAX_NAME_LENGTH = 60
"""Largest number of letters in a name."""

_MAX_ABOUT_LENGTH = 1000
"""Largest number of letters in a description."""

_BUILT_IN_TEXTS = {
    "shape": (tr("Shape recovery"), tr("Finds the whole outline of an object from a start in or around it.")),
    "automatic": (tr("Automatic segmentation"), tr("Starts everywhere and keeps the contours of clear edges.")),
    "vessels": (
        tr("Vessels"),
        tr("Finds both sides of anything long and thin, darker or brighter than its surroundings."),
    ),
    "noisy": (tr("Noisy image"), tr("Chooses the smoothing from the noise of the image.")),
    "published": (tr("As published"), tr("The values of the publication.")),
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
"""Names and descriptions, by the names of the core's `PRESETS`."""


@frozen
class Preset:
    """Named settings; `key` is the name among the core's `PRESETS`, empty for a preset of the user."""

    name: str
    parameters: Parameters
    about: str = ""
    key: str = ""

    @property
    def is_own(self) -> bool:
        """Whether it is a preset of the user."""
        return not self.key


@cache
def built_in_presets() -> tuple[Preset, ...]:
    """Return the presets of the program, for images."""
    return tuple(
        Preset(_BUILT_IN_TEXTS[key][0], known, _BUILT_IN_TEXTS[key][1], key) for key, known in PLANE_PRESETS.items()
    )


def check_preset_name(name: str) -> str:
    """Return a name without surplus spaces; ValueError if it is empty, too long, or that of a built-in preset."""
    name = " ".join(name.split())
    if not name:
        raise ValueError(tr("A preset needs a name: type one."))
    if len(name) > _MAX_NAME_LENGTH:
        message = tr("The name has {length} characters, but at most {most} are allowed: shorten it.")
        raise ValueError(message.format(length=len(name), most=_MAX_NAME_LENGTH))
    if any(name == preset.name for preset in built_in_presets()):
        raise ValueError(tr("“{name}” is built in: choose another name.", name=name))
    return name


def encode_preset(preset: Preset) -> bytes:
    """Encode a preset as the content of a file."""
    kept = {"name": preset.name, "about": preset.about, "parameters": asdict(preset.parameters)}
    return (json.dumps(kept, indent=1, ensure_ascii=False) + "\n").encode("utf-8")


def decode_preset(content: bytes) -> Preset:
    """Decode a preset from the content of a file; ValueError if there is none. Missing parameters have defaults."""
    try:
        kept = json.loads(content.decode("utf-8"))
        parameters, _ = parameters_from_json(kept["parameters"])
        return Preset(check_preset_name(str(kept["name"])), parameters, str(kept.get("about", ""))[:_MAX_ABOUT_LENGTH])
    except (AttributeError, KeyError, TypeError, RecursionError) as error:
        raise ValueError("not a preset of CPM") from error
