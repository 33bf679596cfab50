"""Controls: sliders and choices by which the user sets parameters."""

from __future__ import annotations

import math
from dataclasses import asdict, replace

from cpm_app.model.text.language import localize_number, tr, translate_core_text
from cpm_app.model.text.wording import format_symbol
from cpm_core import PARAMETERS, Parameters
from cpm_core.numerics.types import JsonDict, Texts, frozen
from cpm_core.parameters import (
    AUTOMATIC_PARAMETERS,
    CHOICE_PARAMETERS,
    START_PARAMETERS,
    UNLIMITED_REACH,
    ParameterInfo,
)

RATIO_CONTROL = "ratio"
"""Name of the control of w₁/w₂."""

HIGHEST_RATIO = 0.99
"""Largest value of w₁/w₂."""

LOWEST_RATIO = 0.05
"""Smallest value of w₁/w₂."""

MAIN_CONTROLS = ("beta", RATIO_CONTROL, "annealing", *START_PARAMETERS, "smoothing", "polarity", "max_width", "pruning")
"""Names of the controls that are not folded away."""

_FULL_CONTRAST = 255.0
"""Contrast for which ranges of sliders in gray levels are made."""

AUTOMATIC_TEXTS = {
    "smoothing": tr("Choose the smoothing from the noise of the image."),
    "exponent": tr("Use the number of dimensions as the exponent: 2 in an image, 3 in a volume."),
    "gamma": tr("Choose gamma from the background of the image: below 1 where it is dark or bright, otherwise 1."),
}
"""Texts of the check boxes that let the program choose a value, by the names of their controls."""

_MANUAL_DEFAULTS = {"exponent": 2.0}
"""Values of `Control.manual_default`, by the names of their controls."""

_VALUE_WORDS = {
    "reach": ((UNLIMITED_REACH, tr("no limit")),),
    "polarity": ((-1.0, tr("dark")), (0.0, tr("auto")), (1.0, tr("light"))),
    "max_width": ((0.0, tr("auto")),),
}
"""Words for values, by the names of their controls."""

_VOLUME_TEXTS = {
    "pruning": ("r", tr("Length up to which a side branch is left out, in radii of what it branches from.")),
}
"""Units and meanings that differ in volumes, by the names of their controls."""

_EFFECT_TEXTS = {
    "contours": tr("Takes effect immediately."),
    "nothing": tr("Takes effect at the next step; particles at rest start moving again."),
    "field": tr("Takes effect at the next step, with a new field; particles at rest start moving again."),
    "run": tr("Takes effect from the next start."),
}
"""When a change takes effect, by what it invalidates."""


@frozen
class Control(ParameterInfo):
    """A slider: the core's description of a parameter, in the language of the window.

    Attributes
    ----------
    default : float or str
        Value with which work begins.
    """

    default: float | str = math.nan

    @property
    def effect_text(self) -> str:
        """When a change takes effect, in words."""
        return _EFFECT_TEXTS[self.invalidates]

    @property
    def can_be_automatic(self) -> bool:
        """Whether the program can choose it (``"auto"``)."""
        return self.name in AUTOMATIC_PARAMETERS

    @property
    def is_whole(self) -> bool:
        """Whether it takes only whole numbers."""
        return self.name == "scales"

    @property
    def manual_default(self) -> float | None:
        """Initial value where the program no longer chooses it by default."""
        return _MANUAL_DEFAULTS.get(self.name)

    @property
    def value_words(self) -> tuple[tuple[float, str], ...]:
        """Words for some of its values, shown in their place."""
        return _VALUE_WORDS.get(self.name, ())

    @property
    def decimals(self) -> int:
        """Number of decimals of its values, two or as many as its increment has."""
        return 0 if self.is_whole else max(2, -math.floor(math.log10(self.step)))

    @property
    def label(self) -> str:
        """Label of the slider, its name and symbol as rich text."""
        return f"{self.title} &nbsp;<span style='font-weight: normal'>{format_symbol(self.symbol)}</span>"

    @property
    def summary(self) -> str:
        """Symbol, equation, range of the slider with its unit and default in one line."""
        unit = f" {self.unit}" if self.unit else ""
        default = self.default if isinstance(self.default, str) else localize_number(f"{self.default:.3g}")
        span = tr(
            "{low} to {high}, default {default}",
            low=localize_number(f"{self.slider_low:g}"),
            high=localize_number(f"{self.slider_high:.3g}{unit}"),
            default=default,
        )
        return " · ".join(part for part in (self.symbol, self.equation, span) if part)


