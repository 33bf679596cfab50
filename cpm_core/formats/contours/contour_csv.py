"""CSV: contours as a table for spreadsheets and statistics."""

from __future__ import annotations

import csv
import io

from cpm_core.contours.rasterize import numbers
from cpm_core.contours.result import Result
from cpm_core.medial_axis.skeleton import Skeleton

ASCII_UNIT = {"µm": "um"}  # spreadsheets guess the encoding of a file from its header, and guess badly
"""What units are called in the names of columns."""


def encode(result: Result | Skeleton) -> bytes:
    """Tabulate the vertices of all contours, one a row.

    Columns: ``contour`` (from 1), ``closed`` (TRUE or FALSE; the first vertex is not repeated), ``label`` (the one in
    the label mask, 0 when open), ``strength`` (mean edge strength [gray levels / px]), ``vertex`` (from 1), ``row`` and
    ``col`` [px, pixel centers at integers], where the size of a pixel is known, ``x_...`` and ``y_...`` in its unit,
    from the center of the first pixel along columns and rows, ``contrast`` (mean contrast of both sides, empty where
    there is no image to measure it in), and where any contour has one, ``name`` and ``color``. Of a skeleton each
    branch is a contour, has a label in the branch mask, no contrast, and a last column ``radius``: the distance to the
    boundary [px].

    Returns
    -------
    bytes
        A UTF-8 CSV file with a header, commas, and points as decimal marks.
    """
    branched = isinstance(result, Skeleton)
    header = ["contour", "closed", "label", "strength", "vertex", "row", "col"]
    if result.unit:
        unit = ASCII_UNIT.get(result.unit, result.unit)
        header += [f"x_{unit}", f"y_{unit}"]
    if not branched:
        header.append("contrast")
    called = any(contour.name or contour.color for contour in result.contours)
    if called:
        header += ["name", "color"]
    if branched:
        header.append("radius")
    stream = io.StringIO(newline="")
    table = csv.writer(stream, lineterminator="\n")
    table.writerow(header)
    labels = range(1, len(result.contours) + 1) if branched else numbers(result.contours)
    for number, (contour, label) in enumerate(zip(result.contours, labels, strict=True), start=1):
        fixed = [number, str(contour.closed).upper(), label, f"{contour.strength:.6g}"]
        contrast = f"{contour.contrast:.4f}" if contour.sides else ""
        for vertex, (row, col) in enumerate(contour.points, start=1):
            line = [*fixed, vertex, f"{row:.4f}", f"{col:.4f}"]
            if result.unit:
                line += [f"{col * result.spacing[1]:.7g}", f"{row * result.spacing[0]:.7g}"]
            if not branched:
                line.append(contrast)
            if called:
                line += [contour.name, contour.color]
            if isinstance(result, Skeleton):
                line.append(f"{result.radii[number - 1][vertex - 1]:.4f}")
            table.writerow(line)
    return stream.getvalue().encode()
