"""Points: a table of starting positions of particles, or of the particles of a run in a volume."""

from __future__ import annotations

import csv

import numpy as np

from cpm_core.formats.common.content import AnySource, find_local_file, read_content
from cpm_core.formats.common.provenance import Outcome
from cpm_core.formats.contours.contour_csv import Row, build_provenance_cells, encode_csv_rows
from cpm_core.numerics.types import Array, Integers
from cpm_core.parameters.formatting import quote_value
from cpm_core.results.result import Result

_AXIS_COLUMNS = ("plane", "row", "col")
"""Columns of the coordinates."""


def encode_points(result: Outcome) -> bytes:
    """Tabulate particles as ``plane,row,col`` in voxels; ValueError unless there are particles in a volume.

    Provenance (`flatten_provenance`) is in the last columns of the first row.
    """
    if not isinstance(result, Result) or result.particles.shape[1] != 3 or not len(result.particles):
        raise ValueError("There are no particles in a volume to write: run in a volume first.")
    rows: list[Row] = [
        {name: f"{at:.7g}" for name, at in zip(_AXIS_COLUMNS, place, strict=True)}
        for place in result.particles.tolist()
    ]
    rows[0] |= build_provenance_cells(result)
    return encode_csv_rows(rows)


def load_points(path: AnySource, axes: int = 2) -> Array:
    """Read points from a CSV file.

    Parameters
    ----------
    path : path-like or file-like
        A text file with one point per line, row and column in px, separated by a comma. With a header that names the
        columns ``row`` and ``col``, these are used in any order, so an exported contour table can be read back.
    axes : int
        With 3, points of a volume are read: plane, row and column, named ``plane``, ``row`` and ``col``.

    Returns
    -------
    ndarray of float64, shape (N, 2) or (N, 3)
        Points (row, col) in px, or (plane, row, col).

    Raises
    ------
    ValueError
        When the file cannot be read or a line does not hold as many finite numbers; the message names the line.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("ball"), cpm.sphere((15, 15, 15), 4, 60), cpm.PRESETS["volume"])
    >>> cpm.export(result, "ball.points.csv")
    >>> bool(np.abs(cpm.load_points("ball.points.csv", axes=3) - result.particles).max() < 0.001)
    True
    """
    file = find_local_file(path)
    try:
        text = read_content(file).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError(
            f"{file.name} is not a text file: give a CSV file with a row and a column on each line."
        ) from None
    lines = [
        (number, [cell.strip() for cell in cells])
        for number, cells in enumerate(csv.reader(text.splitlines()), start=1)
        if any(cell.strip() for cell in cells)
    ]
    columns, wanted = tuple(range(axes)), _AXIS_COLUMNS[-axes:]
    if lines:
        names = [cell.lower() for cell in lines[0][1]]
        if all(name in names for name in wanted):
            columns = tuple(names.index(name) for name in wanted)
            lines = lines[1:]
    if not lines:
        raise ValueError(f"{file.name} contains no points: give a row and a column on each line.")
    return np.array([_parse_point(file.name, number, cells, columns) for number, cells in lines])


def _parse_point(name: str, number: int, cells: list[str], columns: Integers) -> tuple[float, ...]:
    """Parse the coordinates of a point; ValueError, naming the line, unless they are finite numbers."""
    try:
        place = tuple(float(cells[column]) for column in columns)
    except (ValueError, IndexError):
        place = (np.nan,)
    if not np.isfinite(place).all():
        words = "two numbers, row and column" if len(columns) == 2 else "three numbers, plane, row and column"
        raise ValueError(f"Line {number} of {name} is {quote_value(','.join(cells))} but must be {words} in px.")
    return place
