"""Parameters whose values are names, each defined once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from cpm_core.parameters.formatting import quote_value, suggest_name

Invalidates = Literal["nothing", "contours", "field", "run"]
Edges = Literal["gradient", "vessels"]
Accuracy = Literal["standard", "exact"]
Channel = Literal["luminance", "red", "green", "blue", "hematoxylin", "eosin", "dab"]


@dataclass(frozen=True)
class ChoiceInfo:
    """Description of a parameter whose values are names.

    Attributes
    ----------
    name : str
        Field of `Parameters`.
    title : str
        Short name for a label.
    meaning : str
        One sentence: what it is.
    choices : dict
        The values, each with a sentence that says what it does; the first one is the default.
    invalidates : {"nothing", "contours", "field", "run"}
        What a change makes out of date, as in `ParameterInfo`.
    """

    name: str
    title: str
    meaning: str
    choices: dict[str, str]
    invalidates: Invalidates


CHOICE_PARAMETERS = {
    "edges": ChoiceInfo(
        "edges", "Edges from", "Where edges are found.",
        {
            "gradient": "Finds the edges of the gray levels.",
            "vessels": "Finds the edges of a vessel measure, which is large where something is long and thin, darker "
            "or brighter than its surroundings.",
        },
        "field",
    ),
    "accuracy": ChoiceInfo(
        "accuracy", "Accuracy of the field",
        "How exactly the field of the fixed charges of a volume is computed; that of an image is always exact.",
        {
            "standard": "Computes it in a volume from blocks of two voxels, in a third of the time: half of all "
            "directions are off by less than 2 degrees up to 3 voxels from edges, by less than 0.2 degrees up to 10; "
            "on edges the slope of the edge map takes its place.",
            "exact": "Computes it from every voxel, exactly.",
        },
        "field",
    ),
    "channel": ChoiceInfo(
        "channel", "Channel", "The part of a color image in which edges are found; gray images have no channels.",
        {
            "luminance": "Uses the brightness of the colors as the eye sees it.",
            "red": "Uses the red channel.",
            "green": "Uses the green channel.",
            "blue": "Uses the blue channel.",
            "hematoxylin": "Uses the light that hematoxylin alone lets through, which stains nuclei blue.",
            "eosin": "Uses the light that eosin alone lets through, which stains what surrounds nuclei pink.",
            "dab": "Uses the light that DAB alone lets through, which stains what antibodies mark brown.",
        },
        "field",
    ),
}  # fmt: skip
"""Parameters whose values are names."""


def check_choice(info: ChoiceInfo, value: object) -> None:
    """Raise a `ValueError` that names field, value and choices unless `value` is one of them."""
    if not isinstance(value, str) or value not in info.choices:
        names = " or ".join(f'"{name}"' for name in info.choices)
        near = suggest_name(str(value), info.choices)
        raise ValueError(f"{info.name} is {quote_value(value)} but must be {names}{f': {near}' if near else '.'}")
