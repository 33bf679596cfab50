"""Selection: the object that has been chosen by clicks."""

from __future__ import annotations

from dataclasses import dataclass

from cpm_core.contours.contour import Contour
from cpm_core.numerics.types import Array, Mask


@dataclass(frozen=True, eq=False)
class Selection:
    """An object: a set of faces with its closed boundary.

    Attributes
    ----------
    mask : ndarray of bool, shape (H, W)
        Pixels whose centers lie in the object.
    contours : tuple of Contour
        Its boundary, closed: the outlines of its parts, and those of its holes.
    gaps : tuple of ndarray, shape (K, 2)
        Stretches of the boundary that follow no contour [px].
    confidence : float
        Share of the boundary that follows a contour, 0 to 1.
    inside, outside : ndarray, shape (M, 2) and (K, 2)
        The places that have been said to be inside and outside [px].
    remark : str
        One sentence on what was unusual about the places, or empty.
    """

    mask: Mask
    contours: tuple[Contour, ...]
    gaps: tuple[Array, ...]
    confidence: float
    inside: Array
    outside: Array
    remark: str = ""
