"""Reading options: the part of a file to read, by numbers from 1, and values that override those of the file."""

from __future__ import annotations

import dataclasses
from typing import Annotated

import numpy as np

from cpm_core.formats.common.content import UnreadableError
from cpm_core.formats.images import resolution
from cpm_core.image.colors import LUMINANCE_CHOICE, check_color_choice
from cpm_core.numerics.real_numbers import check_finite_number
from cpm_core.numerics.types import JsonDict, Texts, frozen
from cpm_core.parameters.formatting import quote_value


def check_unit(given: object) -> str | None:
    """Return the unit of length with this name, None for None; ValueError for any other name."""
    known = None if given is None else resolution.find_unit(str(given))
    if given is not None and known is None:
        raise ValueError(f"unit is {quote_value(given)} but must be nm, µm, mm, cm or m.")
    return known


@frozen
class Reading:
    """Options of `load_image` and `load_volume`; those that are None are left to the reader.

    Attributes
    ----------
    page : int or None
        Plane, page or frame to read as an image.
    channel, time : int or None
        Channel and point in time.
    series : int, str or None
        Series, by number or name; in an archive the array.
    color : str
        One of `COLOR_CHOICES`.
    spacing : tuple of float or None
        Size of a pixel along each axis, overriding that of the file.
    unit : str or None
        Unit of `spacing`.

    Raises
    ------
    ValueError
        When one of them is invalid.
    """

    page: int | None = None
    channel: int | None = None
    time: int | None = None
    series: int | str | None = None
    color: str = LUMINANCE_CHOICE
    spacing: Annotated[tuple[float, ...], 1, 2, 3] | None = None
    unit: str | None = None

    def __post_init__(self) -> None:
        for name in ("page", "channel", "time", "series"):
            given = getattr(self, name)
            if given is None or (name == "series" and isinstance(given, str)):
                continue
            if not isinstance(given, int | np.integer) or isinstance(given, bool) or given < 1:
                raise ValueError(f"{name} is {quote_value(given)} but must be a whole number from 1 up.")
            object.__setattr__(self, name, int(given))
        check_color_choice(self.color)
        if self.spacing is not None:
            sides = (
                check_finite_number("spacing", side, lambda number: number > 0.0, "numbers above 0")
                for side in self.spacing
            )
            object.__setattr__(self, "spacing", tuple(sides))
        if check_unit(self.unit) is not None and self.spacing is None:
            raise ValueError(
                f"unit is {quote_value(self.unit)} but there is no spacing: give the size of a pixel as well."
            )

    @property
    def arguments(self) -> JsonDict:
        """Options that differ from the default, by name."""
        fields = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        return {
            name: given for name, given in fields.items() if given is not None and given != _DEFAULT_ARGUMENTS[name]
        }


DEFAULT_READING = Reading()
"""Leaves everything to the reader."""

_DEFAULT_ARGUMENTS = {field.name: field.default for field in dataclasses.fields(Reading)}
"""Default of every argument, by name."""


def select_index(what: str, wanted: int | None, count: int, default: int, name: str) -> int:
    """Return the index, from 0, of part number `wanted`, or `default` for None; UnreadableError beyond `count`."""
    if wanted is None:
        return default
    if wanted > count:
        one = "1" if count == 1 else f"1 to {count}"
        raise UnreadableError(f"{what} is {wanted}, but {name} has {count} of them: choose {one}.")
    return wanted - 1


def select_series(reading: Reading, names: Texts, file: str, default: int = 0) -> int:
    """Return the index of the series that is wanted by number or name; UnreadableError if there is none."""
    wanted = reading.series
    if isinstance(wanted, str):
        if wanted in names:
            return names.index(wanted)
        known = ", ".join(map(quote_value, names[:9])) + (", …" if len(names) > 9 else "")
        raise UnreadableError(f"series is {quote_value(wanted)}, but {file} has {known}: choose one of these.")
    return select_index("series", wanted, len(names), default, file)
