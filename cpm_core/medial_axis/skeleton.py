"""Skeletons: the center lines of objects, with the distance to the boundary at every vertex (section 5.3).

Section 5.3 uses local minima of the field, or the particles that a second field of such charges attracts. This program
does not: the minima of the exact field (95 percent of them in 5 x 5 pixels) are isolated positions and the boundary of
the object; on an ellipse of half axes 70 and 30 px they come within 2 px of only 6 % of the medial axis. The divergence
of the unit field has a clear ridge, but it is not on the medial axis where the two sides differ in length, curvature or
strength: in a ring of radii 20 and 80 px it is off by 3 px, in the arms of an L by up to 13 px. A disk there touches
only one side, and no shape can be rebuilt from such disks.
"""

from __future__ import annotations

from dataclasses import field
from functools import cached_property
from typing import ClassVar

import numpy as np
import skimage

from cpm_core.contours.contour import Contour
from cpm_core.contours.graph import Graph
from cpm_core.image import drawing
from cpm_core.image.geometry import Geometry
from cpm_core.image.image import Image
from cpm_core.medial_axis.boundary import Boundary
from cpm_core.medial_axis.centerlines import Centerlines
from cpm_core.medial_axis.medial_axis import MedialAxis
from cpm_core.medial_axis.structure import correct_half_width
from cpm_core.numerics.polyline import lengths_along
from cpm_core.numerics.types import Array, Arrays, Extent, Mask, Sides, record
from cpm_core.parameters.formatting import format_count, format_repr
from cpm_core.parameters.provenance import Provenance

_THICKNESS_PERCENTILE = 95.0
"""Percentile of the length that `Skeleton.thickness` covers."""

_DISK_STRIDE = 0.25
"""Distance of the disks along an axis [px]: between two disks of radius 1.5 px the outline dips by 0.005 px."""

_RADIUS_TOLERANCE = 0.005
"""Tolerance of a disk's radius [px], so that rounding errors have no effect."""


