"""Appearance: name and color of a contour in files."""

from __future__ import annotations

from cpm_core.contours.contour import Contour

RGB = tuple[int, int, int]

DEFAULT = "#d6006c"
"""Color of contours without one of their own: visible on gray and on white."""


def title(contour: Contour, number: int) -> str:
    """Name of a contour, or its number."""
    return contour.name or f"contour {number}"


def rgb(contour: Contour) -> RGB:
    """Red, green and blue of a contour, from 0 to 255."""
    color = contour.color or DEFAULT
    return int(color[1:3], 16), int(color[3:5], 16), int(color[5:7], 16)
