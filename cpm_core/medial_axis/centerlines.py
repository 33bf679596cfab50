"""Center lines of vessels and other long structures in a volume, with radii, as a graph of branches.

The inside is thinned to lines of voxels (`structure`); scikit-image's own thinning loses rods of an even width. Voxels
at which more than two lines meet become one junction. A branch with a free end is a wrinkle of the surface, and is
pruned, if it hardly leaves the largest ball around its junction, or if its tip does not protrude from that ball. The
others are moved to the middle between voxels that are as deep, and smoothed along their length.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import field, replace
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import ArrayLike

from cpm_core.contours.contour import Contour
from cpm_core.image.geometry import Geometry
from cpm_core.numerics import polyline
from cpm_core.numerics.grids import first_pixel, grid_points
from cpm_core.numerics.real_numbers import as_real_array, check_finite_number, check_voxel_sides
from cpm_core.numerics.types import Array, Arrays, Sides, record
from cpm_core.numerics.voxel_graph import Chain, find_chains, thin_to_lines
from cpm_core.parameters.formatting import format_count, format_repr
from cpm_core.parameters.provenance import Provenance

_CENTERLINE_SMOOTHING = 1.5
"""Width of the Gaussian along a branch [voxels of the line]."""

_MIN_PROTRUSION = 4.0
"""Least distance by which the ball around the tip of a branch protrudes from the one at its junction [smallest sides]:
the constant in the radius of the ball that TEASAR clears around a line (Sato et al. 2000,
10.1109/PCCGA.2000.883951)."""

_WALL_OFFSET = 0.2
"""Distance of the nearest wall around a line beyond the surface: 0 where tubes run askew, 0.5 along axes [sides]."""

_DEPTH_TOLERANCE = 0.1
"""Voxels whose depth differs by less are about as deep [smallest sides of a voxel]."""

_NEIGHBORHOOD_OFFSETS = grid_points(3 * [np.arange(-1, 2)])
"""Offsets of the 27 voxels in and around a voxel, shape (27, 3)."""

_SMOOTHING_MARGIN = 8
"""Number of voxels by which a branch continues beyond its ends when it is smoothed."""


@record
class CenterlineBranch:
    """A stretch of center line between junctions or ends.

    Attributes
    ----------
    points : ndarray, shape (N, 3)
        Positions (plane, row, col) [voxels], both ends included; a closed one ends where it begins.
    radii : ndarray, shape (N,)
        Distance to the surface, in the unit of the spacing.
    nodes : tuple of int
        Junction or end at which it begins, and at which it ends; equal numbers are one place.
    """

    points: Array
    radii: Array
    nodes: tuple[int, int]

    @property
    def closed(self) -> bool:
        """Whether it ends where it begins."""
        return self.nodes[0] == self.nodes[1] and len(self.points) > 2

    def __repr__(self) -> str:
        return format_repr(
            "CenterlineBranch",
            format_count(len(self.points), "vertex", "vertices"),
            "closed" if self.closed else "open",
        )


@record
class Centerlines:
    """Center lines in a volume.

    Attributes
    ----------
    branches : tuple of CenterlineBranch
        The longest first.
    spacing : tuple of float
        Size of a voxel along each axis, in `unit`.
    unit : str or None
        Unit of length.
    source : str
        Name of the volume for the user.
    geometry : Geometry or None
        Where the volume lies in space.
    provenance : Provenance
        How they were found.

    Examples
    --------
    >>> inside = np.zeros((12, 12, 40), bool)
    >>> inside[4:9, 4:9, 4:36] = True
    >>> lines = cpm.centerlines(inside)
    >>> len(lines.contours), len(lines.radii[0]) == len(lines.contours[0].points), lines.lengths.shape
    (1, True, (1,))
    """

    branches: tuple[CenterlineBranch, ...]
    spacing: Sides = (1.0, 1.0, 1.0)
    unit: str | None = None
    source: str = "volume"
    geometry: Geometry | None = None
    provenance: Provenance = field(default_factory=Provenance)

    @cached_property
    def contours(self) -> tuple[Contour, ...]:
        """The branches as curves with vertices (plane, row, col) [voxels]; a closed one does not repeat its first."""
        ends = Counter(node for branch in self.branches for node in branch.nodes)
        found = []
        for branch, radii in zip(self.branches, self.radii, strict=True):
            first, last = (ends[node] > 2 for node in branch.nodes)
            found.append(Contour(branch.points[: len(radii)], branch.closed, junctions=(first, last)))
        return tuple(found)

    @cached_property
    def radii(self) -> Arrays:
        """For every contour the distance of its vertices from the surface, in `unit`."""
        return tuple(branch.radii[:-1] if branch.closed else branch.radii for branch in self.branches)

    @cached_property
    def lengths(self) -> Array:
        """Length of each branch, in `unit`."""
        steps = [np.diff(branch.points * self.spacing, axis=0) for branch in self.branches]
        return np.array([np.linalg.norm(step, axis=1).sum() for step in steps])

    def __repr__(self) -> str:
        branches = format_count(len(self.branches), "branch", "branches")
        return format_repr("Centerlines", self.source, branches, f"{self.lengths.sum():,.1f} {self.unit or 'voxels'}")


def sort_branches_by_length(lines: Centerlines) -> Centerlines:
    """Sort branches by length, the longest first."""
    order = np.argsort(-lines.lengths, kind="stable")
    return replace(lines, branches=tuple(lines.branches[k] for k in order))


def centerlines(
    inside: ArrayLike, spacing: Sides = (1.0, 1.0, 1.0), unit: str | None = None, pruning: float = 1.0
) -> Centerlines:
    """Find the center lines of the inside of a label volume.

    Parameters
    ----------
    inside : array_like of bool or numbers, shape (P, R, C)
        Volume in which everything but zero is inside.
    spacing : tuple of float
        Size of a voxel along each axis, in `unit`.
    unit : str, optional
        Unit of length.
    pruning : float
        Branches that end in the open are pruned up to this length, in radii at their junction, and those that end
        less than four of the smallest sides of a voxel beyond the ball there; 0 prunes none.

    Returns
    -------
    Centerlines
        Without branches when nothing is inside.

    Raises
    ------
    ValueError
        When `inside` is no volume, or `spacing` is not three positive numbers.

    Examples
    --------
    >>> inside = np.zeros((12, 12, 40), bool)
    >>> inside[4:9, 4:9, 4:36] = True
    >>> lines = cpm.centerlines(inside, spacing=(1.0, 1.0, 0.5), unit="mm")
    >>> len(lines.branches), round(float(lines.lengths.sum())) in range(11, 17)
    (1, True)
    """
    mask = inside if isinstance(inside, np.ndarray) and inside.dtype == np.bool_ else as_real_array(inside) != 0
    if mask.ndim != 3:
        raise ValueError(f"The inside has the shape {mask.shape}, but must be a volume (plane, row, col).")
    size = check_voxel_sides("spacing", spacing)
    check_finite_number("pruning", pruning, lambda length: length >= 0.0, "0 or more")
    if not mask.any():
        return Centerlines((), tuple(spacing), unit)
    box = scipy.ndimage.find_objects(mask.astype(np.int8))[0]
    part, low = np.pad(mask[box], 1), first_pixel(box)
    # from the surface, halfway between voxels inside and outside
    depth = np.maximum(scipy.ndimage.distance_transform_edt(part, sampling=size) - 0.5 * size.min(), 0.0)
    lines = thin_to_lines(part, depth)

    def is_wrinkle(chain: Chain) -> bool:
        """Return whether a chain hardly leaves the ball at its junction, or its tip with its ball hardly sticks out."""
        points = chain.points if chain.free_end else chain.points[::-1]  # from the junction
        tip = chain.own[-1 if chain.free_end else 0]
        reach = pruning * float(depth[tuple(np.rint(points[0]).astype(int))])
        length = polyline.path_length(points * size)
        away = np.linalg.norm((points[-1] - points[0]) * size)
        salient = away + depth[tuple(tip)] > reach + _MIN_PROTRUSION * size.min()
        return bool(length <= reach or (pruning > 0.0 and not salient))

    # remove short chains with a free end, until none is left
    chains = find_chains(lines)
    while short := [chain for chain in chains if chain.is_spur and is_wrinkle(chain)]:
        for chain in short:
            lines[tuple(chain.own.T)] = False
        chains = find_chains(lines)
    walls = scipy.spatial.KDTree(np.argwhere(~part & scipy.ndimage.binary_dilation(part)) * size)
    sides = depth / size.min()
    branches = [_smooth_branch(chain, sides, walls, size, (low - 1).astype(float)) for chain in chains]
    return sort_branches_by_length(Centerlines(tuple(branches), tuple(spacing), unit))


def _smooth_branch(
    chain: Chain, depth: Array, walls: scipy.spatial.KDTree, size: Array, begin: Array
) -> CenterlineBranch:
    """Move a chain of voxels to the mean of those around that are about as deep as the deepest, and smooth it.

    Its ends are kept; `walls` are the voxels around the inside.
    """
    voxels = np.rint(chain.points).astype(int)[:, None] + _NEIGHBORHOOD_OFFSETS
    depths = depth[tuple(np.clip(voxels, 0, np.array(depth.shape) - 1).transpose(2, 0, 1))]
    deepest = depths >= depths.max(1, keepdims=True) - _DEPTH_TOLERANCE
    points = (voxels * deepest[..., None]).sum(1) / deepest.sum(1, keepdims=True)
    if chain.nodes[0] == chain.nodes[1]:
        points[-1] = points[0]
    if len(points) > 2:
        straight = points[0] + np.linspace(0.0, 1.0, len(points))[:, None] * (points[-1] - points[0])
        bent = np.pad(
            points - straight, ((_SMOOTHING_MARGIN, _SMOOTHING_MARGIN), (0, 0)), "reflect", reflect_type="odd"
        )
        points = (
            straight
            + scipy.ndimage.gaussian_filter1d(bent, _CENTERLINE_SMOOTHING, axis=0)[_SMOOTHING_MARGIN:-_SMOOTHING_MARGIN]
        )
    distances = walls.query(points * size)[0]
    return CenterlineBranch(points + begin, np.maximum(distances - _WALL_OFFSET * size.min(), 0.0), chain.nodes)
