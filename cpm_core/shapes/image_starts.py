"""Positions of the particles whose starts depend on the image, worked out for an image once and kept."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from cpm_core.field.edge_map import automatic_smoothing, edge_map
from cpm_core.image.image import Image
from cpm_core.image.regions import Regions
from cpm_core.numerics.types import Array
from cpm_core.shapes import Everywhere, Threshold

ImageStart = Everywhere | Threshold
"""Starts whose positions depend on the image."""

ImageSeeds = Mapping[ImageStart, Array]
"""Positions of the particles of such starts, shape (N, 2) each."""

NO_SEEDS: ImageSeeds = MappingProxyType({})


class SeedCache:
    """Positions on one image.

    Parameters
    ----------
    image : Image
        The image.
    """

    def __init__(self, image: Image) -> None:
        self._image = image
        self._automatic: float | None = None
        self._kept: dict[ImageStart, tuple[float, Array]] = {}
        self._strength: tuple[float, Array] | None = None

    def seeds_for(
        self, starts: Iterable[ImageStart], smoothing: float | str, regions: Regions | None = None
    ) -> ImageSeeds:
        """Positions for each of the starts, those in the regions of interest only.

        Parameters
        ----------
        starts : iterable
            Starts whose positions depend on the image.
        smoothing : float or "auto"
            Gaussian before the gradient [px], for starts that follow it.
        regions : Regions, optional
            What limits the particles.
        """
        sigma = self._smoothing(smoothing)
        found = {start: self._positions(start, sigma) for start in starts}
        # What is no longer drawn is not asked for again soon, but for the starts that have no place to be dragged from.
        self._kept = {
            start: kept for start, kept in self._kept.items() if start in found or isinstance(start, Everywhere)
        }
        return {start: _within(regions, positions) for start, positions in found.items()}

    def _positions(self, start: ImageStart, smoothing: float) -> Array:
        key = smoothing if start.follows_smoothing else 0.0
        if start not in self._kept or self._kept[start][0] != key:
            # What was found with another smoothing is not asked for again soon.
            self._kept[start] = (key, start.seeds_for(self._image.values, lambda: self._edges(smoothing)))
        return self._kept[start][1]

    def _edges(self, smoothing: float) -> Array:
        """Edge strength of the image, kept because an area is dragged about with the same smoothing."""
        if self._strength is None or self._strength[0] != smoothing:
            self._strength = (smoothing, edge_map(self._image.values, smoothing))
        return self._strength[1]

    def _smoothing(self, smoothing: float | str) -> float:
        if not isinstance(smoothing, str):
            return smoothing
        if self._automatic is None:
            self._automatic = automatic_smoothing(self._image.values)
        return self._automatic


def _within(regions: Regions | None, positions: Array) -> Array:
    return positions if regions is None else positions[regions.contains(positions)]
