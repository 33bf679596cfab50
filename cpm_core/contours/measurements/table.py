"""A table: columns by name, as `pandas.DataFrame` takes them, with the unit of each."""

from __future__ import annotations

import html
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpm_core.parameters.quotation import counted, described

Column = NDArray[Any]

_MOST_ROWS = 60
"""Rows that a notebook shows of a table."""


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
    <Table 2 rows, label, name, area, area_filled, area_convex, perimeter, centroid-0, centroid-1, box…>
    >>> [round(float(area)) for area in table["area"]], table.units["area"]
    ([309, 309], 'px²')
    """

    def __init__(self, columns: Mapping[str, Column], units: Mapping[str, str]) -> None:
        super().__init__(columns)
        self.units: dict[str, str] = {name: units.get(name, "") for name in columns}

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
        return described("Table", counted(self.rows, "row"), *self)

    def _repr_html_(self) -> str:
        heads = "".join(
            f"<th>{html.escape(name)}{f'<br>[{html.escape(unit)}]' if unit else ''}</th>"
            for name, unit in self.units.items()
        )
        lines = [
            "".join(f"<td>{html.escape(_text(column[row]))}</td>" for column in self.values())
            for row in range(min(self.rows, _MOST_ROWS))
        ]
        left_out = self.rows - len(lines)
        more = f"<p>… and {counted(left_out, 'more row')}</p>" if left_out else ""
        return f"<table><tr>{heads}</tr>{''.join(f'<tr>{line}</tr>' for line in lines)}</table>{more}"


def _text(value: Any) -> str:
    """A value of a table in a notebook."""
    return f"{value:.6g}" if isinstance(value, float | np.floating) else str(value)
