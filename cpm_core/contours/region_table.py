"""Measurements of the regions that contours enclose, and of the objects in a volume: columns of `Result.table`.

Columns have the names of scikit-image's ``regionprops`` where they measure the same quantity, but lengths and areas are
measured on the contours, which run between the pixels, and not on pixels. Gray levels are measured on the pixels whose
centers lie inside.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.contours.contour import Contours
from cpm_core.contours.measurements import area_moments, assign_labels, containment
from cpm_core.numerics import polyline
from cpm_core.numerics.grids import find_label_boxes, rank_values
from cpm_core.numerics.types import NO_POINTS, Array, Index, Numbers
from cpm_core.parameters.formatting import format_count, format_repr

Column = Numbers


class Table(dict[str, Column]):
    """Columns of one length by name: a dictionary, from which ``pandas.DataFrame(table)`` makes a data frame.

    Parameters
    ----------
    columns : mapping of str to ndarray, shape (N,)
        The columns, in order.
    units : mapping of str to str
        Unit of each column that has one.

    Attributes
    ----------
    units : dict of str to str
        Unit of each column; empty for pure numbers.

    Examples
    --------
    >>> table = cpm.segment(cpm.example("disks"), cpm.uniform_grid((64, 64))).table()
    >>> table
    <Table 2 rows, label, name, area, area_filled, area_convex, perimeter, centroid-0, centroid-1, bbo…>
    >>> [round(float(area)) for area in table["area"]], table.units["area"]
    ([310, 309], 'px²')
    """

    def __init__(self, columns: Mapping[str, Column], units: Mapping[str, str]) -> None:
        super().__init__(columns)
        self.units = {name: units.get(name, "") for name in columns}

    @property
    def rows(self) -> int:
        """Number of rows.

        Examples
        --------
        >>> cpm.segment(cpm.example("disks"), cpm.uniform_grid((64, 64))).table().rows
        2
        """
        return len(next(iter(self.values()), ()))

    def __repr__(self) -> str:
        return format_repr("Table", format_count(self.rows, "row"), *self)


_LENGTH_COLUMNS = (
    "perimeter", "axis_major_length", "axis_minor_length", "equivalent_diameter_area", "centroid", "bbox"
)  # fmt: skip
"""Prefixes of the columns that hold lengths."""

_AREA_COLUMNS = ("area", "area_filled", "area_convex")
"""Columns that hold areas."""


def measure_regions(
    contours: Contours,
    labels: NDArray[np.integer],
    gray: Array | None,
    spacing: Sequence[float],
    unit: str | None,
) -> Table:
    """Measure the regions that closed contours enclose, one row a label.

    Parameters
    ----------
    contours : sequence of Contour
        Contours [px].
    labels : ndarray of int, shape (H, W)
        Label mask of the contours.
    gray : ndarray or None, shape (H, W)
        Gray levels.
    spacing : sequence of float
        Size of a pixel along each axis [unit].
    unit : str or None
        Unit of lengths; px where None.
    """
    sides = np.array(spacing, float)
    around, numbers = containment(contours), assign_labels(contours)
    inner: dict[int, list[int]] = {}
    for place, outer in enumerate(around):
        if outer is not None and contours[place].closed:
            inner.setdefault(outer, []).append(place)
    of_label: dict[int, list[int]] = {}
    for place, number in enumerate(numbers):
        if number:
            of_label.setdefault(number, []).append(place)
    rows = []
    for label, outlines in of_label.items():
        holes = [place for outline in outlines for place in inner.get(outline, ()) if place not in outlines]
        rows.append(_measure_region(label, [contours[p] for p in outlines], [contours[p] for p in holes], sides))
    names = list(rows[0]) if rows else list(_measure_region(0, [], [], sides))
    columns = {name: np.array([row[name] for row in rows]) for name in names}
    columns["label"] = columns["label"].astype(np.int64)
    columns["name"] = columns["name"].astype(object)
    return Table(
        {**columns, **_measure_gray_levels(columns["label"], labels, gray)}, _column_units(columns, unit or "px", "²")
    )


def measure_volume_objects(
    labels: NDArray[np.integer], gray: Array | None, spacing: Sequence[float], unit: str | None
) -> Table:
    """Measure the objects of a label volume from the voxels inside, one row a label.

    Parameters
    ----------
    labels : ndarray of int, shape (P, R, C)
        Label of each voxel.
    gray : ndarray or None, shape (P, R, C)
        Gray levels.
    spacing : sequence of float
        Size of a voxel along each axis [unit].
    unit : str or None
        Unit of lengths; px where None.
    """
    sides = np.array(spacing, float)
    found, ranks = rank_values(labels)
    places = np.flatnonzero(found > 0)
    numbers, counts = found[places].astype(np.int64), np.bincount(ranks.ravel(), minlength=len(found))[places]
    columns = {"label": numbers, "volume": counts * float(np.prod(sides))}
    columns["equivalent_diameter"] = np.cbrt(6.0 * columns["volume"] / np.pi)
    centers = np.array(scipy.ndimage.center_of_mass(labels > 0, ranks, places)).reshape(-1, 3)
    parts = [part for _, part in find_label_boxes(labels)]
    ends = [[side.start for side in part] + [side.stop - 1 for side in part] for part in parts]
    columns |= {f"centroid-{axis}": column for axis, column in enumerate((centers * sides).T)}
    columns |= {f"bbox-{k}": column for k, column in enumerate((np.reshape(ends, (-1, 6)) * np.tile(sides, 2)).T)}
    units = {"volume": f"{unit or 'px'}³", "equivalent_diameter": unit or "px"}
    return Table(
        {**columns, **_measure_gray_levels(numbers, labels, gray)}, _column_units(columns, unit or "px", "³") | units
    )


def _measure_region(label: int, outlines: Contours, holes: Contours, sides: Array) -> dict[str, object]:
    """Measure one label, without its gray levels."""
    import shapely  # noqa: PLC0415 - needed for tables only

    paths, cuts = ([contour.path * sides for contour in some] for some in (outlines, holes))
    filled = sum((area_moments(path) for path in paths), np.zeros(6))
    net = filled - sum((area_moments(path) for path in cuts), np.zeros(6))
    area, whole = max(float(net[0]), 0.0), float(filled[0])
    outer = sum(polyline.path_length(path) for path in paths)
    points = np.concatenate([NO_POINTS, *paths])
    hull = float(shapely.MultiPoint(points).convex_hull.area) or whole
    center = net[1:3] / area if area > 0.0 else points.mean(axis=0) if len(points) else np.zeros(2)
    low, high = (points.min(axis=0), points.max(axis=0)) if len(points) else (np.zeros(2), np.zeros(2))
    return {
        "label": label,
        "name": next((contour.name for contour in outlines if contour.name), ""),
        "area": area,
        "area_filled": whole,
        "area_convex": hull,
        "perimeter": outer + sum(polyline.path_length(path) for path in cuts),
        **{f"centroid-{axis}": place for axis, place in enumerate(center)},
        **{f"bbox-{k}": end for k, end in enumerate((*low, *high))},
        **_fit_ellipse(net, center),
        "equivalent_diameter_area": float(np.sqrt(4.0 * area / np.pi)),
        "solidity": area / hull if hull > 0.0 else np.nan,
        "circularity": 4.0 * np.pi * whole / outer**2 if outer > 0.0 else np.nan,
    }


def _fit_ellipse(net: Array, center: Array) -> dict[str, object]:
    """Fit the ellipse of the same second moments: axes, eccentricity, and the angle between rows and its long axis."""
    if net[0] <= 0.0:
        return dict.fromkeys(("axis_major_length", "axis_minor_length", "eccentricity", "orientation"), np.nan)
    rows, cols, mixed = net[3:] / net[0] - (center[0] ** 2, center[1] ** 2, center[0] * center[1])
    small, large = np.maximum(np.linalg.eigvalsh([[rows, mixed], [mixed, cols]]), 0.0).tolist()
    return {
        "axis_major_length": 4.0 * np.sqrt(large),
        "axis_minor_length": 4.0 * np.sqrt(small),
        "eccentricity": np.sqrt(1.0 - small / large) if large > 0.0 else 0.0,
        "orientation": 0.5 * np.arctan2(2.0 * mixed, rows - cols),
    }


_GRAY_STATISTICS = {"mean": "mean", "std": "standard_deviation", "min": "minimum", "max": "maximum"}
"""Suffix of each gray-level column -> function of scipy.ndimage that measures it."""


def _measure_gray_levels(numbers: Index, labels: NDArray[np.integer], gray: Array | None) -> dict[str, Column]:
    """Measure the gray levels of each label; NaN where no center of a pixel lies inside."""
    if gray is None or not len(numbers):
        return {}
    there = np.isin(numbers, labels)
    columns = {f"intensity_{name}": np.full(len(numbers), np.nan) for name in _GRAY_STATISTICS}
    with np.errstate(invalid="ignore"):  # scipy divides by the size of labels that are not asked for, too
        for name, measure in _GRAY_STATISTICS.items():
            columns[f"intensity_{name}"][there] = getattr(scipy.ndimage, measure)(gray, labels, numbers[there])
    return columns


def _column_units(columns: dict[str, Column], unit: str, power: str) -> dict[str, str]:
    """Return the unit of each column of lengths and areas."""
    found = {name: unit for name in columns if name.startswith(_LENGTH_COLUMNS)}
    return {**found, **dict.fromkeys(_AREA_COLUMNS, f"{unit}{power}"), "orientation": "rad"}
