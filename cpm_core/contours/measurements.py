"""The table of contours: measurements of each, and which contour lies in which."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from cpm_core.contours.contour import Contour, Contours, assign_numbers
from cpm_core.numerics.polyline import path_length, path_midpoints, points_inside
from cpm_core.numerics.real_numbers import as_real_array
from cpm_core.numerics.types import Array, Integers, Position, frozen
from cpm_core.parameters.formatting import format_repr, quote_value

_SAME_OUTLINE_DISTANCE = 1.0
"""Distance up to which the outline of an object may coincide with that of a hole [px]."""

_CONTAINMENT_SAMPLES = 16
"""Samples along a contour that are tested for containment; the majority decides where contours touch."""

_CONTAINMENT_MARGIN = 1.0
"""Distance by which a contour may exceed the one around it [px], since contours may share a stretch of edge."""


@frozen
class Measures:
    """A row of the table of contours.

    Attributes
    ----------
    number : int
        Number of the contour, from 1; it may have a number of its own.
    label : int
        Label in the label mask, counted over the closed contours from 1; 0 when open.
    name, color : str
        Name and color of the contour, or empty.
    closed : bool
        Whether the contour is closed.
    junctions : int
        Number of ends on a junction, 0 to 2.
    length : float
        Length along the contour [px].
    area : float
        Enclosed area, including contours inside [px²]; 0 when open.
    strength : float
        Mean edge strength [gray levels / px].
    contrast : float or None
        Mean contrast of the regions on both sides, 0 to 1; None when it was not requested or there is no image.
    inside : int
        Number of the innermost closed contour around it; 0 without any.
    length_in_units, area_in_units : float
        Length and area in the unit of the image's spacing and its square.
    net_area : float
        Enclosed area without the closed contours directly inside, holes or further objects [px²]: the area of
        its label in the label mask. 0 when open, and for the hole of an object.
    net_area_in_units : float
        `net_area` in the square of the unit.
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
    net_area: float
    net_area_in_units: float

    def __repr__(self) -> str:
        kind = "closed" if self.closed else "open"
        return format_repr(
            "Measures", f"number {self.number}", self.name, kind, f"{self.length:,.1f} px", f"{self.area:,.1f} px²"
        )


def assign_labels(contours: Contours) -> Integers:
    """Assign each contour its label: the number of its object, or for other closed ones the next that none has.

    Open contours and holes have 0.
    """
    taken = {contour.group for contour in contours}
    free = (number for number in itertools.count(1) if number not in taken)
    return tuple((contour.group or next(free)) if contour.closed and not contour.hole else 0 for contour in contours)


def measure(
    contours: Contours, spacing: Sequence[float] = (1.0, 1.0), *, contrast: bool = True
) -> tuple[Measures, ...]:
    """Measure contours.

    Parameters
    ----------
    contours : sequence of Contour
        The contours of a result.
    spacing : sequence of float
        Size of a pixel along (row, col), in any unit.
    contrast : bool
        Whether to measure the contrast, which takes longer than everything else at the first access.

    Returns
    -------
    tuple of Measures
        One row for each contour, in their order.

    Raises
    ------
    ValueError
        When the spacing is not two positive numbers.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("ring"), cpm.uniform_grid((64, 64)))
    >>> for row in cpm.measure(result.contours, result.spacing):
    ...     print(row.number, row.label, row.inside, round(row.area), round(row.net_area))
    1 1 0 1804 1495
    2 2 1 310 310
    """
    sizes = as_real_array(spacing)
    if sizes.shape != (2,) or not (np.isfinite(sizes) & (sizes > 0.0)).all():
        raise ValueError(f"spacing is {quote_value(spacing)} but must be two positive numbers, (row, col).")
    around = containment(contours)
    net = _net_areas(contours, around)
    numbers, labels = assign_numbers(contours), assign_labels(contours)
    return tuple(
        Measures(
            number=number,
            label=label,
            name=contour.name,
            color=contour.color,
            closed=contour.closed,
            junctions=sum(contour.junctions),
            length=contour.length,
            area=contour.area,
            strength=contour.strength,
            contrast=contour.contrast if contrast and contour.measure_contrast else None,
            inside=0 if outer is None else numbers[outer],
            length_in_units=path_length(contour.path * spacing),
            area_in_units=contour.area * spacing[0] * spacing[1],
            net_area=own,
            net_area_in_units=own * spacing[0] * spacing[1],
        )
        for number, label, contour, outer, own in zip(numbers, labels, contours, around, net.tolist(), strict=True)
    )


