"""Appearance: what a contour is called and which colour it has in files."""

from __future__ import annotations

from cpm_core.contours.contour import Contour

RGB = tuple[int, int, int]

DEFAULT = "#d6006c"
"""Colour of contours that nobody has given one: to be seen on grey, and on white paper."""


def title(contour: Contour, number: int) -> str:
    """Name of a contour, or its place among the contours."""
    return contour.name or f"contour {number}"


def rgb(contour: Contour) -> RGB:
    """Red, green and blue of a contour, from 0 to 255."""
    colour = contour.colour or DEFAULT
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)
