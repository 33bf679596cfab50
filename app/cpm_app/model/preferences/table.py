"""Preferences: their kinds, and the table of all of them."""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import chain
from typing import Any, Generic, TypeVar

from cpm_app.model.display.lengths import UNIT_TITLES
from cpm_app.model.text import language
from cpm_app.model.text.language import tr
from cpm_core import MODELS

ValueT = TypeVar("ValueT")

_COLOR_PATTERN = re.compile(r"#[0-9a-f]{6}")


@dataclass(frozen=True, kw_only=True)
class Preference(ABC, Generic[ValueT]):
    """One preference.

    Attributes
    ----------
    name : str
        Its key in the file of the preferences.
    label : str
        Words before its field.
    default
        Its value until the user chooses another one.
    note : str
        A sentence below the field.
    """

    name: str
    label: str
    default: ValueT
    note: str = ""

    @abstractmethod
    def parse_stored(self, stored: object) -> ValueT | None:
        """Parse a stored value, perhaps text; None if it is none of this kind."""


@dataclass(frozen=True, kw_only=True)
class FlagPreference(Preference[bool]):
    """Something that is on or off; `text` is next to the check box."""

    text: str

    def parse_stored(self, stored: object) -> bool | None:
        """Parse true or false, also as text."""
        return {"true": True, "false": False}.get(str(stored).lower())


@dataclass(frozen=True, kw_only=True)
class NumberPreference(Preference[float]):
    """A number from `low` to `high` in increments of `step`, with the unit `suffix`."""

    low: float
    high: float
    step: float
    decimals: int = 0
    suffix: str = ""

    def parse_stored(self, stored: object) -> float | None:
        """Parse a number within the limits."""
        try:
            number = float(str(stored))
        except ValueError:
            return None
        return number if math.isfinite(number) and self.low <= number <= self.high else None


@dataclass(frozen=True, kw_only=True)
class ChoicePreference(Preference[str]):
    """One of several alternatives, `choices`: names and titles."""

    choices: Mapping[str, str]

    def parse_stored(self, stored: object) -> str | None:
        """Parse the name of an alternative."""
        return stored if isinstance(stored, str) and stored in self.choices else None


@dataclass(frozen=True, kw_only=True)
class TextPreference(Preference[str]):
    """A text on one line."""

    def parse_stored(self, stored: object) -> str | None:
        """Parse a text."""
        return stored if isinstance(stored, str) else None


@dataclass(frozen=True, kw_only=True)
class ColorPreference(Preference[str]):
    """A color, as ``"#rrggbb"``."""

    def parse_stored(self, stored: object) -> str | None:
        """Parse a color of six digits."""
        return stored if isinstance(stored, str) and _COLOR_PATTERN.fullmatch(stored) else None


PAGE_TITLES = {
    "general": tr("General"),
    "appearance": tr("Lines and colors"),
    "objects": tr("Objects"),
    "files": tr("Files"),
    "run": tr("Run"),
    "shortcuts": tr("Shortcuts"),
}
"""Titles of the pages of the dialog by name, in their order."""

LANGUAGE_PREFERENCE = ChoicePreference(
    name=language.LANGUAGE_KEY, label=tr("Language"), default=language.SYSTEM_LANGUAGE,
    choices={language.SYSTEM_LANGUAGE: tr("System"), **language.list_languages()},
    note=tr("The language changes when you restart the program."),
)  # fmt: skip
THEME_PREFERENCE = ChoicePreference(
    name="theme", label=tr("Theme"), default="system",
    choices={"system": tr("System"), "light": tr("Light"), "dark": tr("Dark")},
)  # fmt: skip
UNIT_PREFERENCE = ChoicePreference(
    name="units", label=tr("Lengths and areas"), default="image", choices=UNIT_TITLES,
    note=tr("In tables, the Run panel, the status bar and the scale bar. Without a known pixel size, "
            "lengths are in px."),
)  # fmt: skip
WHEEL_PREFERENCE = ChoicePreference(
    name="volumes/wheel", label=tr("Wheel"), default="scrolls",
    choices={"scrolls": tr("Scrolls slices"), "zooms": tr("Zooms")},
    note=tr("In the slices of a volume; with Ctrl, it does the other."),
)  # fmt: skip

