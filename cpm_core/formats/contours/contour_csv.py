"""CSV: contours as tables for spreadsheets and statistics, one row per vertex or one row per contour.

Provenance (`flatten_provenance`) is in the last columns: ``program``, ``image``, its hash and so on; a separate line
would break programs that read tables.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Sequence
from itertools import chain, groupby
from typing import Any

import numpy as np

from cpm_core.contours.contour import Contour, assign_numbers
from cpm_core.contours.measurements import assign_labels, compute_centroid, measure
from cpm_core.formats.common.content import UnreadableError
from cpm_core.formats.common.printable import escape_cell, unescape_cell
from cpm_core.formats.common.provenance import Outcome, describe_provenance, flatten_provenance
from cpm_core.formats.contours.contents import CollectedContours
from cpm_core.formats.images.resolution import ascii_unit, name_column
from cpm_core.formats.meshes.coordinates import to_file_coordinates
from cpm_core.image.surface import Label
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.numerics.polyline import path_length
from cpm_core.pages.page import StackResult
from cpm_core.results.result import Result

Row = dict[str, object]
"""Cells of a row by column."""

_REQUIRED_COLUMNS = {"closed", "row", "col"}
"""Columns that a table of vertices must have besides the number of the contour."""


def encode_vertices(result: Outcome) -> bytes:
    """Tabulate the vertices of all contours, one per row; of a volume it is the table of `encode_object_table`.

    Columns: ``contour`` (number), ``closed`` (TRUE or FALSE; the first vertex is not repeated), ``label`` (in the label
    mask, 0 when open), ``strength`` (mean edge strength [gray levels / px]), ``vertex`` (from 1), ``row`` and ``col``
    [px, pixel centers at integers]; if the pixel size is known, ``x_...`` and ``y_...`` in its unit, along columns and
    rows from the center of the first pixel; ``contrast`` (mean contrast of both sides, empty without an image to
    measure it in); if any contour has one, ``name``, ``color`` and ``class``. Each branch of a skeleton is a contour
    with its label in the branch mask, without contrast, and with a column ``radius``: the distance to the boundary
    [px]. Provenance is in the first row only, because a table may have a hundred thousand.
    """
    if result.surface is not None:
        return encode_object_table(result)
    return encode_csv_rows(
        _build_vertex_rows(result), ("contour", "closed", "label", "strength", "vertex", "row", "col")
    )


def _build_vertex_rows(result: Outcome) -> list[Row]:
    """Build the rows of `encode_vertices`."""
    radii = result.radii if isinstance(result, Skeleton) else None
    labels = range(1, len(result.contours) + 1) if radii is not None else assign_labels(result.contours)
    has, unit, (high, wide) = _find_attributes(result), ascii_unit(result.unit, ""), result.spacing[-2:]
    rows: list[Row] = []
    for index, (number, contour) in enumerate(zip(assign_numbers(result.contours), result.contours, strict=True)):
        fixed: Row = {"contour": number, "closed": _format_bool(contour.closed), "label": labels[index]}
        fixed["strength"] = f"{contour.strength:.6g}"
        common: Row = {}
        if radii is None:
            common["contrast"] = f"{contour.contrast:.4f}" if contour.measure_contrast else ""
        if has & {"name", "color"}:
            common |= {"name": escape_cell(contour.name), "color": contour.color}
        if "category" in has:
            common["class"] = escape_cell(contour.category)
        for vertex, (row, col) in enumerate(contour.points.tolist()):
            place: Row = {**fixed, "vertex": vertex + 1, "row": f"{row:.4f}", "col": f"{col:.4f}"}
            if unit:
                place[f"x_{unit}"] = f"{col * wide:.7g}"
                place[f"y_{unit}"] = f"{row * high:.7g}"
            rows.append(place | common)
            if radii is not None:
                rows[-1]["radius"] = f"{radii[index][vertex]:.4f}"
    if rows:
        rows[0] |= build_provenance_cells(result)
    return rows


def _find_attributes(result: Outcome) -> set[str]:
    """Find the attributes that any contour has, which get columns."""
    names = ("name", "color", "category", "group", "gray")
    return {name for name in names for contour in result.contours if getattr(contour, name)}


def _format_bool(value: bool) -> str:
    """Format a truth value as TRUE or FALSE."""
    return str(value).upper()


def encode_measures(result: Outcome) -> bytes:
    """Tabulate the measures of the contours, one contour per row.

    Columns: ``contour`` (number), ``label`` (in the label mask, 0 when open), ``name``, ``color``, ``closed`` (TRUE or
    FALSE), ``junctions`` (number of ends on one), ``inside`` (innermost closed contour around it, 0 for none),
    ``strength`` (mean edge strength [gray levels / px]), ``contrast`` (empty without an image to measure it in),
    ``length_px``, ``gross_area_px2`` (enclosed area), ``net_area_px2`` (without the closed contours inside, as in the
    label mask; both areas are empty when it is open), and the same in the unit of the image if it is known. For
    boundaries of objects also ``class``,
    ``object`` (its number, 0 for none), ``hole`` (TRUE or FALSE; the net area of a hole is 0), and ``bridged_px``
    (length without a detected edge). For a skeleton also ``thickness_min_px``, ``thickness_median_px`` and
    ``thickness_max_px``.
    """
    return encode_csv_rows(_build_measure_rows(result), ("contour", "label", "closed", "length_px"))


def _build_measure_rows(result: Outcome) -> list[Row]:
    """Build the rows of `encode_measures`."""
    has, origin = _find_attributes(result), build_provenance_cells(result)
    measures, rows = measure(result.contours, result.spacing), []
    for index, (contour, one) in enumerate(zip(result.contours, measures, strict=True)):
        areas = {"gross": (one.area, one.area_in_units), "net": (one.net_area, one.net_area_in_units)}
        row: Row = {
            "contour": one.number,
            "label": one.label,
            "name": escape_cell(one.name),
            "color": one.color,
            "closed": _format_bool(one.closed),
            "junctions": one.junctions,
            "inside": one.inside,
            "strength": f"{one.strength:.6g}",
            "contrast": "" if one.contrast is None else f"{one.contrast:.4f}",
            "length_px": f"{one.length:.4f}",
            **{f"{name}_area_px2": f"{area:.4f}" if one.closed else "" for name, (area, _) in areas.items()},
        }
        if result.unit:
            unit = ascii_unit(result.unit, "")
            row[f"length_{unit}"] = f"{one.length_in_units:.7g}"
            row |= {f"{name}_area_{unit}2": f"{area:.7g}" if one.closed else "" for name, (_, area) in areas.items()}
        if "gray" in has:
            row["mean_gray"] = "" if contour.gray is None else f"{contour.gray:.6g}"
        if "category" in has:
            row["class"] = escape_cell(contour.category)
        if "group" in has:
            row |= {"object": contour.group, "hole": _format_bool(contour.hole), "bridged_px": f"{contour.bridged:.4f}"}
        if isinstance(result, Skeleton):
            for name, value in (("min", np.min), ("median", np.median), ("max", np.max)):
                row[f"thickness_{name}_px"] = f"{2.0 * value(result.radii[index]):.4f}"
        rows.append(row | origin)
    return rows


def encode_object_table(result: Outcome) -> bytes:
    """Tabulate the regions enclosed by closed contours, the open objects, or the objects in a volume, one per row.

    The columns are those of `Result.table`, in the unit of the image if it is known, which ends their names
    (``area_um2``), and name, class, color and confidence of objects, whose number is ``label``; in a
    volume with a place in space also the center in it (``x_LPS_mm``). An open object has no
    area and no pixels of its own, but a ``length``. For a skeleton it is the table of `encode_measures`. ValueError
    when there is no object.
    """
    if isinstance(result, Skeleton):
        return encode_measures(result)
    rows = _build_object_rows(result)
    if not rows:
        raise ValueError(
            f"{result.source} has no closed contour and no object, so a table of objects would be empty: continue the "
            "run."
        )
    return encode_csv_rows(rows)


def encode_tables_of_images(results: Iterable[Result]) -> bytes:
    """Tabulate the objects of several images, one per row: ``image``, then the columns of `encode_object_table`.

    Where the unit of lengths differs from image to image, each unit has columns of its own.
    """
    rows = chain.from_iterable(map(_build_object_rows, results))
    return encode_csv_rows([{"image": ""} | row for row in rows], ("image", "label"))


def _build_object_rows(result: Result) -> list[Row]:
    """Build the rows of `encode_object_table`."""
    measured = result.table(in_units=bool(result.unit))
    labels = assign_labels(result.contours)
    known: dict[int, Contour | Label] = {
        label: one for label, one in zip(labels, result.contours, strict=True) if label
    }
    known |= {} if result.surface is None else {body.number: body for body in result.surface.labels}
    columns: Row = {}
    for name, unit in measured.units.items():
        columns[name_column(name, unit)] = measured[name].tolist()
    rows: list[Row] = []
    unit, sides = ascii_unit(result.unit, "px"), result.spacing if result.unit else (1.0,) * len(result.shape)
    for values in zip(*columns.values(), strict=True):
        row = {
            name: f"{value:.7g}" if isinstance(value, float) else value
            for name, value in zip(columns, values, strict=True)
        }
        if len(result.shape) == 3 and result.geometry is not None:
            center = np.array([float(row[name]) for name in columns if name.startswith("centroid")])
            place = to_file_coordinates(center / sides, result.spacing, result.geometry)
            row |= {f"{axis}_LPS_{unit}": f"{at:.7g}" for axis, at in zip("xyz", place.tolist(), strict=True)}
        rows.append(row | _name_object(known.get(int(row["label"]))))
    lengths = dict[int, float]()
    for one in result.contours:
        if one.group and not one.closed:
            known[one.group] = one
            lengths[one.group] = lengths.get(one.group, 0.0) + path_length(one.path * sides)
    for number, length in lengths.items():
        rows.append({"label": number, f"length_{unit}": f"{length:.7g}"} | _name_object(known[number]))
    origin = build_provenance_cells(result)
    return [row | origin for row in rows]


def _name_object(known: Contour | Label | None) -> Row:
    """Build the cells of the name, class, color and confidence of an object; none of what is no object."""
    if known is None:
        return {}
    if isinstance(known, Contour) and not known.group:
        return {"name": escape_cell(known.name)}
    return {
        "name": escape_cell(known.name),
        "class": escape_cell(known.category),
        "color": known.color,
        "confidence": "" if known.confidence is None else f"{known.confidence:.3g}",
    }


def encode_page_vertices(found: StackResult) -> bytes:
    """Tabulate the vertices of the contours on all pages of a stack, one per row.

    Columns: ``page`` (from 1), ``time_s`` (since the first page, where the file states it), ``track`` (number that an
    object keeps from page to page), ``parent`` (track that it split off), ``begin`` (on its first page, how it comes
    into being), ``end`` (on its last page, how it comes to its end), and those of `encode_vertices` except ``contour``;
    ``label`` is the label in the label stack: the track, or 0 when open.
    """
    return encode_csv_rows(_build_page_rows(found, _build_vertex_rows), ("page", "track"))


def encode_page_measures(found: StackResult) -> bytes:
    """Tabulate the measures of the contours on all pages of a stack, one contour per row.

    Columns: ``page``, ``time_s``, ``track``, ``parent``, ``begin``, ``end``, ``centroid_row`` and ``centroid_col``
    (centroid of the enclosed area, or of the line of an open contour [px]), and those of `encode_measures` except
    ``contour``, with ``mean_gray``; ``label`` is the label in the label stack, and ``inside`` the track of the
    contour around it.
    """

    def build_rows_with_centroids(result: Outcome) -> list[Row]:
        rows = []
        for contour, row in zip(result.contours, _build_measure_rows(result), strict=True):
            center = compute_centroid(contour)
            rows.append({"centroid_row": f"{center[0]:.4f}", "centroid_col": f"{center[1]:.4f}"} | row)
        return rows

    return encode_csv_rows(_build_page_rows(found, build_rows_with_centroids), ("page", "track"))


def _build_page_rows(found: StackResult, build_rows: Callable[[Outcome], list[Row]]) -> list[Row]:
    """Build the rows of all pages, with page and track in front."""
    rows: list[Row] = []
    tracks = {track.number: track for track in found.tracks}
    for page, result in found.results:
        for row in build_rows(result):
            number: Any = row.pop("contour")
            track = tracks[number]
            begin, end = track.begin if page == track.pages[0] else None, ""
            if track.end is not None and page == track.pages[-1]:
                end = " into ".join(map(str, (track.end.kind, *track.end.others)))
            life: Row = {"parent": track.origin or "", "begin": begin or "", "end": end}
            place: Row = {"page": page} | ({} if found.interval is None else {"time_s": found.time_of(page)})
            rows.append(place | {"track": number} | life | row | {"label": number if row["label"] else 0})
    return rows


def build_provenance_cells(result: Outcome) -> Row:
    """Build the cells of the provenance, by column."""
    return {name: escape_cell(value) for name, value in flatten_provenance(describe_provenance(result)).items()}


def encode_csv_rows(rows: Sequence[Row], header: Sequence[str] = ()) -> bytes:
    """Encode rows as a UTF-8 CSV file with a header: commas, decimal points, and `header` as header without rows."""
    columns: Row = dict.fromkeys(chain.from_iterable(rows) if rows else header, "")
    stream = io.StringIO(newline="")
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows((columns | row).values() for row in rows)
    return stream.getvalue().encode()


def read_contour_csv(text: str, name: str) -> CollectedContours:
    """Read contours from a table with one vertex per row."""
    rows = list(csv.DictReader(text.splitlines()))
    columns = set(rows[0] if rows else ())
    number = "track" if "track" in columns and "contour" not in columns else "contour"
    missing = ({number} | _REQUIRED_COLUMNS) - columns
    if missing:
        raise UnreadableError(
            f"{name} is not a table of contours: it has no column {' or '.join(sorted(missing))}. Choose a table of "
            "vertices that CPM has written."
        )
    found = CollectedContours()
    for (page, of), group in groupby(rows, key=lambda row: (row.get("page") or "0", row[number])):
        vertices = list(group)
        first = vertices[0]
        found.add_contour(
            [(float(row["row"]), float(row["col"])) for row in vertices],
            first["closed"].strip().upper() == "TRUE",
            page=int(page),
            strength=first.get("strength") or 0.0,
            name=unescape_cell(first.get("name") or ""),
            color=first.get("color") or "",
            number=int(of) if of.strip().isdecimal() else 0,
        )
    return found
