"""Seeds of starts that depend on the image, with a cache."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from cpm_core.field.edge_map import automatic_smoothing, edge_map
from cpm_core.image.image import Image
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.model.volume.starts import strength_of
from cpm_core.numerics.types import Array
from cpm_core.shapes.areas import Threshold
from cpm_core.shapes.everywhere import Everywhere
from cpm_core.shapes.solids import BoxThreshold

ImageStart = Everywhere | Threshold | BoxThreshold
"""Starts whose positions depend on the image."""

ImageSeeds = Mapping[ImageStart, Array]
"""Positions of the particles of each such start, shape (N, 2), or (N, 3) in a volume."""

NO_SEEDS: ImageSeeds = MappingProxyType({})


class SeedCache:
    """Seeds on one image, computed once for each start and smoothing."""

    def __init__(self, image: Image) -> None:
        self._image = image
        self._channel, self._values = "luminance", image.values
        self._automatic: float | None = None
        self._kept: dict[ImageStart, tuple[float, Array]] = {}
        self._strength: tuple[float, Array] | None = None

    def seeds_for(
        self,
        starts: Iterable[ImageStart],
        smoothing: float | str,
        regions: AnyRegions | None = None,
        channel: str = "luminance",
    ) -> ImageSeeds:
        """Positions for each of the starts, only those in the regions of interest.

        `smoothing` is the sigma of the Gaussian before the gradient [px], or "auto", for starts that depend on it;
        `channel` says what gives the gray levels of a color image.
        """
        if channel != self._channel:
            self._channel, self._values = channel, self._image.gray(channel)
            self._automatic, self._strength, self._kept = None, None, {}
        sigma, found = self._smoothing(smoothing), {}
        for start in starts:
            key = sigma if start.follows_smoothing else 0.0
            if start not in self._kept or self._kept[start][0] != key:
                self._kept[start] = key, self._found(start, sigma)
            found[start] = self._kept[start][1]
        # Starts all over the image are switched on and off; others that are gone are not needed again soon.
        self._kept = {
            start: kept for start, kept in self._kept.items() if start in found or isinstance(start, Everywhere)
        }
        return {s: p if regions is None else p[regions.contains(p)] for s, p in found.items()}

    def _found(self, start: ImageStart, smoothing: float) -> Array:
        if isinstance(start, Everywhere) and self._image.ndim == 3:
            return start.seeds_in(self._image, smoothing)
        if isinstance(start, BoxThreshold) is not (self._image.ndim == 3):
            kind, found = ("images", "a volume") if self._image.ndim == 3 else ("volumes", "an image")
            raise ValueError(
                f"this {start.title} is for {kind}, but {self._image.source} is {found}: draw another one."
            )
        if isinstance(start, BoxThreshold):
            return start.seeds_within(lambda: self._edges(smoothing))
        return start.seeds_for(self._values, lambda: self._edges(smoothing))

    def _edges(self, smoothing: float) -> Array:
        """Edge strength of the image, cached because dragging an area does not change the smoothing."""
        if self._strength is None or self._strength[0] != smoothing:
            volume = self._image.ndim == 3
            found = strength_of(self._image, smoothing) if volume else edge_map(self._values, smoothing)
            self._strength = (smoothing, found)
        return self._strength[1]

    def _smoothing(self, smoothing: float | str) -> float:
        if not isinstance(smoothing, str):
            return smoothing
        if self._image.ndim == 3:
            return 1.0
        if self._automatic is None:
            self._automatic = automatic_smoothing(self._values)
        return self._automatic
