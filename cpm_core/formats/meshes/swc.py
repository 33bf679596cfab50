"""SWC: center lines as a tree of points with radii, for Vaa3D, neuTube, SNT and other programs of neuroscience."""

from __future__ import annotations

import os
from collections import deque
from pathlib import Path

from cpm_core.formats.common.atomic import check_place, write_together
from cpm_core.formats.common.printable import printable
from cpm_core.formats.common.provenance import PROGRAM, facts_on, text_of
from cpm_core.formats.meshes.world import decimals_for, positions
from cpm_core.image.geometry import Convention, Geometry
from cpm_core.medial_axis.space.centerlines import Centerlines

_UNDEFINED = 0
"""Type of a point of no known structure."""


def write_swc(lines: Centerlines, path: str | os.PathLike[str], geometry: Geometry | None = None) -> None:
    """Write center lines as an SWC file; see `encode`. ValueError when it cannot be written there.

    Examples
    --------
    >>> inside = np.zeros((12, 12, 40), bool)
    >>> inside[4:9, 4:9, 4:36] = True
    >>> cpm.write_swc(cpm.centerlines(inside, unit="mm"), "rod.swc")
    """
    check_place(Path(path))
    write_together([(Path(path), encode(lines, geometry))])


def encode(lines: Centerlines, geometry: Geometry | None = None, space: Convention = "LPS") -> bytes:
    """Make an SWC file: a line of text for each point, with x, y, z and radius in the unit of the spacing, and parent.

    The coordinates are those of surfaces (`world`), in a volume with this geometry. SWC holds trees alone: a loop is
    cut at the end of one of its branches, where a point stands twice.
    """
    rows: list[tuple[int, float, float, float, float, int]] = []
    number: dict[int, int] = {}
    at_node: dict[int, list[int]] = {}
    for k, branch in enumerate(lines.branches):
        for node in branch.nodes:
            at_node.setdefault(node, []).append(k)
    done: set[int] = set()

    def add(branch: int, point: int, parent: int) -> int:
        x, y, z = positions(lines.branches[branch].points[point], lines.spacing, geometry, space).tolist()
        rows.append((len(rows) + 1, x, y, z, float(lines.branches[branch].radii[point]), parent))
        return len(rows)

    for first in range(len(lines.branches)):
        if first in done:
            continue
        root = lines.branches[first].nodes[0]
        number[root] = add(first, 0, -1)
        waiting = deque([root])
        while waiting:
            node = waiting.popleft()
            for k in at_node[node]:
                if k in done:
                    continue
                done.add(k)
                one, other = lines.branches[k].nodes
                count = len(lines.branches[k].points)
                order = range(1, count) if one == node else range(count - 2, -1, -1)
                last = number[node]
                for point in order:
                    last = add(k, point, last)
                beyond = other if one == node else one
                if beyond not in number:
                    number[beyond] = last
                    waiting.append(beyond)
    unit = {"µm": "um"}.get(lines.unit or "", lines.unit or "voxel")
    facts = printable(text_of(facts_on(lines.source, lines.provenance)))
    head = f"# {PROGRAM}\n# SPACE={space}\n# UNIT={unit}\n# {facts}\n# id type x y z radius parent\n"
    form = f"{{}} {_UNDEFINED}" + 4 * f" {{:.{decimals_for(lines.spacing)}f}}" + " {}\n"
    text = "".join(form.format(*row) for row in rows)
    return (head + text).encode("ascii", "replace")
