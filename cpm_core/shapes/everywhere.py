"""Particles all over the image, without anything drawn."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal, get_args

from cpm_core.image.image import Image
from cpm_core.model.starts import STRONG_EDGE_FRACTION, divergence_centers, pixels_above, uniform_grid
from cpm_core.model.volume import starts as volume_starts
from cpm_core.numerics.types import Array, Position, frozen
from cpm_core.shapes.path import WithoutOutline

SeedingKind = Literal["grid", "gradient", "centers"]
"""Automatic seeding: evenly, on strong edges, or where the electric field diverges."""

SEEDING_KINDS: tuple[SeedingKind, ...] = get_args(SeedingKind)

_SEEDING_TITLES = {
    "grid": "start everywhere",
    "gradient": "start on strong edges",
    "centers": "start at centers",
}
"""Kind of seeding -> name for the user."""


@frozen
class Everywhere(WithoutOutline):
    """Particles all over the image, at positions that depend on it (`cpm_core.shapes.image_starts`).

    Attributes
    ----------
    kind : {"grid", "gradient", "centers"}
        Evenly, on strong edges, or at the centers of divergence of the electric field.
    """

    kind: SeedingKind

    @property
    def title(self) -> str:
        """Name for the user."""
        return _SEEDING_TITLES[self.kind]

    @property
    def follows_smoothing(self) -> bool:
        """Whether the positions depend on the smoothing."""
        return self.kind == "gradient"

    def seeds_on(self, image: Image, channel: str, find_strength: Callable[[], Array]) -> Array:
        """Return the positions of the particles on an image, shape (N, 2), or in a volume, shape (N, 3).

        Parameters
        ----------
        image : Image
            The image or volume.
        channel : str
            Channel of a color image whose gray levels count.
        find_strength : callable
            Finds the edge strength of the image, in its shape.
        """
        if self.kind == "gradient":
            return pixels_above(find_strength(), STRONG_EDGE_FRACTION)
        if image.ndim == 3:
            return (volume_starts.seeds_everywhere if self.kind == "grid" else volume_starts.seeds_at_centers)(image)
        return uniform_grid(image.shape) if self.kind == "grid" else divergence_centers(image.gray_levels(channel))

    def translated(self, offset: Position) -> Everywhere:
        """Return the shape itself: it has no position."""
        return self

    def distance_to(self, position: Position) -> float:
        """Return infinity, so that it is never selected in place of a drawn shape."""
        return math.inf