@record
class Skeleton(drawing.Pictured):
    """Center lines of the objects in an image.

    Attributes
    ----------
    contours : tuple of Contour
        The branches, longest first, in px of the image. They end in tips or, where three or more meet, in junctions;
        a closed one encloses a hole. An object without a direction, such as a disk, has a branch of one vertex.
        Their `strength` is the mean edge strength of the boundary on both sides [gray levels / px].
    radii : tuple of ndarray of float64, shape (K,)
        For every branch the distance from each of its vertices to the boundary [px].
    shape : tuple of int
        Shape of the image.
    spacing : tuple of float
        Size of a pixel along each axis, in `unit`.
    unit : str or None
        Unit of `spacing`; None when the image gives none.
    source : str
        Name of the image for the user.
    polarity : int
        -1 for the skeleton of dark objects, 1 of light ones, 0 of both.
    width : float
        Largest width that counted [px]; 0 for any.
    channel : str
        Channel of a color image in which it was found, one of `Parameters.channel`.
    provenance : Provenance
        Origin of the skeleton.
    geometry : Geometry or None
        Where the image lies in space.
    image : Image or None
        The image in which it was found; None for one that was not found in an image.
    lines : Centerlines or None
        In a volume the center lines, as files hold them; lengths and radii here are in smallest sides of a voxel.

    Examples
    --------
    >>> bones = cpm.skeleton(cpm.example("ring"))
    >>> bones
    <Skeleton ring, 1 branch, 106.5 px>
    >>> round(bones.thickness), round(bones.length / (2 * np.pi * 17), 2), bool(bones.rebuild_shape()[32, 15])
    (14, 1.0, True)
    >>> axes = bones.plot(cpm.example("ring").plot())
    """

    surface: ClassVar[None] = None  # which results of volumes have

    contours: tuple[Contour, ...]
    radii: Arrays
    shape: Extent
    spacing: Sides
    unit: str | None
    source: str
    polarity: int = 0
    width: float = 0.0
    channel: str = "luminance"
    provenance: Provenance = field(default_factory=Provenance)
    geometry: Geometry | None = None
    image: Image | None = None
    lines: Centerlines | None = None

    @cached_property
    def thickness(self) -> float:
        """Thickness that 95 % of the length stays below [px]; of objects without a direction, the largest one."""
        radii = [radius for radius, contour in zip(self.radii, self.contours, strict=True) if contour.length > 0.0]
        if not radii:
            return 2.0 * max((float(radius.max()) for radius in self.radii), default=0.0)
        return 2.0 * float(np.percentile(np.concatenate(radii), _THICKNESS_PERCENTILE))

    @cached_property
    def length(self) -> float:
        """Length of all branches together [px]."""
        if self.lines is not None:
            return float(self.lines.lengths.sum()) / min(self.spacing)
        return sum(contour.length for contour in self.contours)

    def rebuild_shape(self) -> Mask:
        """Rebuild the shape that the skeleton represents: the disks around its vertices, and those between them.

        Returns
        -------
        ndarray of bool, shape `shape`
            True where the center of a pixel lies in one of the disks.
        """
        disks = [np.zeros((0, 3))]
        for contour, radii in zip(self.contours, self.radii, strict=True):
            disks.append(disks_along(contour.path, np.append(radii, radii[0]) if contour.closed else radii))
        return paint_disks(np.concatenate(disks), self.shape)

    def plot(self, ax: drawing.Axes | None = None, *, image: bool = False, scale_bar: bool = True) -> drawing.Axes:
        """Draw the branches by matplotlib, on the image or on whatever `ax` shows.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where, such as the axes of `Image.plot`; by default in a new figure.
        image, scale_bar : bool
            Further parts of the drawing, as in `Result.plot`, which also documents what is returned and raised.
        """
        ax = drawing.axes_for(ax)
        if image and self.image is not None:
            self.image.plot(ax, scale_bar=False)
        else:
            drawing.frame_axes(ax, self.shape, self.spacing)
        drawing.show_curves(ax, self.contours)
        if scale_bar:
            drawing.show_scale_bar(ax, self.shape, self.spacing, self.unit)
        return ax

    def __repr__(self) -> str:
        branches = format_count(len(self.contours), "branch", "branches")
        return format_repr("Skeleton", self.source, branches, f"{self.length:,.1f} px")


def extract_branches(axis: MedialAxis, boundary: Boundary, smoothing: float) -> list[tuple[Contour, Array]]:
    """Extract the branches of an axis, and their radii, shape (K,) [px]."""
    graph = Graph(axis.points, axis.edges)
    ways = graph.find_paths()
    paths = [(ways.path_vertices(n), bool(ways.closed[n])) for n in range(len(ways))]
    points = [(np.array([v]), False) for v in np.flatnonzero(graph.degrees == 0)]
    found = []
    for path, closed in [*paths, *points]:
        forks = (False, False) if closed else (graph.degree(path[0]) > 2, graph.degree(path[-1]) > 2)
        strength = float(boundary.strength[axis.nearest[path]].mean())
        contour = Contour(axis.points[path], closed, strength, junctions=forks)
        found.append((contour, correct_half_width(axis.radius[path], smoothing)))
    return found


def disks_along(points: Array, radii: Array) -> Array:
    """Interpolate disks (row, col, radius), shape (M, 3), along a path, shape (K, 2), with radii of shape (K,) [px]."""
    way = lengths_along(points)
    at = np.union1d(way, np.arange(0.0, way[-1], _DISK_STRIDE))
    return np.column_stack([np.interp(at, way, values) for values in (*points.T, radii)])


def paint_disks(disks: Array, shape: Extent) -> Mask:
    """Mark the pixels whose centers lie in one of the disks (row, col, radius), shape (M, 3) [px]."""
    found = np.zeros(shape, bool)
    for row, col, radius in disks.tolist():
        found[skimage.draw.disk((row, col), radius + _RADIUS_TOLERANCE, shape=shape)] = True  # type: ignore[no-untyped-call]
    return found