CONTOUR_WIDTH = NumberPreference(
    name="canvas/contour_width", label=tr("Contour width"), default=2.0, low=0.5, high=5.0,
    step=0.25, decimals=2, suffix=" px",
)  # fmt: skip
SHAPE_WIDTH = NumberPreference(
    name="canvas/shape_width", label=tr("Shape width"), default=1.4, low=0.5, high=5.0,
    step=0.1, decimals=1, suffix=" px",
)  # fmt: skip
POINT_SIZE = NumberPreference(
    name="canvas/point_size", label=tr("Particle size"), default=7.0, low=3.0, high=20.0,
    step=0.5, decimals=1, suffix=" px", note=tr("Particles shrink when the image is zoomed out."),
)  # fmt: skip

INK_PREFERENCES = {
    name: ColorPreference(name=f"colors/{name}", label=label, default=color)
    for name, label, color in (
        ("contour", tr("Contours"), "#eceff3"),
        ("proposal", tr("Proposed objects"), "#62a8ff"),
        ("by_hand", tr("Drawn by hand"), "#c4f042"),
        ("moving", tr("Moving particles"), "#f0e442"),
        ("resting", tr("Particles at rest"), "#2bd4a4"),
    )
}
"""Colors on the canvas; people who cannot distinguish red and green can distinguish the defaults."""

AUTOSAVE_PREFERENCE = FlagPreference(
    name="autosave/on", label=tr("Autosave"), default=True, text=tr("Keep unsaved work for recovery"),
    note=tr("After a crash, the next start offers to restore it."),
)  # fmt: skip
SAVE_IN_FOLDER = FlagPreference(
    name="files/save_in_folder", label=tr("Next image in the folder"), default=False,
    text=tr("Save without asking"), note=tr("The session is saved next to the image, under the same name."),
)  # fmt: skip
KEEP_PARAMETERS = FlagPreference(
    name="parameters/keep", label=tr("Next image"), default=False,
    text=tr("Keep parameters for the next image"),
)  # fmt: skip
OFFER_SETTINGS = FlagPreference(
    name="parameters/offer", label=tr("Kind of image"), default=True,
    text=tr("Suggest settings for the kind of image"),
    note=tr("Fluorescence, angiograms and ultrasound are recognized by their gray levels."),
)  # fmt: skip
TIMELINE_MEMORY = NumberPreference(
    name="timeline/megabytes", label=tr("Memory for steps"), default=256.0, low=16, high=16384, step=64,
    suffix=tr(" MB"),
    note=tr("Maximum memory for the steps of a run. When it is full, fewer steps are stored, evenly spaced; the steps "
            "between them are recomputed exactly."),
)  # fmt: skip

OWN_MODEL = "folder"
"""Choice of the model in the folder that the user names."""

MODEL_PREFERENCE = ChoicePreference(
    name="objects/model", label=tr("Answers to clicks"), default="",
    choices={"": tr("Network of the program"), **{name: one.summary for name, one in MODELS.items()},
             OWN_MODEL: tr("ONNX files in the folder below")},
    note=tr("Larger models answer in images. They need the extra sam and are fetched once, on request; images stay on "
            "this computer."),
)  # fmt: skip
MODEL_FOLDER = TextPreference(
    name="objects/model_folder", label=tr("Folder of a model"), default="",
    note=tr("With two files: *encoder*.onnx and *decoder*.onnx."),
)  # fmt: skip
SERVER_ADDRESS = TextPreference(
    name="objects/server", label=tr("Server for volumes"), default="",
    note=tr("Address of a server of nnInteractive, http://…, which answers clicks in volumes and needs the extra "
            "server. Volumes are sent there; without an address, nothing is sent."),
)  # fmt: skip

PREFERENCES_BY_PAGE: Mapping[str, tuple[Preference[Any], ...]] = {
    "general": (LANGUAGE_PREFERENCE, THEME_PREFERENCE, UNIT_PREFERENCE, WHEEL_PREFERENCE),
    "appearance": (CONTOUR_WIDTH, SHAPE_WIDTH, POINT_SIZE, *INK_PREFERENCES.values()),
    "objects": (MODEL_PREFERENCE, MODEL_FOLDER, SERVER_ADDRESS),
    "files": (AUTOSAVE_PREFERENCE, SAVE_IN_FOLDER),
    "run": (KEEP_PARAMETERS, OFFER_SETTINGS, TIMELINE_MEMORY),
}
"""Preferences on each page of the dialog, in its order."""

ALL_PREFERENCES = tuple(chain(*PREFERENCES_BY_PAGE.values()))
"""All preferences, in the order of the dialog."""
