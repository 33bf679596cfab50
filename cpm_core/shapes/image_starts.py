"""Seeds of starts that depend on the image, with a cache."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache

from cpm_core.field.edge_map import automatic_smoothing, edge_map
from cpm_core.image.gray_levels import limit_specks
from cpm_core.image.image import Image
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.model.volume.starts import volume_edge_strength
from cpm_core.numerics.types import Array
from cpm_core.shapes.areas import Threshold
from cpm_core.shapes.everywhere import Everywhere
from cpm_core.shapes.solids import BoxThreshold

ImageStart = Everywhere | Threshold | BoxThreshold
"""Starts whose positions depend on the image."""

ImageSeeds = Mapping[ImageStart, Array]
"""Positions of the particles of each such start, shape (N, 2), or (N, 3) in a volume."""

NO_SEEDS: ImageSeeds = {}


_CACHED_STARTS = 16
"""Number of starts whose seeds are cached: those of a document, some of them switched off and on."""


class SeedCache:
    """Seeds on one image, computed once for each start and smoothing."""

    def __init__(self, image: Image) -> None:
        volume, gray = image.ndim == 3, lru_cache(1)(image.gray_levels)

        @lru_cache(1)
        def automatic_sigma(channel: str) -> float:
            return 1.0 if volume else automatic_smoothing(gray(channel))

        @lru_cache(1)  # dragging an area does not change the smoothing
        def edge_strength(sigma: float, channel: str) -> Array:
            return volume_edge_strength(image, sigma) if volume else edge_map(limit_specks(gray(channel)), sigma)

        @lru_cache(_CACHED_STARTS)
        def find_seeds(start: ImageStart, sigma: float, channel: str) -> Array:
            return start.seeds_on(image, channel, lambda: edge_strength(sigma, channel))

        self._automatic_sigma, self._find_seeds = automatic_sigma, find_seeds

    def seeds_for(
        self,
        starts: Iterable[ImageStart],
        smoothing: float | str,
        regions: AnyRegions | None = None,
        channel: str = "luminance",
    ) -> ImageSeeds:
        """Find the positions of the particles of each start, only those in the regions of interest.

        `smoothing` is the sigma of the Gaussian before the gradient [px], or "auto", for starts that depend on it;
        `channel` says what gives the gray levels of a color image.
        """
        sigma = self._automatic_sigma(channel) if isinstance(smoothing, str) else smoothing
        found = {start: self._find_seeds(start, sigma if start.follows_smoothing else 0.0, channel) for start in starts}
        return {s: p if regions is None else p[regions.contains(p)] for s, p in found.items()}
