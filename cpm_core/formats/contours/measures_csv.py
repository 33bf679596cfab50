"""Measures: one row a contour, for spreadsheets and statistics."""

from __future__ import annotations

import csv
import io

from cpm_core.contours.measurements import measure
from cpm_core.contours.result import Result
from cpm_core.formats.contours.contour_csv import ASCII_UNIT
from cpm_core.medial_axis.skeleton import Skeleton


def encode(result: Result | Skeleton) -> bytes:
    """Tabulate what is known about each contour.

    Columns: ``contour`` (from 1), ``label`` (the one in the label mask, 0 when open), ``name``, ``color``, ``closed``
    (TRUE or FALSE), ``junctions`` (how many ends lie on one), ``inside`` (the innermost closed contour around it, 0 for
    none), ``strength`` (mean edge strength [gray levels / px]), ``contrast`` (empty where there is no image to measure
    it in), ``length_px``, ``area_px2`` (0 when open), and the same in the unit of the image where it is known.

    Returns
    -------
    bytes
        A UTF-8 CSV file with a header, commas, and points as decimal marks.
    """
    header = ["contour", "label", "name", "color", "closed", "junctions", "inside", "strength", "contrast"]
    header += ["length_px", "area_px2"]
    if result.unit:
        unit = ASCII_UNIT.get(result.unit, result.unit)
        header += [f"length_{unit}", f"area_{unit}2"]
    stream = io.StringIO(newline="")
    table = csv.writer(stream, lineterminator="\n")
    table.writerow(header)
    for row in measure(result.contours, result.spacing):
        contrast = "" if row.contrast is None else f"{row.contrast:.4f}"
        line = [row.number, row.label, row.name, row.color, str(row.closed).upper(), row.junctions, row.inside]
        line += [f"{row.strength:.6g}", contrast, f"{row.length:.4f}", f"{row.area:.4f}"]
        if result.unit:
            line += [f"{row.length_in_units:.7g}", f"{row.area_in_units:.7g}"]
        table.writerow(line)
    return stream.getvalue().encode()
