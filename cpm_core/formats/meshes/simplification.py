"""Surfaces with smoother steps or fewer triangles, and how far this moves them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import scipy

from cpm_core.contours.surface_agreement import TriangleSamples
from cpm_core.image.surface import Surface
from cpm_core.numerics.packages import require_package
from cpm_core.numerics.types import Array, Index, Mask, frozen
from cpm_core.parameters.formatting import quote_value

MAX_SMOOTHING = 100
"""Largest number of rounds of smoothing."""

_SHRINKING = 0.5
"""Share of the way to the middle of its neighbors that a vertex goes."""

_GROWTH = -0.53
"""Share of that way that it then goes back."""


@frozen
class Simplification:
    """How a surface is made simpler.

    Attributes
    ----------
    smoothing : int
        Rounds of smoothing; 0 for none.
    triangles : float
        Share of the triangles that is kept, above 0; 1 for all.

    Raises
    ------
    ValueError
        When a value is out of range.
    """

    smoothing: int = 0
    triangles: float = 1.0

    def __post_init__(self) -> None:
        if not 0 <= self.smoothing <= MAX_SMOOTHING:
            raise ValueError(f"The smoothing is {quote_value(self.smoothing)} but must be from 0 to {MAX_SMOOTHING}.")
        if not 0.0 < self.triangles <= 1.0:
            raise ValueError(
                f"The share of triangles is {quote_value(self.triangles)} but must be above 0, and 1 at most."
            )

    def __bool__(self) -> bool:
        return self.smoothing > 0 or self.triangles < 1.0


AS_FOUND = Simplification()
"""The surface stays as it is."""


@frozen
class SurfaceChange:
    """How far a simpler surface lies from the one that it was made of: `largest` and `mean` distance, in its unit."""

    largest: float
    mean: float


def simplify_surface(surface: Surface, wanted: Simplification) -> Surface:
    """Smooth a surface, and leave out triangles, each object for itself.

    Smoothing is that of G. Taubin (1995), which keeps the volume. Triangles are left out where quadrics of the error
    are least (M. Garland and P. S. Heckbert, 1997), by the package ``fast-simplification``.

    Raises
    ------
    ValueError
        When triangles are to be left out, but the package is missing.
    """
    if wanted.smoothing:
        surface = _smooth(surface, wanted.smoothing)
    if wanted.triangles == 1.0 or not len(surface.faces):
        return surface
    numbers = np.ones(len(surface.faces), np.int64) if surface.numbers is None else surface.numbers
    parts = [_thin(surface, numbers == number, wanted.triangles) for number in np.unique(numbers)]
    counts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = [part.faces + first for part, first in zip(parts, counts, strict=False)]
    kept = np.repeat(np.unique(numbers), [len(part.faces) for part in parts])
    return replace(
        surface,
        vertices=np.concatenate([part.vertices for part in parts]),
        faces=np.concatenate(faces),
        numbers=None if surface.numbers is None else kept,
    )


def measure_change(before: Surface, after: Surface) -> SurfaceChange:
    """Measure how far a surface lies from another: from the vertices of each to the nearest triangle of the other."""
    size = np.array(before.spacing)
    one, other = (each.vertices[np.unique(each.faces)] * size for each in (before, after))
    triangles = [TriangleSamples((each.vertices * size)[each.faces]) for each in (before, after)]
    away = np.concatenate([triangles[1].distances_to(one), triangles[0].distances_to(other)])
    return SurfaceChange(float(away.max(initial=0.0)), float(away.mean()) if len(away) else 0.0)


def _smooth(surface: Surface, rounds: int) -> Surface:
    """Move vertices towards their neighbors and back, but those on a rim."""
    count = len(surface.vertices)
    begin, end = surface.faces[:, [0, 1, 2]].ravel(), surface.faces[:, [1, 2, 0]].ravel()
    pairs = np.concatenate([begin, end]), np.concatenate([end, begin])
    links: Any = scipy.sparse.coo_array((np.ones(2 * len(begin)), pairs), (count, count)).tocsr()
    degree: Array = links.sum(axis=1)
    free = degree > 0.0
    free[np.repeat(np.arange(count), np.diff(links.indptr))[links.data == 1.0]] = False  # the sides of one triangle
    vertices = surface.vertices.copy()
    for share in (_SHRINKING, _GROWTH) * rounds:
        vertices[free] += share * ((links @ vertices)[free] / degree[free, None] - vertices[free])
    return replace(surface, vertices=vertices)


def _thin(surface: Surface, chosen: Mask, share: float) -> Surface:
    """Leave out triangles of one object; all are kept where none of them can be left out without a gap."""
    require_package("fast_simplification", "A surface of fewer triangles")
    import fast_simplification  # noqa: PLC0415 - optional

    used, numbers = np.unique(surface.faces[chosen], return_inverse=True)
    faces: Index = numbers.reshape(-1, 3)
    vertices = surface.vertices[used] * surface.spacing
    few, left = fast_simplification.simplify(
        vertices, faces.astype(np.int32), target_count=max(4, round(share * len(faces)))
    )
    before = Surface(surface.vertices[used], faces)
    after = Surface(np.asarray(few, float) / surface.spacing, np.asarray(left, np.int64))
    return after if after.closed or not before.closed else before
