"""SWC: center lines as trees of points, of neuroscience; a point that stands twice closes a loop again."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import scipy

from cpm_core.formats.common.content import content_of
from cpm_core.formats.meshes.reading.place import Place, place_of
from cpm_core.image.geometry import Convention
from cpm_core.image.image import Image
from cpm_core.medial_axis.space.centerlines import Branch, Centerlines
from cpm_core.numerics.types import Array
from cpm_core.parameters.quotation import shown

_LOG = logging.getLogger(__name__)

_COLUMNS = 7
"""Number, kind, x, y, z, radius, number of the parent."""

_SAME = 1e-3
"""Distance up to which the end of a branch is the same point as another [smallest sides of a voxel]."""


def load_centerlines(
    path: str | os.PathLike[str],
    image: Image | None = None,
    *,
    space: Convention | None = None,
    tell: Callable[[str], object] = _LOG.warning,
) -> Centerlines:
    """Read center lines from an SWC file, written by `export`, `write_swc` or by another program.

    Parameters
    ----------
    path : path-like
        A file of SWC.
    image : Image, optional
        The volume that they belong to: their vertices come back in voxels of it. Without it a voxel is as large as a
        unit of the file.
    space : {"LPS", "RAS"}, optional
        Where x, y and z of the file point; by default as the file tells, and LPS where it does not.
    tell : callable, optional
        Called with a sentence for what was left out or assumed; by default a warning is logged.

    Returns
    -------
    Centerlines
        Branches between ends and junctions, the longest first. A branch that ends where another one passes ends at a
        junction there, so that loops come back.

    Raises
    ------
    ValueError
        When the file cannot be read or holds no lines; one sentence with its name and what to do.

    Examples
    --------
    >>> inside = np.zeros((12, 12, 40), bool)
    >>> inside[4:9, 4:9, 4:36] = True
    >>> lines = cpm.centerlines(inside)
    >>> cpm.export(lines, "rod.swc")
    >>> cpm.load_centerlines("rod.swc")
    <Centerlines rod.swc, 1 branch, 27.9 voxels>
    """
    file = Path(path)
    try:
        text = content_of(file).decode("utf-8-sig", "replace")
        lines, notes = _lines(text, file.name, image, space)
    except MemoryError:
        raise ValueError(f"{file.name} does not fit into memory: choose a smaller file.") from None
    for note in notes:
        tell(f"{file.name}: {note}")
    return lines


def _lines(text: str, name: str, image: Image | None, space: Convention | None) -> tuple[Centerlines, tuple[str, ...]]:
    remarks = "\n".join(line for line in text.splitlines() if line.lstrip().startswith("#"))
    rows = _rows(text, name)
    place, notes = place_of(remarks, image, space)
    points, radii = place.voxels(rows[:, 2:5]), rows[:, 5] * place.scale
    branches = _branches(points, radii, _joints(points, rows, place, name))
    if not branches:
        raise ValueError(f"{name} holds single points and no lines: choose a file with lines.")
    found = Centerlines(tuple(branches), place.spacing, place.unit, name, None if image is None else image.geometry)
    order = np.argsort(-found.lengths, kind="stable")
    ordered = tuple(branches[k] for k in order)
    return Centerlines(ordered, found.spacing, found.unit, name, found.geometry), notes


def _rows(text: str, name: str) -> Array:
    """The numbers of all points, shape (N, 7); ValueError when a line does not hold as many."""
    rows = []
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.partition("#")[0].replace(",", " ").split()
        if not words:
            continue
        try:
            row = [float(word) for word in words[:_COLUMNS]]
        except ValueError:
            row = []
        if len(row) < _COLUMNS or not np.isfinite(row).all():
            raise ValueError(
                f"Line {number} of {name} is {shown(line.strip())} but must be seven numbers: number, kind, x, y, z, "
                "radius and the number of the parent."
            )
        rows.append(row)
    if not rows:
        raise ValueError(f"{name} holds no center lines: choose a file of SWC.")
    return np.array(rows)


def _joints(points: Array, rows: Array, place: Place, name: str) -> list[tuple[int, int]]:
    """Links (parent, child) between points; an end that lies at another point is that point."""
    index = {int(number): k for k, number in enumerate(rows[:, 0].tolist())}
    if len(index) < len(rows):
        raise ValueError(f"{name} has two points of the same number: write it again.")
    parents = rows[:, 6].astype(np.int64).tolist()
    missing = next((parent for parent in parents if parent >= 0 and parent not in index), None)
    if missing is not None:
        raise ValueError(f"{name} names the point {missing} as a parent, but there is none: write it again.")
    links = [(index[parent], k) for k, parent in enumerate(parents) if parent >= 0]
    degree = np.bincount(np.array(links, np.int64).reshape(-1), minlength=len(rows))
    same = np.arange(len(rows))
    physical = points * place.spacing
    near = scipy.spatial.KDTree(physical)
    reach = _SAME * min(place.spacing)
    for k in np.flatnonzero(degree == 1).tolist():
        others = [other for other in near.query_ball_point(physical[k], reach) if other != k and same[other] == other]
        if others:
            same[k] = min(others)
    return [(int(same[a]), int(same[b])) for a, b in links if same[a] != same[b]]


def _branches(points: Array, radii: Array, links: list[tuple[int, int]]) -> list[Branch]:
    """Chains of links between points at which not just two meet; rings without any such point begin anywhere."""
    beside: dict[int, list[int]] = {}
    for a, b in links:
        beside.setdefault(a, []).append(b)
        beside.setdefault(b, []).append(a)
    open_links = {frozenset(link) for link in links}
    nodes = [point for point, others in beside.items() if len(others) != 2]
    branches = []
    for start in (*nodes, *beside):
        for first in beside[start]:
            if frozenset((start, first)) not in open_links:
                continue
            chain = [start, first]
            open_links.remove(frozenset((start, first)))
            while len(beside[chain[-1]]) == 2 and chain[-1] != start:
                one, other = beside[chain[-1]]
                chain.append(other if one == chain[-2] else one)
                open_links.discard(frozenset(chain[-2:]))
            branches.append(Branch(points[chain], radii[chain], (chain[0], chain[-1])))
    return branches
