"""What is drawn on an image, as a run takes it: starts, regions of interest and barriers, placed charges."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.image.image import Image
from cpm_core.image.regions import Regions
from cpm_core.shapes import Barrier, Charge, Region, Shape, Start
from cpm_core.shapes.image_starts import ImageStart, SeedCache


def starts_of(shapes: Iterable[Shape]) -> tuple[Start, ...]:
    """The shapes that give particles."""
    return tuple(shape for shape in shapes if isinstance(shape, Start))


def regions_of(shapes: Iterable[Shape]) -> Regions | None:
    """What holds particles back; None when nothing of the kind is drawn."""
    drawn = tuple(shapes)
    interest = tuple(shape.points for shape in drawn if isinstance(shape, Region))
    barriers = tuple(shape.points for shape in drawn if isinstance(shape, Barrier))
    return Regions(interest=interest, barriers=barriers) if interest or barriers else None


def charges_of(shapes: Iterable[Shape]) -> tuple[PlacedCharge, ...]:
    """The charges placed."""
    return tuple(shape.placed for shape in shapes if isinstance(shape, Charge))


def seeds_of(shapes: Iterable[Shape], image: Image, smoothing: float | str) -> NDArray[np.float64]:
    """Positions of the particles that a drawing gives on an image, shape (N, 2); none where nothing gives any.

    Parameters
    ----------
    shapes : iterable of Shape
        What is drawn.
    image : Image
        What it is drawn on; some starts depend on it.
    smoothing : float or "auto"
        Gaussian before the gradient [px], for starts that follow it.
    """
    drawn = tuple(shapes)
    starts = starts_of(drawn)
    sowable = [start for start in starts if isinstance(start, ImageStart)]
    image_seeds = SeedCache(image).seeds_for(sowable, smoothing, regions_of(drawn)) if sowable else {}
    found = [image_seeds[start] if isinstance(start, ImageStart) else start.seeds() for start in starts]
    return np.concatenate([np.empty((0, 2)), *found])
