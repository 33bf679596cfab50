"""The result of a run: particles, contours, and how it ended."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cpm_core.contours.contour import Bridge, Contour
from cpm_core.image.image import Image
from cpm_core.image.regions import Regions


@dataclass(frozen=True, eq=False)
class Result:
    """Outcome of a run.

    Attributes
    ----------
    particles : ndarray of float64, shape (N, D)
        Final positions in px of the image.
    contours : tuple of Contour
        The reconstructed contours, longest first.
    surface : None
        Reserved for volumes; always None for images.
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
    regions : Regions or None
        Regions of interest and barriers of the run.
    """

    particles: NDArray[np.float64]
    contours: tuple[Contour, ...]
    surface: None
    steps: int
    converged: bool
    stop_reason: str
    shape: tuple[int, ...]
    spacing: tuple[float, ...]
    unit: str | None
    source: str
    bridges: tuple[Bridge, ...] = ()
    image: Image | None = field(default=None, repr=False)
    regions: Regions | None = None
