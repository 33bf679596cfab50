"""The document: what the user means. Small, frozen, undoable."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from app.model.text.language import tr
from cpm_core.contours.review import Mark
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.image.regions import Regions
from cpm_core.parameters import PARAMETERS, Parameters
from cpm_core.shapes import Points, Region, Shape, Start
from cpm_core.shapes.document_shapes import charges_of, regions_of, seeds_of, starts_of
from cpm_core.shapes.image_starts import NO_SEEDS, ImageSeeds, ImageStart

Mode = Literal["shape", "automatic", "skeleton"]
"""What a person is after; see `app.model.document.modes`."""

NOTHING_TO_START_FROM = tr(
    "There is nothing to start from: draw a circle, a stroke or points on the image first, or start everywhere."
)


@dataclass(frozen=True, slots=True)
class ImageReference:
    """Which image is meant, without its gray values.

    Attributes
    ----------
    name : str
        Name for people.
    path : str
        File that it was read from.
    shape : tuple of int
        (rows, cols).
    contrast : float
        Largest minus smallest gray value.
    sha256 : str
        Hash of the file, empty where it is not known.
    """

    name: str
    path: str
    shape: tuple[int, ...]
    contrast: float
    sha256: str = ""


@dataclass(frozen=True, slots=True)
class Document:
    """An image, the shapes drawn on it and the parameters of the run.

    Attributes
    ----------
    image : ImageReference or None
        None until the first image is open.
    shapes : tuple of Shape
        The initialization, the regions of interest and barriers that limit it, and placed charges, in the order drawn.
    parameters : Parameters
        Parameters of the model.
    marks : tuple of Mark
        What has been said about contours.
    mode : {"shape", "automatic", "skeleton"}
        What the person is after.
    """

    image: ImageReference | None = None
    shapes: tuple[Shape, ...] = ()
    parameters: Parameters = field(default_factory=Parameters)
    marks: tuple[Mark, ...] = ()
    mode: Mode = "shape"

    @property
    def starts(self) -> tuple[Start, ...]:
        """The shapes that give particles; without one there is nothing to run."""
        return starts_of(self.shapes)

    @property
    def sowable(self) -> tuple[ImageStart, ...]:
        """The starts whose positions depend on the image."""
        return tuple(shape for shape in self.shapes if isinstance(shape, ImageStart))

    @property
    def sowing(self) -> tuple[object, ...]:
        """Everything that the positions for `sowable` depend on; empty when there is none."""
        if not self.sowable:
            return ()
        limits = tuple(shape for shape in self.shapes if isinstance(shape, Region))
        followed = any(start.follows_smoothing for start in self.sowable)
        return (self.image, self.sowable, limits, self.parameters.smoothing if followed else None)

    @property
    def regions(self) -> Regions | None:
        """What holds particles back; None when nothing of the kind is drawn."""
        return regions_of(self.shapes)

    def seeds(self, image_seeds: ImageSeeds = NO_SEEDS) -> NDArray[np.float64]:
        """Positions of the particles that the drawing gives, shape (N, 2), in px of the image.

        Parameters
        ----------
        image_seeds : mapping of start to ndarray
            For each of `sowable` its positions on the image, which the document does not hold.

        Raises
        ------
        ValueError
            When nothing is drawn to start from.
        """
        if not self.starts:
            raise ValueError(NOTHING_TO_START_FROM)
        return seeds_of(self.shapes, image_seeds)

    @property
    def charges(self) -> tuple[PlacedCharge, ...]:
        """The charges placed, as the engine takes them."""
        return charges_of(self.shapes)

    @property
    def sources(self) -> Counter[Hashable]:
        """What gives particles, and how often: each point by itself, every other start as a whole."""
        found: Counter[Hashable] = Counter()
        for start in self.starts:
            found.update(start.positions if isinstance(start, Points) else (start,))
        return found

    @property
    def late(self) -> tuple[object, ...]:
        """Image and parameters that act only when a run starts."""
        acting = (getattr(self.parameters, name) for name, info in PARAMETERS.items() if info.invalidates == "run")
        return (self.image, *acting)
