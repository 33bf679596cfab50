"""The result of a run: particles, contours, and how it ended."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from cpm_core.contours.contour import Bridge, Contour
from cpm_core.contours.surface import Surface
from cpm_core.image.geometry import Geometry
from cpm_core.image.image import Image
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array
from cpm_core.parameters.provenance import Provenance


@dataclass(frozen=True, eq=False)
class Result:
    """Outcome of a run.

    Attributes
    ----------
    particles : ndarray of float64, shape (N, D)
        Final positions in px of the image.
    contours : tuple of Contour
        The reconstructed contours, longest first.
    surface : Surface or None
        The reconstructed surface of objects in a volume; None for images.
    steps : int
        Number of steps over all scales.
    converged : bool
        Whether the particles came to rest.
    stop_reason : str
        Why the run ended, in words.
    shape : tuple of int
        Shape of the image.
    spacing : tuple of float
        Size of a pixel along each axis, in `unit`.
    unit : str or None
        Unit of `spacing`; None when the image gives none.
    source : str
        Name of the image for the user.
    bridges : tuple of Bridge
        Gaps that were bridged in the contours.
    image : Image or None
        The image in which the contours were found; None for contours that were not found in one.
    regions : Regions or VolumeRegions or None
        Regions of interest and barriers of the run.
    channel : str
        Channel of a color image in which the contours were found, one of `Parameters.channel`.
    provenance : Provenance
        How they were found.
    """

    particles: NDArray[np.float64]
    contours: tuple[Contour, ...]
    surface: Surface | None
    steps: int
    converged: bool
    stop_reason: str
    shape: tuple[int, ...]
    spacing: tuple[float, ...]
    unit: str | None
    source: str
    bridges: tuple[Bridge, ...] = ()
    image: Image | None = field(default=None, repr=False)
    regions: AnyRegions | None = None
    channel: str = "luminance"
    provenance: Provenance = field(default_factory=Provenance, repr=False)

    @property
    def geometry(self) -> Geometry | None:
        """Where its image lies in space; None where that is not known."""
        return None if self.image is None else self.image.geometry


def remaining(result: Result, stays: Sequence[bool]) -> Result:
    """The result with some of its contours, and the bridges on them; `stays` tells which, one value each."""
    if all(stays):
        return result
    kept = tuple(contour for contour, stay in zip(result.contours, stays, strict=True) if stay)
    dropped = [contour for contour, stay in zip(result.contours, stays, strict=True) if not stay]
    lost = _on(dropped, [bridge.points for bridge in result.bridges])
    found = _on(kept, [bridge.points for bridge in result.bridges])
    bridges = tuple(b for b, off, on in zip(result.bridges, lost, found, strict=True) if on <= off)
    return replace(result, contours=kept, bridges=bridges)


def _on(contours: Sequence[Contour], paths: Sequence[Array]) -> list[float]:
    """Distance of the middle of each path from the nearest of some contours [px]."""
    places = [path[len(path) // 2] for path in paths]
    return [min((float(polyline.distances(c.path, p[None])[0]) for c in contours), default=math.inf) for p in places]
