"""Kinds of preferences: each knows which stored values it accepts."""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

V = TypeVar("V")

LONGEST_PATH = 4096
"""Letters that a path may have."""

_COLOR = re.compile(r"#[0-9a-f]{6}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Preference(ABC, Generic[V]):
    """One preference.

    Attributes
    ----------
    name : str
        Its key in the file of the preferences.
    page : str
        Name of the page of the dialog that it stands on.
    label : str
        Words before its field.
    default
        Its value until the user chooses another one.
    note : str
        A sentence below the field.
    needs : tuple, optional
        Another preference, and the value of it without which this one has no effect.
    """

    name: str
    page: str
    label: str
    default: V
    note: str = ""
    needs: tuple[Preference[Any], object] | None = None

    @abstractmethod
    def taken(self, stored: object) -> V | None:
        """The value that a file holds, perhaps as text; None when it is none of this kind."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Flag(Preference[bool]):
    """Something that is on or off; `text` stands beside the check box."""

    text: str

    def taken(self, stored: object) -> bool | None:
        """True or false, also as text."""
        return {True: True, False: False, "true": True, "false": False}.get(stored) if _plain(stored) else None


@dataclass(frozen=True, slots=True, kw_only=True)
class Number(Preference[float]):
    """A number from `low` to `high` in increments of `step`, with the unit `suffix`."""

    low: float
    high: float
    step: float
    decimals: int = 0
    suffix: str = ""

    def taken(self, stored: object) -> float | None:
        """A number within the limits."""
        if not _plain(stored) or isinstance(stored, bool):
            return None
        try:
            number = float(str(stored))
        except ValueError:
            return None
        return number if math.isfinite(number) and self.low <= number <= self.high else None


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice(Preference[str]):
    """One of several alternatives, `ways`: names and titles."""

    ways: Mapping[str, str]

    def taken(self, stored: object) -> str | None:
        """The name of an alternative."""
        return stored if isinstance(stored, str) and stored in self.ways else None


@dataclass(frozen=True, slots=True, kw_only=True)
class Color(Preference[str]):
    """A color, as ``"#rrggbb"``."""

    def taken(self, stored: object) -> str | None:
        """A color of six digits."""
        return stored if isinstance(stored, str) and _COLOR.fullmatch(stored) else None


@dataclass(frozen=True, slots=True, kw_only=True)
class Folder(Preference[str]):
    """Path of a folder, empty for none."""

    def taken(self, stored: object) -> str | None:
        """Any path that a system may have; whether the folder exists is asked where it is used."""
        return stored if isinstance(stored, str) and len(stored) <= LONGEST_PATH else None


def _plain(stored: object) -> bool:
    """Whether a stored value is a single one; a list cannot be looked up in a mapping."""
    return isinstance(stored, str | int | float)
