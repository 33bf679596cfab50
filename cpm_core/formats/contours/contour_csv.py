"""CSV: contours as tables for spreadsheets and statistics, one row a vertex or one row a contour."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence

import numpy as np

from cpm_core.contours.contour import numbers_of
from cpm_core.contours.measurements import contour_labels, measure
from cpm_core.contours.result import Result
from cpm_core.formats.common.printable import cell
from cpm_core.formats.common.provenance import entries_of, facts_of
from cpm_core.medial_axis.skeleton import Skeleton

_ASCII_UNIT = {"µm": "um"}  # spreadsheets often take a header with other letters for a wrong encoding


def encode(result: Result | Skeleton) -> bytes:
    """Tabulate the vertices of all contours, one a row.

    Columns: ``contour`` (the number), ``closed`` (TRUE or FALSE; the first vertex is not repeated), ``label`` (that in
    the label mask, 0 when open), ``strength`` (mean edge strength [gray levels / px]), ``vertex`` (from 1), ``row`` and
    ``col`` [px, pixel centers at integers], where the size of a pixel is known, ``x_...`` and ``y_...`` in its unit,
    from the center of the first pixel along columns and rows, ``contrast`` (mean contrast of both sides, empty where
    there is no image to measure it in), where any contour has one, ``name`` and ``color``, and where any was edited by
    hand, ``by_hand`` (the length that was drawn by hand [px]). Of a skeleton each branch is a contour, has a label in
    the branch mask, no contrast, and a column ``radius``: the distance to the boundary [px]. How they were found is in
    the last columns (`provenance.entries_of`): ``program``, ``image``, its hash and so on. They are filled in the first
    row only, because a table may have a hundred thousand.
    """
    branched = isinstance(result, Skeleton)
    header = ["contour", "closed", "label", "strength", "vertex", "row", "col", *_in_unit(result, "x_{}", "y_{}")]
    if not branched:
        header.append("contrast")
    named = any(contour.name or contour.color for contour in result.contours)
    if named:
        header += ["name", "color"]
    edited = any(contour.by_hand for contour in result.contours)
    if edited:
        header.append("by_hand")
    if branched:
        header.append("radius")
    lines: list[list[object]] = []
    labels = range(1, len(result.contours) + 1) if branched else contour_labels(result.contours)
    each = zip(numbers_of(result.contours), result.contours, labels, strict=True)
    for index, (number, contour, label) in enumerate(each):
        fixed = [number, str(contour.closed).upper(), label, f"{contour.strength:.6g}"]
        contrast = f"{contour.contrast:.4f}" if contour.sides else ""
        for vertex, (row, col) in enumerate(contour.points, start=1):
            line = [*fixed, vertex, f"{row:.4f}", f"{col:.4f}"]
            if result.unit:
                line += [f"{col * result.spacing[1]:.7g}", f"{row * result.spacing[0]:.7g}"]
            if not branched:
                line.append(contrast)
            if named:
                line += [cell(contour.name), contour.color]
            if edited:
                line.append(f"{contour.length_by_hand:.4f}")
            if isinstance(result, Skeleton):
                line.append(f"{result.radii[index][vertex - 1]:.4f}")
            lines.append(line)
    origin = _provenance(result)
    empty = [""] * len(origin)
    told = [[*line, *(empty if number else origin.values())] for number, line in enumerate(lines)]
    return _table([*header, *origin], told)


def encode_measures(result: Result | Skeleton) -> bytes:
    """Tabulate the measures of the contours, one contour a row.

    Columns: ``contour`` (the number), ``label`` (that in the label mask, 0 when open), ``name``, ``color``, ``closed``
    (TRUE or FALSE), ``junctions`` (how many ends lie on one), ``inside`` (the innermost closed contour around it, 0 for
    none), ``strength`` (mean edge strength [gray levels / px]), ``contrast`` (empty where there is no image to measure
    it in), ``length_px``, ``gross_area_px2`` (all that it encloses), ``net_area_px2`` (without the closed contours
    in it, as in the label mask; both areas are empty when it is open), the same in the unit of the image where it is
    known, and where any was edited by hand, ``by_hand_px`` (the length drawn by hand). Where contours are boundaries
    of objects, also ``object`` (its number, 0 for none), ``hole`` (TRUE or FALSE; the net area of a hole is 0), and
    ``bridged_px`` (length without an edge that was found). For a skeleton also ``thickness_min_px``,
    ``thickness_median_px`` and ``thickness_max_px``.
    Where it is known of any contour, ``reached``: how particles came to it (`Contour.reached`).
    How they were found is in the last columns of each row (`provenance.entries_of`), so that tables of several images
    can be joined; a line of its own would break programs that read tables.
    """
    header = ["contour", "label", "name", "color", "closed", "junctions", "inside", "strength", "contrast"]
    header += ["length_px", "gross_area_px2", "net_area_px2"]
    header += _in_unit(result, "length_{}", "gross_area_{}2", "net_area_{}2")
    edited = any(contour.by_hand for contour in result.contours)
    header += ["by_hand_px"] if edited else []
    objects = any(contour.group for contour in result.contours)
    if objects:
        header += ["object", "hole", "bridged_px"]
    told = any(contour.reached for contour in result.contours)
    if told:
        header.append("reached")
    lines: list[list[object]] = []
    for contour, row in zip(result.contours, measure(result.contours, result.spacing), strict=True):
        contrast = "" if row.contrast is None else f"{row.contrast:.4f}"
        line = [row.number, row.label, cell(row.name), row.color, str(row.closed).upper(), row.junctions, row.inside]
        line += [f"{row.strength:.6g}", contrast, f"{row.length:.4f}"]
        line += [f"{area:.4f}" if row.closed else "" for area in (row.area, row.net_area)]
        if result.unit:
            line.append(f"{row.length_in_units:.7g}")
            line += [f"{area:.7g}" if row.closed else "" for area in (row.area_in_units, row.net_area_in_units)]
        if edited:
            line.append(f"{row.by_hand:.4f}")
        if objects:
            line += [contour.group, str(contour.hole).upper(), f"{contour.bridged:.4f}"]
        if told:
            line.append(contour.reached)
        lines.append(line)
    if isinstance(result, Skeleton):
        header += ["thickness_min_px", "thickness_median_px", "thickness_max_px"]
        for line, radii in zip(lines, result.radii, strict=True):
            line += [f"{2.0 * of(radii):.4f}" for of in (np.min, np.median, np.max)]
    origin = _provenance(result)
    return _table([*header, *origin], ([*line, *origin.values()] for line in lines))


def _provenance(result: Result | Skeleton) -> dict[str, str]:
    """Names and cells of the last columns."""
    return {name: cell(told) for name, told in entries_of(facts_of(result)).items()}


def _in_unit(result: Result | Skeleton, *columns: str) -> list[str]:
    """Names of columns in the unit of the image; none where it is unknown."""
    unit = _ASCII_UNIT.get(result.unit or "", result.unit)
    return [column.format(unit) for column in columns if unit]


def _table(header: Sequence[str], lines: Iterable[Sequence[object]]) -> bytes:
    """A UTF-8 CSV file with a header, commas, and points as decimal marks."""
    stream = io.StringIO(newline="")
    table = csv.writer(stream, lineterminator="\n")
    table.writerow(header)
    table.writerows(lines)
    return stream.getvalue().encode()
