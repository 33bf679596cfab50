"""Image: the grey levels that a run works on, and what is known about their origin."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

MINIMUM_SIDE = 8
"""Least number of pixels along each axis [px]: below it no edge can be told from the border."""


@dataclass(frozen=True, eq=False)
class Image:
    """Grey levels on a regular grid, pixel centres at integer (row, col).

    Parameters
    ----------
    values : array_like of real numbers, shape (H, W)
        Grey levels. They are copied to float64 and can then no longer be written to.
    spacing : tuple of float, optional
        Size of a pixel along (row, col), in `unit`; 1 px each where nothing is known.
    unit : str, optional
        Unit of length of `spacing`, such as ``"µm"``; None when the size of a pixel is not known.
    source : str, optional
        Name of the image, for people.
    notes : tuple of str, optional
        What a reader changed on the way from the file to `values`, one sentence each.

    Raises
    ------
    ValueError
        When `values` is not a two-dimensional grid of finite real numbers, at least `MINIMUM_SIDE` pixels wide and
        high, or when `spacing` is not one positive number for each axis.
    """

    values: NDArray[np.float64]
    spacing: tuple[float, ...] = (1.0, 1.0)
    unit: str | None = None
    source: str = "image"
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        given = np.asarray(self.values)
        if given.dtype.kind not in "buif":
            raise ValueError(f"{self.source} holds values of type {given.dtype}, but grey levels must be real numbers.")
        if given.ndim != 2:
            raise ValueError(
                f"{self.source} has {given.ndim} dimension{'' if given.ndim == 1 else 's'} {given.shape}, "
                "but an image has two, (rows, columns): choose one plane of it."
            )
        if min(given.shape) < MINIMUM_SIDE:
            raise ValueError(
                f"{self.source} is {given.shape[0]} x {given.shape[1]} px, "
                f"but an image needs at least {MINIMUM_SIDE} px along each side."
            )
        values = np.array(given, dtype=np.float64, order="C")
        unusable = values.size - int(np.isfinite(values).sum())
        if unusable:
            raise ValueError(
                f"{self.source} holds {unusable} value{'' if unusable == 1 else 's'} that "
                f"{'is' if unusable == 1 else 'are'} NaN or infinite: replace them by numbers first."
            )
        spacing = tuple(float(size) for size in self.spacing)
        if len(spacing) != values.ndim or not all(math.isfinite(size) and size > 0 for size in spacing):
            raise ValueError(f"The spacing of {self.source} is {self.spacing}, but must be two positive numbers.")
        values.flags.writeable = False
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "spacing", spacing)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of pixels along each axis, (rows, columns)."""
        return self.values.shape

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return self.values.ndim
