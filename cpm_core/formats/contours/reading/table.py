"""Tables of vertices: those of CPM, of an image or of a stack, and the shapes of napari."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from itertools import groupby

import numpy as np

from cpm_core.contours.contour import present_names
from cpm_core.formats.common.printable import text_of_cell
from cpm_core.formats.contours.reading.contents import Contents
from cpm_core.formats.contours.reading.curves import ellipse
from cpm_core.formats.images.decoded import UnreadableError

_OWN = ("closed", "row", "col")
_NAPARI = ("index", "shape-type", "vertex-index")

Row = Mapping[str, str]


def read(text: str, name: str) -> Contents:
    """Contours of a table with one vertex in each row."""
    rows = [present_names(row) for row in csv.DictReader(text.splitlines())]
    columns = set(rows[0] if rows else ())
    if columns >= set(_NAPARI):
        return _shapes(rows)
    number = "track" if "track" in columns and "contour" not in columns else "contour"
    missing = {number, *_OWN} - columns
    if missing:
        raise UnreadableError(
            f"{name} is not a table of contours: it has no column {' or '.join(sorted(missing))}. Choose a table of "
            "vertices that CPM has written."
        )
    found = Contents()
    for (page, of), group in groupby(rows, key=lambda row: (row.get("page") or "0", row[number])):
        vertices = list(group)
        first = vertices[0]
        found.add(
            [(float(row["row"]), float(row["col"])) for row in vertices],
            first["closed"].strip().upper() == "TRUE",
            page=int(page),
            strength=first.get("strength") or 0.0,
            name=text_of_cell(first.get("name") or ""),
            color=first.get("color") or "",
            number=int(of) if of.strip().isdecimal() else 0,
        )
    return found


def _shapes(rows: Sequence[Row]) -> Contents:
    """Shapes of napari, whose last two axes are row and column."""
    found = Contents()
    axes = sorted((column for column in rows[0] if column.startswith("axis-")), key=lambda name: int(name[5:]))
    for _, group in groupby(rows, key=lambda row: row["index"]):
        vertices = list(group)
        kind = vertices[0]["shape-type"].strip()
        places = np.array([[float(row[axis]) for axis in axes] for row in vertices])
        page = 1 + round(places[0, -3]) if len(axes) > 2 else 0
        corners = places[:, -2:]
        if kind == "ellipse":
            center = corners.mean(axis=0)
            corners = ellipse(center, 0.5 * (corners[1] - corners[0]), 0.5 * (corners[2] - corners[1]))
        if kind in ("ellipse", "rectangle", "polygon", "path", "line"):
            found.add(corners, kind not in ("path", "line"), page=page)
        else:
            found.left_out[f"shape of the kind {kind}"] += 1
    return found