def build_controls() -> tuple[Control, ...]:
    """Build all controls in the order shown: main ones, those that decide which contours there are, advanced ones."""
    made = [_build_ratio_control() if name == "w1" else _build_control(name) for name in PARAMETERS]
    first = {name: place for place, name in enumerate(MAIN_CONTROLS)}
    return tuple(sorted(made, key=lambda one: (first.get(one.name, len(MAIN_CONTROLS)), one.advanced)))


def adapt_control(control: Control, initial: Parameters, ndim: int, contrast: float) -> Control:
    """Adapt a control to an image with `ndim` axes and this contrast, where work begins with `initial` values."""
    low, high = slider_range(control, contrast)
    step = control.step * (high - low) / (control.slider_high - control.slider_low)
    unit, meaning = control.unit, control.meaning
    if ndim == 3:
        unit, meaning = _VOLUME_TEXTS.get(control.name, (unit, meaning))
    return replace(
        control, slider_low=low, slider_high=high, step=step, default=control_value(initial, control.name), unit=unit,
        meaning=meaning,
    )  # fmt: skip


def slider_range(control: Control, contrast: float) -> tuple[float, float]:
    """Return the range of a slider; for parameters in gray levels it is scaled by the contrast of the image."""
    in_gray_levels = control.name in PARAMETERS and PARAMETERS[control.name].unit.startswith("gray")
    if not in_gray_levels or contrast <= 0:
        return control.slider_low, control.slider_high
    return control.slider_low, control.slider_high * contrast / _FULL_CONTRAST


def control_value(parameters: Parameters, name: str) -> float | str:
    """Return the value that the control `name` shows."""
    if name == RATIO_CONTROL:
        return parameters.w1 / parameters.w2
    return getattr(parameters, name)


def set_control_value(parameters: Parameters, name: str, value: float | str) -> Parameters:
    """Return the parameters with one control set; ``"w2"`` keeps the ratio, so that w₁ stays below it.

    ValueError when the value is out of its range.
    """
    if name == RATIO_CONTROL:
        if not isinstance(value, float | int) or not LOWEST_RATIO <= value <= HIGHEST_RATIO:
            raise ValueError(f"w1/w2 is {value} but must be a number from {LOWEST_RATIO:g} to {HIGHEST_RATIO:g}.")
        return replace(parameters, w1=value * parameters.w2)
    if name == "w2":
        weight = float(value)
        return replace(parameters, w2=weight, w1=min(parameters.w1 / parameters.w2, HIGHEST_RATIO) * weight)
    if name == "scales" and isinstance(value, float):
        value = round(value)
    fields: JsonDict = {name: value}
    return replace(parameters, **fields)


def _build_control(name: str) -> Control:
    values = asdict(PARAMETERS[name])
    texts = {
        part: translate_core_text(values[part]) for part in ("unit", "title", "meaning", "effect_of_larger", "equation")
    }
    return Control(**values | texts, default=control_value(Parameters(), name))


def _build_ratio_control() -> Control:
    return replace(
        _build_control("w1"),
        name=RATIO_CONTROL,
        default=control_value(Parameters(), RATIO_CONTROL),
        symbol="w₁/w₂",
        unit="",
        title=tr("Repulsion to attraction"),
        low=LOWEST_RATIO,
        high=HIGHEST_RATIO,
        slider_low=LOWEST_RATIO,
        slider_high=HIGHEST_RATIO,
        step=0.01,
        meaning=tr("Repulsion between particles as a fraction of the attraction by edges."),
        advanced=False,
    )


CHANNEL_CHOICE = "channel"
"""Name of the choice that only color images have."""

_CHOICE_TITLES = {
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


@frozen
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
    effect_text : str
        When a change takes effect, in words.
    """

    name: str
    title: str
    meaning: str
    choices: tuple[tuple[str, str, str], ...]
    effect_text: str

    @property
    def lines(self) -> Texts:
        """The explanation, one line for each choice."""
        effects = (tr("{choice}: {effect}", choice=title, effect=about) for _, title, about in self.choices)
        return (self.meaning, *effects, self.effect_text)


def build_choice_controls() -> tuple[ChoiceControl, ...]:
    """Build all choices in the order shown."""
    return tuple(
        ChoiceControl(
            name,
            translate_core_text(info.title),
            translate_core_text(info.meaning),
            tuple(
                (value, _CHOICE_TITLES.get(value, value), translate_core_text(about))
                for value, about in info.choices.items()
            ),
            _EFFECT_TEXTS[info.invalidates],
        )
        for name, info in CHOICE_PARAMETERS.items()
    )