def compute_centroid(contour: Contour) -> Position:
    """Compute the center (row, col) of the area of a closed contour, or of the length of an open one [px]."""
    path = contour.path
    if contour.area > 0.0:
        area, *first = area_moments(path)[:3].tolist()
        row, col = first[0] / area, first[1] / area
    else:
        row, col = path_midpoints(path, _CONTAINMENT_SAMPLES * len(path)).mean(axis=0).tolist()
    return row, col


def area_moments(path: Array) -> Array:
    """Compute the moments of the inside of a closed path about the origin by Green's theorem, shape (6,).

    The path, shape (K, 2), may run either way. The moments are the area, the first moments (row, col), and the second
    ones (row row, col col, row col).
    """
    middle = path.mean(axis=0)  # so that squares of large coordinates do not cancel
    one, other = path[:-1] - middle, path[1:] - middle
    twice, both = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0], one + other
    area, (row, col) = 0.5 * twice.sum(), both.T @ twice / 6.0
    second = np.asarray(sum((some.T * twice) @ some for some in (one, other, both))) / 24.0
    down, right = middle
    about = (
        second[0, 0] + 2.0 * row * down + area * down**2,
        second[1, 1] + 2.0 * col * right + area * right**2,
        second[0, 1] + row * right + col * down + area * down * right,
    )
    return np.array([area, row + area * down, col + area * right, *about]) * (1.0 if area >= 0.0 else -1.0)


def _net_areas(contours: Contours, around: Sequence[int | None]) -> Array:
    """Compute the areas without those of the contours inside, shape (N,) [px²]."""
    net = np.array([contour.area for contour in contours])
    for contour, outer in zip(contours, around, strict=True):
        larger = (
            other
            for other, its in zip(contours if contour.hole else (), around, strict=False)
            if its == outer and other.closed and not other.hole and other.area > contour.area
        )
        # another object in the same one may reach beyond a hole on all sides and take its area, too
        covered = any(
            points_inside(other.points, path_midpoints(contour.path, _CONTAINMENT_SAMPLES)).mean() > 0.5
            for other in larger
        )
        if outer is not None and not covered:
            net[outer] -= contour.area
    net[[contour.hole for contour in contours]] = 0.0
    np.maximum(net, 0.0, out=net)  # contours may share a stretch of edge and overlap there
    return net


def containment(contours: Contours) -> tuple[int | None, ...]:
    """Find for each contour the innermost closed one that it lies in.

    A contour lies in another when most of the samples along it do, so that contours which share a junction or a stretch
    of edge are classified correctly; a closed one lies only in larger ones. A hole lies only in an outline of its own
    object, and an object that fills a hole lies in the hole, even where it is larger by a fraction of a pixel.

    Parameters
    ----------
    contours : sequence of Contour
        Contours that do not cross, open and closed.

    Returns
    -------
    tuple of (int or None)
        For each contour the index of the one around it; None when there is none.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("ring"), cpm.uniform_grid((64, 64)))
    >>> cpm.containment(result.contours)  # the second lies in the first
    (None, 0)
    """
    count = len(contours)
    if not count:
        return ()
    low, high = np.array([contour.box for contour in contours]).swapaxes(0, 1)
    area = np.array([contour.area for contour in contours])
    closed = np.array([contour.encloses_area for contour in contours])
    # which boxes contain which: rows are contours, columns are candidates around them, the smallest first
    order = np.flatnonzero(closed)[np.argsort(area[closed], kind="stable")]
    fits = (low[:, None] >= low[order] - _CONTAINMENT_MARGIN).all(axis=2) & (
        high[:, None] <= high[order] + _CONTAINMENT_MARGIN
    ).all(axis=2)
    fits &= area[:, None] < area[order]  # an open contour has no area
    hole = np.array([contour.hole for contour in contours])
    group = np.array([contour.group for contour in contours])
    fits[hole] &= ~hole[order] & (group[hole, None] == group[order])
    found: list[int | None] = []
    for index, (contour, row) in enumerate(zip(contours, fits, strict=True)):
        filled = hole & ((group != group[index]) | (group == 0)) & closed[index] & ~hole[index]
        filled &= (np.abs(low - low[index]) <= _SAME_OUTLINE_DISTANCE).all(axis=1) & (
            np.abs(high - high[index]) <= _SAME_OUTLINE_DISTANCE
        ).all(axis=1)
        filled &= np.abs(area - area[index]) <= 0.5 * _SAME_OUTLINE_DISTANCE * contour.length
        if filled.any():
            found.append(int(np.argmax(filled)))
            continue
        probes = path_midpoints(contour.path, _CONTAINMENT_SAMPLES)
        inner = (other for other in order[row].tolist() if points_inside(contours[other].points, probes).mean() > 0.5)
        found.append(next(inner, None))
    return tuple(found)
