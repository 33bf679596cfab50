"""SWC: center lines as trees of points with radii, of Vaa3D, neuTube, SNT and other programs of neuroscience."""

from __future__ import annotations

import io
import logging
import warnings
from collections import deque
from collections.abc import Callable

import numpy as np
import scipy

from cpm_core.contours.graph import Graph
from cpm_core.formats.common.content import AnySource, find_local_file, read_content
from cpm_core.formats.common.provenance import PROGRAM_NAME, describe_image_provenance, dump_provenance
from cpm_core.formats.images.resolution import ascii_unit
from cpm_core.formats.meshes.coordinates import count_decimals, find_voxel_transform, to_file_coordinates
from cpm_core.image.geometry import Convention
from cpm_core.image.image import Image
from cpm_core.medial_axis.centerlines import CenterlineBranch, Centerlines, sort_branches_by_length
from cpm_core.numerics.types import Array
from cpm_core.parameters.formatting import quote_value

_LOG = logging.getLogger(__name__)

_COLUMN_COUNT = 7
"""Number of columns: number, kind, x, y, z, radius, number of the parent."""

_SAME_POINT_DISTANCE = 1e-3
"""Distance up to which the end of a branch coincides with another point [smallest side of a voxel]."""

_UNDEFINED_TYPE = 0
"""Type of a point whose structure is unknown."""


def encode_swc(lines: Centerlines, space: Convention = "LPS") -> bytes:
    """Encode center lines as SWC: a line per point, with x, y, z and radius in the unit of the spacing, and parent.

    The coordinates are those of surfaces, in a volume with the geometry of the lines. SWC holds only trees: a loop is
    cut at the end of one of its branches, where a point is written twice.
    """
    rows: list[tuple[int, float, float, float, float, int]] = []
    number: dict[int, int] = {}
    at_node: dict[int, list[int]] = {}
    for k, branch in enumerate(lines.branches):
        for node in branch.nodes:
            at_node.setdefault(node, []).append(k)
    done: set[int] = set()
    for first in range(len(lines.branches)):
        waiting = deque([first])
        while waiting:
            k = waiting.popleft()
            if k in done:
                continue
            done.add(k)
            branch = lines.branches[k]
            places = to_file_coordinates(branch.points, lines.spacing, lines.geometry, space)
            points, (begin, end) = list(zip(places.tolist(), branch.radii.tolist(), strict=True)), branch.nodes
            if begin not in number and end in number:
                points, begin, end = points[::-1], end, begin
            parent = number.get(begin, -1)
            for (x, y, z), radius in points if parent < 0 else points[1:]:
                rows.append((len(rows) + 1, x, y, z, radius, parent))
                parent = len(rows)
                number.setdefault(begin, parent)
            number.setdefault(end, parent)
            waiting.extend((*at_node[begin], *at_node[end]))
    facts = dump_provenance(describe_image_provenance(lines.source, lines.provenance))
    head = (
        PROGRAM_NAME,
        f"SPACE={space}",
        f"UNIT={ascii_unit(lines.unit, 'voxel')}",
        facts,
        "id type x y z radius parent",
    )
    form = f"{{}} {_UNDEFINED_TYPE}" + 4 * f" {{:.{count_decimals(lines.spacing)}f}}" + " {}\n"
    text = "".join(form.format(*row) for row in rows)
    return ("".join(f"# {line}\n" for line in head) + text).encode()


def load_centerlines(
    path: AnySource,
    image: Image | None = None,
    *,
    space: Convention | None = None,
    warn: Callable[[str], object] = _LOG.warning,
) -> Centerlines:
    """Read center lines from an SWC file, written by `export` or by another program.

    Parameters
    ----------
    path : path-like or file-like
        A file of SWC.
    image : Image, optional
        The volume that they belong to: vertices are returned in its voxels. Without it a voxel is one unit of the
        file.
    space : {"LPS", "RAS"}, optional
        Directions of x, y and z; by default as stated in the file, else LPS.
    warn : callable, optional
        Called with a sentence for each omission or assumption; by default a warning is logged.

    Returns
    -------
    Centerlines
        Branches between ends and junctions, the longest first. A branch that ends on another one ends at a junction
        there, which restores loops.

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
    file = find_local_file(path)
    text = read_content(file).decode("utf-8-sig", "replace")
    rows = _parse_rows(text, file.name)
    remarks = "\n".join(line for line in text.splitlines() if line.lstrip().startswith("#"))
    place, notes = find_voxel_transform(remarks, image, space)
    points, radii = place.to_voxels(rows[:, 2:5]), rows[:, 5] * place.scale
    index = {number: k for k, number in enumerate(rows[:, 0].tolist())}
    parents = rows[:, 6].tolist()
    if len(index) < len(rows) or any(parent >= 0 and parent not in index for parent in parents):
        raise ValueError(
            f"{file.name} has two points of the same number, or a point without its parent: write it again."
        )
    links = [(index[parent], k) for k, parent in enumerate(parents) if parent >= 0]
    degree = np.bincount(np.array(links, np.int64).reshape(-1), minlength=len(rows))
    same, physical = (
        np.arange(len(rows)),
        points * place.spacing,
    )  # an end at the position of another point is merged with it
    near, reach = scipy.spatial.KDTree(physical), _SAME_POINT_DISTANCE * min(place.spacing)
    for k in np.flatnonzero(degree == 1).tolist():
        others = [other for other in near.query_ball_point(physical[k], reach) if other != k and same[other] == other]
        if others:
            same[k] = min(others)
    branches = _trace_branches(points, radii, [(int(same[a]), int(same[b])) for a, b in links if same[a] != same[b]])
    if not branches:
        raise ValueError(f"{file.name} contains single points and no lines: choose a file with lines.")
    for note in notes:
        warn(f"{file.name}: {note}")
    geometry = None if image is None else image.geometry
    return sort_branches_by_length(Centerlines(tuple(branches), place.spacing, place.unit, file.name, geometry))


def _parse_rows(text: str, name: str) -> Array:
    """Parse the numbers of all points, shape (N, 7); ValueError for a line with fewer."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about a file without lines, which is refused below
            rows = np.loadtxt(io.StringIO(text.replace(",", " ")), usecols=range(_COLUMN_COUNT), ndmin=2)
    except (ValueError, OverflowError) as error:
        raise ValueError(
            f"{name} has a line that is not seven numbers (number, kind, x, y, z, radius, parent), "
            f"{quote_value(str(error))}: write it again."
        ) from error
    if not len(rows) or not np.isfinite(rows).all():
        raise ValueError(f"{name} contains no center lines: choose a file of SWC.")
    return np.asarray(rows)


def _trace_branches(points: Array, radii: Array, links: list[tuple[int, int]]) -> list[CenterlineBranch]:
    """Trace the chains of links between points where other than two meet; rings begin at any point."""
    ways = Graph(points, np.array(links, np.int64)).find_paths()
    branches = []
    for way, closed in enumerate(ways.closed.tolist()):
        chain = ways.path_vertices(way)
        chain = np.append(chain, chain[:closed])
        branches.append(CenterlineBranch(points[chain], radii[chain], (int(chain[0]), int(chain[-1]))))
    return branches
