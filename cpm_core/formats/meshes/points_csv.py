"""Particles of a run in a volume as a table, one in each line."""

from __future__ import annotations

import csv
import io

from cpm_core.contours.result import Result
from cpm_core.formats.common.printable import cell
from cpm_core.formats.common.provenance import entries_of, facts_of
from cpm_core.medial_axis.skeleton import Skeleton


def encode(result: Result | Skeleton) -> bytes:
    """Positions ``plane,row,col`` in voxels, below a header; ValueError for what has no particles in a volume.

    The columns behind these tell the origin (`provenance.entries_of`), in the first line alone.
    """
    if not isinstance(result, Result) or result.particles.shape[1] != 3 or not len(result.particles):
        raise ValueError("There are no particles in a volume to write: run in a volume first.")
    origin = {name: cell(text) for name, text in entries_of(facts_of(result)).items()}
    stream = io.StringIO(newline="")
    table = csv.writer(stream, lineterminator="\n")
    table.writerow(["plane", "row", "col", *origin])
    empty = [""] * len(origin)
    for number, place in enumerate(result.particles.tolist()):
        table.writerow([*(f"{at:.7g}" for at in place), *(empty if number else origin.values())])
    return stream.getvalue().encode()
