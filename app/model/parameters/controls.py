"""Controls: sliders and choices, by which the user sets parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from app.model.text.language import from_core, tr, written
from app.model.text.wording import FORMULAS, Wording, rich
from cpm_core import PARAMETERS, Parameters
from cpm_core.parameters import AUTOMATIC, CHOICES, DEFAULTS, OF_STARTS, Invalidates

RATIO = "ratio"
HIGHEST_RATIO = 0.99
LOWEST_RATIO = 0.05

_FULL_CONTRAST = 255.0

_BY_ITSELF = {
    "smoothing": tr("Set the smoothing from the noise of the image."),
    "exponent": tr("Set the exponent to the number of dimensions: 2 in an image, 3 in a volume."),
    "gamma": tr("Set gamma from the background of the image: below 1 where it is dark or bright, else 1."),
}


@dataclass(frozen=True, slots=True)
class Control:
    """One slider with its texts.

    Attributes
    ----------
    name : str
        Field of `Parameters`, or ``"ratio"`` for w₁/w₂.
    symbol, unit, title : str
        Its label.
    low, high : float
        Values that may be typed.
    slider_low, slider_high, step : float
        Range and increment of the slider.
    default : float or str
        Default value.
    meaning, more, equation : str
        What it is, what a larger value does, and its equation.
    advanced : bool
        Whether it is hidden at first.
    acts : str
        When a change acts, in words.
    automatic : bool
        Whether the program can choose it (``"auto"``).
    whole : bool
        Whether it takes only whole numbers.
    moves : bool
        Whether it only changes how particles move.
    by_hand : float or None
        Value with which it begins where the program no longer chooses it by default.
    words : tuple of (float, str)
        Words for some of its values, shown in their place.
    """

    name: str
    symbol: str
    unit: str
    title: str
    low: float
    high: float
    slider_low: float
    slider_high: float
    step: float
    default: float | str
    meaning: str
    more: str
    equation: str
    advanced: bool
    acts: str
    automatic: bool = False
    whole: bool = False
    moves: bool = False
    by_hand: float | None = None
    words: tuple[tuple[float, str], ...] = ()

    @property
    def decimals(self) -> int:
        """Number of decimals of its values, two or as many as its increment has."""
        return 0 if self.whole else max(2, -math.floor(math.log10(self.step)))

    @property
    def by_itself(self) -> str:
        """How the program chooses it; empty where it cannot."""
        return _BY_ITSELF.get(self.name, "")

    @property
    def formula(self) -> str:
        """Its formula, as rich text."""
        return FORMULAS[self.name]

    @property
    def rich_symbol(self) -> str:
        """Its symbol as rich text."""
        return rich(self.symbol)

    def label(self, wording: Wording) -> str:
        """Label of the slider, as rich text: its name and symbol, or its symbol and name."""
        if wording == "name":
            return f"{self.title} &nbsp;<span style='font-weight: normal'>{self.rich_symbol}</span>"
        return f"{self.rich_symbol} &nbsp;{self.title}"

    @property
    def span(self) -> str:
        """Allowed values with their unit, and the default."""
        unit = f" {self.unit}" if self.unit else ""
        default = self.default if isinstance(self.default, str) else written(f"{self.default:.3g}")
        if self.high >= 1e6:
            return tr("{low} or more, default {default}").format(low=written(f"{self.low:g}{unit}"), default=default)
        return tr("{low} to {high}, default {default}").format(
            low=written(f"{self.low:g}"), high=written(f"{self.high:g}{unit}"), default=default
        )

    @property
    def in_gray_levels(self) -> bool:
        """Whether its unit is gray levels, so that its values depend on the image."""
        return PARAMETERS[self.name].unit.startswith("gray") if self.name in PARAMETERS else False

    @property
    def facts(self) -> str:
        """Symbol, equation, range and default in one line."""
        return " · ".join(part for part in (self.symbol, self.equation, self.span) if part)


_BY_HAND: Mapping[str, float] = MappingProxyType({"exponent": 2.0})
"""Values for `Control.by_hand` by the names of their controls."""

_WORDS: Mapping[str, tuple[tuple[float, str], ...]] = MappingProxyType(
    {
        "polarity": ((-1.0, tr("dark")), (0.0, tr("auto")), (1.0, tr("light"))),
        "max_width": ((0.0, tr("auto")),),
    }
)
"""Words for values by the names of their controls."""

_IN_VOLUMES: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "pruning": (
            "r",
            tr("Length up to which a side branch is left out, in radii of what it branches from."),
        ),
    }
)
"""Units and meanings that differ in volumes, by the names of their controls."""

_ACTS = {
    "contours": tr("Acts at once, on particles at rest too."),
    "nothing": tr("Acts at the next step."),
    "field": tr("Acts at the next step, with a new edge map and field."),
    "run": tr("Acts from the next start on."),
}


def acts(invalidates: Invalidates) -> str:
    """When a change of a parameter acts, in words."""
    return _ACTS[invalidates]


def controls() -> tuple[Control, ...]:
    """All controls in the order shown: how far a start reaches, the motion, which contours there are, advanced ones."""
    made = [_ratio() if name == "w1" else _of_parameter(name) for name in PARAMETERS]
    return tuple(sorted(made, key=lambda control: (control.advanced, control.name not in OF_STARTS, not control.moves)))


def in_dimension(control: Control, ndim: int) -> Control:
    """A control as it is in an image, or in a volume, which has three axes."""
    if ndim < 3 or control.name not in _IN_VOLUMES:
        return control
    unit, meaning = _IN_VOLUMES[control.name]
    return replace(control, unit=unit, meaning=meaning)


def slider_range(control: Control, contrast: float) -> tuple[float, float]:
    """Range of the slider; that of parameters in gray levels is scaled by the contrast of the image."""
    if not control.in_gray_levels or contrast <= 0:
        return control.slider_low, control.slider_high
    return control.slider_low, control.slider_high * contrast / _FULL_CONTRAST


def value_of(parameters: Parameters, name: str) -> float | str:
    """Value that the control `name` shows."""
    if name == RATIO:
        return parameters.w1 / parameters.w2
    value: float | str = getattr(parameters, name)
    return value


def with_value(parameters: Parameters, name: str, value: float | str) -> Parameters:
    """Parameters with one control set; ``"w2"`` keeps the ratio, so that w₁ stays below it.

    ValueError when the value is out of its range.
    """
    if name == RATIO:
        if not isinstance(value, float | int) or not LOWEST_RATIO <= value <= HIGHEST_RATIO:
            raise ValueError(f"w1/w2 is {value} but must be a number from {LOWEST_RATIO:g} to {HIGHEST_RATIO:g}.")
        return replace(parameters, w1=value * parameters.w2)
    if name == "w2":
        weight = float(value)
        return replace(parameters, w2=weight, w1=min(parameters.w1 / parameters.w2, HIGHEST_RATIO) * weight)
    if name == "scales" and isinstance(value, float):
        value = round(value)
    fields: dict[str, Any] = {name: value}
    return replace(parameters, **fields)


def _of_parameter(name: str) -> Control:
    info = PARAMETERS[name]
    return Control(
        name=name,
        symbol=info.symbol,
        unit=from_core(info.unit),
        title=from_core(info.title),
        low=info.low,
        high=info.high,
        slider_low=info.slider_low,
        slider_high=info.slider_high,
        step=info.step,
        default=DEFAULTS[name],
        meaning=from_core(info.meaning),
        more=from_core(info.more),
        equation=from_core(info.equation),
        advanced=info.advanced,
        acts=acts(info.invalidates),
        automatic=name in AUTOMATIC,
        whole=name == "scales",
        moves=info.invalidates == "nothing",
        by_hand=_BY_HAND.get(name),
        words=_WORDS.get(name, ()),
    )


def _ratio() -> Control:
    standard = Parameters()
    return replace(
        _of_parameter("w1"),
        name=RATIO,
        symbol="w₁/w₂",
        unit="",
        title=tr("Repulsion to attraction"),
        low=LOWEST_RATIO,
        high=HIGHEST_RATIO,
        slider_low=LOWEST_RATIO,
        slider_high=HIGHEST_RATIO,
        step=0.01,
        default=standard.w1 / standard.w2,
        meaning=tr("Repulsion between particles as a fraction of the attraction by edges."),
        advanced=False,
        moves=True,
    )


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
