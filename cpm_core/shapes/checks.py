"""Checks: what a shape must be to be one. Each raises a ValueError with one sentence."""

from __future__ import annotations

from collections.abc import Sequence

from cpm_core.numerics.types import Position

SMALLEST, LARGEST = 0.5, 1e5
"""Bounds of radii and of distances between particles [px]."""


def check_number(name: str, value: float, low: float = SMALLEST, high: float = LARGEST) -> None:
    """Check a number of a shape.

    Raises
    ------
    ValueError
        When it lies outside its bounds or is none.
    """
    if not low <= value <= high:
        raise ValueError(f"{name} is {value:g} but must be a number from {low:g} to {high:g}.")


def check_positions(name: str, positions: Sequence[Position], least: int) -> None:
    """Check corners or points of a shape.

    Raises
    ------
    ValueError
        When fewer of them differ than the shape needs.
    """
    different = len(set(positions))
    if different < least:
        raise ValueError(f"{different} different {name} are given but at least {least} are needed.")
