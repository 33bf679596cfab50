"""The table of contours: what is known about each, and which lies in which."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cpm_core.contours.contour import Contour
from cpm_core.numerics.polyline import inside, middles

_PROBES = 16
"""Places along a contour that are looked for in others: where they touch, most of them tell on which side it lies."""

_MARGIN = 1.0
"""How far a contour may reach out of one that it lies in; those that share a stretch of edge touch there [px]."""


@dataclass(frozen=True, slots=True)
class Measures:
    """A row of the table of contours.

    Attributes
    ----------
    number : int
        Place among the contours, from 1.
    label : int
        Label in the label mask, counted over the closed contours from 1; 0 when open.
    name, color : str
        Those of the contour; empty when it has none.
    closed : bool
        Whether it is closed.
    junctions : int
        How many of its ends lie on a junction, 0 to 2.
    length : float
        Length along it [px].
    area : float
        Enclosed area, that of contours inside included [px²]; 0 when open.
    strength : float
        Mean edge strength [gray levels / px].
    contrast : float or None
        Mean contrast of the regions on both sides, 0 to 1; None when it was not asked for or there is no image to
        measure it in.
    inside : int
        Number of the innermost closed contour that it lies in; 0 when it lies in none.
    length_in_units, area_in_units : float
        Length and area in the unit of the image's spacing and its square; those in px where the spacing is 1.
    """

    number: int
    label: int
    name: str
    color: str
    closed: bool
    junctions: int
    length: float
    area: float
    strength: float
    contrast: float | None
    inside: int
    length_in_units: float
    area_in_units: float


def measure(
    contours: Sequence[Contour], spacing: Sequence[float] = (1.0, 1.0), *, contrast: bool = True
) -> tuple[Measures, ...]:
    """Tell what is known about each contour.

    Parameters
    ----------
    contours : sequence of Contour
        The contours of a result.
    spacing : sequence of float
        Size of a pixel along (row, col), in whatever unit.
    contrast : bool
        Whether to measure the contrast, which takes longer than all the rest the first time that it is asked for.

    Returns
    -------
    tuple of Measures
        One row a contour, in their order.
    """
    around = containment(contours)
    rows: list[Measures] = []
    label = 0
    for number, (contour, outer) in enumerate(zip(contours, around, strict=True), start=1):
        label += contour.closed
        rows.append(
            Measures(
                number=number,
                label=label if contour.closed else 0,
                name=contour.name,
                color=contour.color,
                closed=contour.closed,
                junctions=sum(contour.junctions),
                length=contour.length,
                area=contour.area,
                strength=contour.strength,
                contrast=contour.contrast if contrast and contour.sides else None,
                inside=0 if outer is None else outer + 1,
                length_in_units=float(np.linalg.norm(np.diff(contour.path, axis=0) * spacing, axis=1).sum()),
                area_in_units=contour.area * spacing[0] * spacing[1],
            )
        )
    return tuple(rows)


def containment(contours: Sequence[Contour]) -> tuple[int | None, ...]:
    """Find for each contour the innermost closed one that it lies in.

    A contour lies in another when most of `_PROBES` places along it do, so that contours which share a
    junction or a stretch of edge are told apart; a closed one lies only in larger ones.

    Parameters
    ----------
    contours : sequence of Contour
        Contours that do not cross, open and closed.

    Returns
    -------
    tuple of (int or None)
        For each contour the index of the one around it; None when there is none.
    """
    count = len(contours)
    if not count:
        return ()
    low = np.array([contour.points.min(axis=0) for contour in contours])
    high = np.array([contour.points.max(axis=0) for contour in contours])
    area = np.array([contour.area for contour in contours])
    closed = np.array([contour.closed and len(contour.points) > 2 for contour in contours])
    # which boxes lie in which: row by contour, column by candidate around it, the smallest candidate first
    order = np.flatnonzero(closed)[np.argsort(area[closed], kind="stable")]
    fits = (low[:, None] >= low[order] - _MARGIN).all(axis=2) & (high[:, None] <= high[order] + _MARGIN).all(axis=2)
    fits &= area[:, None] < area[order]  # an open contour has no area
    found: list[int | None] = []
    for contour, row in zip(contours, fits, strict=True):
        probes = middles(contour.path, _PROBES)
        inner = (other for other in order[row].tolist() if inside(contours[other].points, probes).mean() > 0.5)
        found.append(next(inner, None))
    return tuple(found)
