"""The layer of the skeleton: branches colored by the local thickness of the object, and inscribed disks."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from cpm_app.model.text.language import tr
from cpm_app.session.scene import Scene
from cpm_app.views.items.curves import Curves
from cpm_app.views.layers.layer import Layer
from cpm_app.views.theme import theme
from cpm_core import Skeleton
from cpm_core.numerics import Array
from cpm_core.numerics.types import Sides

_THICK_PERCENTILE = 95.0
"""Percentile of the radii shown as thickest, so that a single wide place does not make all others look thin."""

_DISK_SPACING = 1.0
"""Distance between two disks along a branch [radii]."""

_DISK_CORNERS = 48
"""Number of corners of the polygon of a disk."""


class SkeletonLayer(Layer):
    """Shows branches and radii."""

    name = "skeleton"
    title = tr("Skeleton")
    tip = tr("Center lines, colored from thin to thick, and inscribed disks.")
    colors = (theme.THICKNESS_COLORS[0], theme.THICKNESS_COLORS[-1])

    def create_items(self) -> None:
        """Create the items of the layer."""
        self.branches = Curves(theme.THICKNESS_COLORS[0], 4.6, width=2.6, halo=4.4)
        self.disks = Curves(theme.DISK_COLOR, 4.5, width=1.0, halo=0.0)
        self.add_items(self.disks, self.branches)

    def show_scene(self, before: Scene) -> None:
        """Show another skeleton, or none."""
        found = self.scene.skeleton
        if found is before.skeleton:
            return
        pieces: list[tuple[int, Array]] = []
        circles: list[Array] = []
        if found is not None and found.contours:
            pieces += split_skeleton_by_thickness(found, len(theme.THICKNESS_COLORS))
            for contour, radii in zip(found.contours, found.radii, strict=True):
                along = np.append(radii, radii[0]) if contour.closed else radii
                circles += inscribed_disks(contour.path, along, _pixel_sides(self.scene))
        self.branches.show_paths([piece for _, piece in pieces], [theme.THICKNESS_COLORS[band] for band, _ in pieces])
        self.disks.show_paths(circles)


def split_skeleton_by_thickness(found: Skeleton, bands: int) -> Iterator[tuple[int, Array]]:
    """Split the branches of a skeleton into bands of thickness.

    Yields
    ------
    band : int
        Index of the band, from thin to thick, below `bands`.
    piece : ndarray, shape (K, 2) or (K, 3)
        Piece of a branch, in pixels of the skeleton.
    """
    thickest = max(float(np.percentile(np.concatenate(found.radii), _THICK_PERCENTILE)), 1e-9)
    for contour, radii in zip(found.contours, found.radii, strict=True):
        along = np.append(radii, radii[0]) if contour.closed else radii
        yield from split_path_by_thickness(contour.path, along / thickest, bands)


def split_path_by_thickness(path: Array, share: Array, bands: int) -> list[tuple[int, Array]]:
    """Split a path into bands of thickness; return pieces, each with the index of its band.

    Parameters
    ----------
    path : ndarray, shape (K, 2) or (K, 3)
        Branch.
    share : ndarray, shape (K,)
        Thickness at its vertices as a fraction of the largest, from 0 to 1.
    bands : int
        Number of bands.
    """
    band = np.minimum((share * bands).astype(int), bands - 1)
    cuts = [0, *(np.flatnonzero(np.diff(band)) + 1).tolist(), len(path)]
    return [(int(band[a]), path[a : min(b + 1, len(path))]) for a, b in pairwise(cuts)]


def _pixel_sides(scene: Scene) -> tuple[float, ...]:
    """Return the sides of a pixel in the unit of the radii, which in a volume is the smallest side of a voxel."""
    if scene.volume is None or scene.image is None:
        return 1.0, 1.0
    return tuple(side / min(scene.volume.spacing) for side in scene.image.spacing)


def inscribed_disks(path: Array, radii: Array, sides: Sides) -> list[Array]:
    """Return the outlines of inscribed disks along a branch, at least a radius apart.

    Parameters
    ----------
    path : ndarray, shape (K, 2)
        Branch (row, col) [px].
    radii : ndarray, shape (K,)
        Radii at its vertices.
    sides : tuple of float
        Sides of a pixel in the unit of the radii.

    Returns
    -------
    list of ndarray, shape (48, 2)
        Polygons (row, col) [px].
    """
    angle = np.linspace(0.0, 2.0 * np.pi, _DISK_CORNERS)
    around = np.stack([np.sin(angle), np.cos(angle)], axis=1) / np.array(sides)
    found, room = [], 0.0
    for index, (place, radius) in enumerate(zip(path, radii, strict=True)):
        room -= float(np.hypot(*(place - path[index - 1]))) if index else 0.0
        if room <= 0.0 and radius >= 1.0:
            found.append(place + radius * around)
            room = _DISK_SPACING * float(radius)
    return found
