"""Guides of outlines: a part of an image with the lines along which the boundary of an object may run."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property

import numpy as np

from cpm_core.numerics.grids import running_maximum
from cpm_core.numerics.types import Array, Mask, record
from cpm_core.objects.boundaries.crossings import Crossings, find_crossings

GUIDE_EDGE_PERCENTILE = 95.0
"""Percentile of the edge map above which an edge is strong."""


@record
class BoundaryGuides:
    """An image with the lines that the boundary of an object follows.

    Attributes
    ----------
    values, strength : ndarray, shape (H, W)
        Image, and its edge map.
    strong_edge_level : float
        Edge strength that counts as strong.
    contours, barriers, rims : Crossings
        Where contours, barriers, and the boundary of the regions of interest pass between pixels.
    interest : ndarray of bool, shape (H, W)
        Pixels in the regions of interest.
    """

    values: Array
    strength: Array
    strong_edge_level: float
    contours: Crossings
    barriers: Crossings
    rims: Crossings
    interest: Mask

    @cached_property
    def lines(self) -> Crossings:
        """Crossings of all these lines."""
        return self.contours.with_fallback(self.barriers).with_fallback(self.rims)

    @cached_property
    def near_lines(self) -> Mask:
        """Pixels within about 1.5 px of a line, shape (H, W)."""
        return running_maximum(self.lines.pixels, 1)


def build_boundary_guides(
    values: Array,
    strength: Array,
    contours: Iterable[Array] = (),
    barriers: Iterable[Array] = (),
    rims: Iterable[Array] = (),
    interest: Mask | None = None,
) -> BoundaryGuides:
    """Build what outlines in an image follow: contours, barriers and rims of regions, paths of shape (K, 2) [px].

    `values`, `strength` (the edge map) and `interest` have the shape (H, W).
    """
    shape = values.shape
    if interest is None or not interest.any():
        interest = np.ones(shape, bool)
    strong = max(float(np.percentile(strength[interest], GUIDE_EDGE_PERCENTILE)), 1e-300)
    lines = [find_crossings(paths, shape) for paths in (contours, barriers, rims)]
    return BoundaryGuides(values, strength, strong, lines[0], lines[1], lines[2], interest)
