"""Settings: the parameters of a method, each with its range and words, as those of the charged particles have them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from cpm_core.parameters import ParameterInfo
from cpm_core.parameters.quotation import shown

Span = tuple[float, float]
"""Lowest and highest value."""

_INFO = "info"


def number(
    default: float,
    symbol: str,
    title: str,
    meaning: str,
    more: str,
    limits: Span,
    slider: Span,
    step: float,
    unit: str = "",
    equation: str = "",
    advanced: bool = False,
) -> Any:
    """A field of `Settings`: its default value, and what `ParameterInfo` says of it; a whole default, whole values."""
    info = ParameterInfo(
        "", symbol, unit, *limits, *slider, step, title, meaning, more, equation, "run", advanced
    )  # fmt: skip
    return field(default=default, metadata={_INFO: info})


@dataclass(frozen=True)
class Settings:
    """Values of the parameters of a method; a subclass is a frozen dataclass of fields made by `number`.

    Raises
    ------
    ValueError
        When a value lies outside its range; the message names the field, the value and the range.
    """

    def __post_init__(self) -> None:
        for name, info in self.table().items():
            value = getattr(self, name)
            if isinstance(value, np.generic):
                value = value.item()
                object.__setattr__(self, name, value)
            whole = isinstance(getattr(type(self), name), int)
            real = isinstance(value, (int, float)) and not isinstance(value, bool)
            if not (real and info.low <= value <= info.high and (not whole or value == int(value))):
                kind = "a whole number" if whole else "a number"
                raise ValueError(f"{name} is {shown(value)} but must be {kind} from {info.low:g} to {info.high:g}.")

    @classmethod
    def table(cls) -> Mapping[str, ParameterInfo]:
        """What is said of each parameter, by name."""
        described = {one.name: one.metadata[_INFO] for one in fields(cls)}
        return MappingProxyType({name: replace(info, name=name) for name, info in described.items()})

    @property
    def values(self) -> dict[str, float]:
        """The value of each parameter, by name."""
        return {name: getattr(self, name) for name in self.table()}
