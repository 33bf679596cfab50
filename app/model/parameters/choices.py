"""The parameters whose values are names, as controls with their words."""

from __future__ import annotations

from dataclasses import dataclass

from app.model.parameters.controls import acts
from app.model.text.language import from_core, tr
from cpm_core.parameters.choices import CHOICES

CHANNEL = "channel"
"""Name of the choice that only color images have."""

_TITLES = {
    "gradient": tr("gray levels"),
    "vessels": tr("vessels"),
    "standard": tr("standard"),
    "exact": tr("exact"),
    "luminance": tr("luminance"),
    "red": tr("red"),
    "green": tr("green"),
    "blue": tr("blue"),
    "hematoxylin": tr("hematoxylin"),
    "eosin": tr("eosin"),
    "dab": tr("DAB"),
}
"""Names of the values in the window."""


@dataclass(frozen=True, slots=True)
class ChoiceControl:
    """One choice with its texts.

    Attributes
    ----------
    name : str
        Field of `Parameters`.
    title, meaning : str
        Its label, and one sentence that says what it is.
    choices : tuple
        Value, name in the window, and effect of each choice.
    acts : str
        When a change acts, in words.
    """

    name: str
    title: str
    meaning: str
    choices: tuple[tuple[str, str, str], ...]
    acts: str

    @property
    def lines(self) -> tuple[str, ...]:
        """The explanation, one line for each choice."""
        effects = (tr("{choice}: {effect}").format(choice=title, effect=about) for _, title, about in self.choices)
        return (self.meaning, *effects, self.acts)

    @property
    def explanation(self) -> str:
        """The explanation as one text."""
        return " ".join(self.lines)


def choice_controls() -> tuple[ChoiceControl, ...]:
    """All choices in the order shown."""
    return tuple(
        ChoiceControl(
            name,
            from_core(info.title),
            from_core(info.meaning),
            tuple((value, _TITLES.get(value, value), from_core(about)) for value, about in info.choices.items()),
            acts(info.invalidates),
        )
        for name, info in CHOICES.items()
    )
