"""CSV: contours or their measures on all pages of a stack."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable

from cpm_core.contours.measurements import centroid
from cpm_core.contours.result import Result
from cpm_core.formats.contours import contour_csv
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.pages.page import StackResult

Row = dict[str, object]


def encode(found: StackResult) -> bytes:
    """Tabulate the vertices of the contours on all pages, one a row.

    Columns: ``page`` (from 1), ``track`` (the number that an object keeps from page to page), and those of
    `contour_csv.encode` for each page, without ``contour``; ``label`` is that in the label stack, the track, or 0 when
    open.
    """
    return _joined(found, contour_csv.encode, lambda row, _: row)


def encode_measures(found: StackResult) -> bytes:
    """Tabulate the measures of the contours on all pages, one contour a row.

    Columns: ``page``, ``track``, ``centroid_row`` and ``centroid_col`` (the center of the enclosed area, of an open
    contour that of its length [px]), and those of `contour_csv.encode_measures`, without ``contour``; ``label`` is that
    in the label stack, and ``inside`` the track of the contour around it.
    """

    def placed(row: Row, result: Result) -> Row:
        track = row["track"]
        center = next(centroid(contour) for contour in result.contours if str(contour.number) == track)
        return row | {"centroid_row": f"{center[0]:.4f}", "centroid_col": f"{center[1]:.4f}"}

    return _joined(found, contour_csv.encode_measures, placed)


def _joined(
    found: StackResult, encode_page: Callable[[Result | Skeleton], bytes], amended: Callable[[Row, Result], Row]
) -> bytes:
    """The tables of all pages as one, with the columns of each of them."""
    rows: list[Row] = []
    columns: dict[str, None] = {}
    for page, result in found.results:
        text = encode_page(result).decode()
        for cells in csv.DictReader(io.StringIO(text, newline="")):
            track = cells.pop("contour")
            label = "0" if cells["label"] == "0" else track
            row = amended({"page": page, "track": track}, result) | cells | {"label": label}
            rows.append(row)
            columns |= dict.fromkeys(row)
    stream = io.StringIO(newline="")
    table = csv.DictWriter(stream, list(columns) or ["page", "track"], restval="", lineterminator="\n")
    table.writeheader()
    table.writerows(rows)
    return stream.getvalue().encode()
