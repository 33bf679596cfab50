"""Where particles start that nobody has drawn, worked out for an image once and kept."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from app.model.document import FOLLOWING_SMOOTHING, Document, Sown
from app.model.shapes import Kind
from cpm_core.edge_map import automatic_smoothing
from cpm_core.image import Image
from cpm_core.initialization import divergence_centers, gradient_threshold, uniform_grid
from cpm_core.regions import Regions

Array = NDArray[np.float64]

_WAYS: Mapping[Kind, Callable[[Array, float], Array]] = MappingProxyType(
    {
        "grid": lambda values, smoothing: uniform_grid(values.shape),
        "edges": lambda values, smoothing: gradient_threshold(values, smoothing=smoothing),
        "centers": lambda values, smoothing: divergence_centers(values),
    }
)


class Sower:
    """Positions on one image.

    Parameters
    ----------
    image : Image
        The image.
    """

    def __init__(self, image: Image) -> None:
        self._image = image
        self._automatic: float | None = None
        self._kept: dict[tuple[Kind, float], Array] = {}

    def sow(self, document: Document) -> Sown:
        """Positions for each of the document's ways to start everywhere, those in its regions of interest only."""
        smoothing = self._smoothing(document.parameters.smoothing)
        regions = document.regions
        return {kind: _within(regions, self._positions(kind, smoothing)) for kind in document.everywhere}

    def _positions(self, kind: Kind, smoothing: float) -> Array:
        key = (kind, smoothing if kind in FOLLOWING_SMOOTHING else 0.0)
        if key not in self._kept:
            # What was found with another smoothing is not asked for again soon.
            self._kept = {kept: found for kept, found in self._kept.items() if kept[0] != kind}
            self._kept[key] = _WAYS[kind](self._image.values, smoothing)
        return self._kept[key]

    def _smoothing(self, smoothing: float | str) -> float:
        if not isinstance(smoothing, str):
            return smoothing
        if self._automatic is None:
            self._automatic = automatic_smoothing(self._image.values)
        return self._automatic


def _within(regions: Regions | None, positions: Array) -> Array:
    return positions if regions is None else positions[regions.contains(positions)]
