"""A surface in a volume: triangles, and the figures that tell whether to trust them."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from cpm_core.image import drawing
from cpm_core.image.colors import check_color
from cpm_core.numerics.grids import label_joined_pairs
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.real_numbers import check_rows, check_voxel_sides
from cpm_core.numerics.types import Array, Extent, Index, Mask, Sides, frozen, record
from cpm_core.parameters.formatting import format_count, format_repr


@frozen
class Label:
    """Name, color, ``"#rrggbb"``, name of the class, and confidence of the object with a number; each may be empty."""

    number: int
    name: str = ""
    color: str = ""
    category: str = ""
    confidence: float | None = None

    def __post_init__(self) -> None:
        check_color("a label", self.color)


@record
class Surface:
    """Triangles in a volume.

    Attributes
    ----------
    vertices : ndarray of float64, shape (N, 3)
        Positions (plane, row, col) [voxels], voxel centers at integers.
    faces : ndarray of int64, shape (F, 3)
        Vertices of each triangle, in such an order that its normal, by the right-hand rule in (plane, row, col),
        points outward: to the dark side of an edge, or where given normals point.
    spacing : tuple of float
        Size of a voxel along each axis, in `unit`.
    unit : str or None
        Unit of length of `spacing`; None when it is not known.
    unsupported : float
        Share of the vertices that have no particle near: there the surface is a guess. NaN when it is not known.
    left_out : int
        Number of components that were left out for too few particles, or too many vertices without any near.
    numbers : ndarray of int64, shape (F,), or None
        Number, from 1 up, of the object that each triangle bounds; None where objects have no numbers.
    labels : tuple of Label
        Names and colors of these objects; empty where none has been given.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("ball"), cpm.sphere((15, 15, 15), 4, 60), cpm.PRESETS["volume"])
    >>> surface = result.surface
    >>> surface.closed, surface.components, surface.euler, surface.free_edges, surface.nonmanifold_edges
    (True, 1, 2, 0, 0)
    >>> round(surface.volume / (4 / 3 * np.pi * 9**3), 2), round(surface.area / (4 * np.pi * 9**2), 1)
    (1.0, 1.0)
    >>> surface.normals.shape == surface.vertices.shape, int(surface.component_of_vertex.max())
    (True, 0)
    >>> axes = surface.plot()
    """

    vertices: Array
    faces: Index
    spacing: Sides = (1.0, 1.0, 1.0)
    unit: str | None = None
    unsupported: float = np.nan
    left_out: int = 0
    numbers: Index | None = None
    labels: tuple[Label, ...] = ()

    def __post_init__(self) -> None:
        vertices = check_rows("vertices", self.vertices, 3).copy()
        faces = check_rows("faces", self.faces, 3, "indices of three vertices").astype(np.int64)
        wrong = faces[(faces < 0) | (faces >= len(vertices))]
        if len(wrong):
            raise ValueError(f"A triangle names vertex {wrong[0]}, but there are {len(vertices)} vertices, from 0.")
        if self.numbers is not None and (
            np.shape(self.numbers) != (len(faces),) or np.min(self.numbers, initial=1) < 1
        ):
            raise ValueError("The numbers of a surface must be one of at least 1 for each triangle.")
        object.__setattr__(self, "spacing", tuple(check_voxel_sides("The spacing of a surface", self.spacing).tolist()))
        for name, values in (("vertices", vertices), ("faces", faces)):
            values.flags.writeable = False
            object.__setattr__(self, name, values)

    def __repr__(self) -> str:
        return format_repr(
            "Surface", format_count(len(self.vertices), "vertex", "vertices"),
            format_count(len(self.faces), "triangle"), format_count(self.components, "part"),
            "closed" if self.closed else "open",
        )  # fmt: skip

    def plot(self, ax: drawing.Axes | None = None) -> drawing.Axes:
        """Draw the surface by matplotlib, in units of length.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes with ``projection="3d"``; by default those of a new figure.

        Returns
        -------
        matplotlib.axes.Axes
            The axes (x is the column, y the row, z the plane).

        Raises
        ------
        ValueError
            When `ax` are no axes in space.
        """
        space: Any = drawing.axes_for(ax, space=True)
        plane, row, col = self._physical.T
        look = {"color": "#7fb8dc", "linewidth": 0.0, "antialiased": False, "shade": True}
        space.plot_trisurf(col, row, plane, triangles=self.faces, **look)
        space.set_box_aspect(np.maximum(np.ptp(self._physical[:, ::-1], axis=0), 1e-9))
        name = self.unit or "voxels"
        space.set(xlabel=f"column [{name}]", ylabel=f"row [{name}]", zlabel=f"plane [{name}]")
        space.invert_yaxis()
        return space

    @cached_property
    def normals(self) -> Array:
        """Unit vectors outward at the vertices, in units of length, shape (N, 3); zero where there is no triangle."""
        sums = np.zeros((len(self.vertices), 3))
        _sum_at_vertices(self.faces, self._crosses, sums)
        lengths = np.linalg.norm(sums, axis=1)
        sums[lengths > 0] /= lengths[lengths > 0, None]
        return sums

    @cached_property
    def area(self) -> float:
        """Area, in `unit` squared."""
        return float(np.linalg.norm(self._crosses, axis=1).sum() / 2.0)

    @cached_property
    def volume(self) -> float:
        """Volume that a closed surface encloses, in `unit` cubed; hollows count as outside."""
        if not len(self.faces):
            return 0.0
        center = self._physical.mean(0)
        return float(np.einsum("ij,ij->", self._physical[self.faces[:, 0]] - center, self._crosses) / 6.0)

    @cached_property
    def euler(self) -> int:
        """Euler characteristic: vertices - edges + triangles; 2 for a ball, 0 for a torus, their sum for several."""
        return len(np.unique(self.faces)) - len(self._edge_counts) + len(self.faces)

    @cached_property
    def free_edges(self) -> int:
        """Number of edges with one triangle; a closed surface has none."""
        return int((self._edge_counts == 1).sum())

    @cached_property
    def nonmanifold_edges(self) -> int:
        """Number of edges with more than two triangles."""
        return int((self._edge_counts > 2).sum())

    @cached_property
    def component_of_vertex(self) -> Index:
        """Number of the component of each vertex, from 0 up; vertices without a triangle have their own."""
        one, other = self.faces[:, [0, 1]].ravel(), self.faces[:, [1, 2]].ravel()
        return label_joined_pairs((one, other), len(self.vertices))

    @cached_property
    def components(self) -> int:
        """Number of connected components."""
        return len(np.unique(self.component_of_vertex[self.faces[:, 0]]))

    @property
    def closed(self) -> bool:
        """Whether every edge has two triangles, so that there is an inside."""
        return len(self.faces) > 0 and not self.free_edges and not self.nonmanifold_edges

    @cached_property
    def _physical(self) -> Array:
        return self.vertices * np.array(self.spacing)

    @cached_property
    def _crosses(self) -> Array:
        """Outward normals of the triangles, in units of length, as long as twice their area."""
        crosses = np.empty((len(self.faces), 3))
        _compute_crosses(self.faces, self._physical, crosses)
        return crosses

    @cached_property
    def _edge_counts(self) -> Index:
        """Number of triangles at each edge."""
        one, other = self.faces.ravel(), self.faces[:, [1, 2, 0]].ravel()
        numbers = np.minimum(one, other) * len(self.vertices) + np.maximum(one, other)
        return np.unique(numbers, return_counts=True)[1]


@compiled
def _compute_crosses(faces: Index, vertices: Array, crosses: Array) -> None:
    """Write the cross product of two sides of each triangle, shape (F, 3)."""
    for q in range(len(faces)):
        a, b, c = faces[q]
        for axis in range(3):
            one, other = (axis + 1) % 3, (axis + 2) % 3
            crosses[q, axis] = (vertices[b, one] - vertices[a, one]) * (vertices[c, other] - vertices[a, other]) - (
                vertices[b, other] - vertices[a, other]
            ) * (vertices[c, one] - vertices[a, one])


@compiled
def _sum_at_vertices(faces: Index, vectors: Array, sums: Array) -> None:
    """Add the vector of each triangle, shape (F, 3), at its vertices."""
    for q in range(len(faces)):
        for corner in range(3):
            for axis in range(3):
                sums[faces[q, corner], axis] += vectors[q, axis]


_LINE_OFFSET = (1.3e-6, 2.9e-6)
"""Offset of the probing lines from the voxel centers [voxels], so that they hit no vertex of a surface on the grid."""


def voxelize_surface(surface: Surface, shape: Extent) -> Mask:
    """Mark the voxels of a volume whose centers lie inside a closed surface; hollows are outside.

    Parameters
    ----------
    surface : Surface
        Closed surface [voxels].
    shape : tuple of int
        Shape of the volume, (planes, rows, columns).

    Returns
    -------
    ndarray of bool, shape `shape`
        True inside, by the parity of crossings along each row.
    """
    corners = surface.vertices[surface.faces] - (*_LINE_OFFSET, 0.0)
    low = np.clip(np.ceil(corners.min(axis=1)), 0, shape).astype(np.int64)
    high = np.clip(np.floor(corners.max(axis=1)) + 1, 0, shape).astype(np.int64)
    found = np.zeros(shape, bool)
    if not len(corners):
        return found
    first = low.min(axis=0)
    around = found[tuple(map(slice, first, high.max(axis=0)))]
    _mark_crossings(corners, low, high, first, around)
    np.logical_xor.accumulate(around, axis=2, out=around)  # an even number of crossings cancels out
    return found


@compiled
def _mark_crossings(corners: Array, low: Index, high: Index, first: Index, crossed: Mask) -> None:
    """Turn the first voxel over beyond each crossing of triangles, shape (F, 3, 3), with lines along the last axis.

    `crossed` begins at the voxel `first`.
    """
    for k in range(len(corners)):
        a, b, c = corners[k]
        twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if twice == 0.0:
            continue
        for p in range(low[k, 0], high[k, 0]):
            for r in range(low[k, 1], high[k, 1]):
                u = ((b[0] - p) * (c[1] - r) - (b[1] - r) * (c[0] - p)) / twice
                v = ((c[0] - p) * (a[1] - r) - (c[1] - r) * (a[0] - p)) / twice
                if u >= 0.0 and v >= 0.0 and u + v <= 1.0:
                    col = max(int(np.ceil(u * a[2] + v * b[2] + (1.0 - u - v) * c[2])) - first[2], 0)
                    if col < crossed.shape[2]:
                        crossed[p - first[0], r - first[1], col] ^= True
