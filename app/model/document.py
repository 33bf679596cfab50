"""The document: what the user means. Small, frozen, undoable."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from app.model.shapes import Shape
from cpm_core.parameters import PARAMETERS, Parameters


@dataclass(frozen=True, slots=True)
class ImageReference:
    """Which image is meant, without its grey values.

    Attributes
    ----------
    name : str
        Name for people.
    path : str
        File that it was read from.
    shape : tuple of int
        (rows, cols).
    contrast : float
        Largest minus smallest grey value.
    """

    name: str
    path: str
    shape: tuple[int, ...]
    contrast: float


@dataclass(frozen=True, slots=True)
class Document:
    """An image, the shapes drawn on it and the parameters of the run.

    Attributes
    ----------
    image : ImageReference or None
        None until the first image is open.
    shapes : tuple of Shape
        The initialization, in the order drawn.
    parameters : Parameters
        Parameters of the model.
    """

    image: ImageReference | None = None
    shapes: tuple[Shape, ...] = ()
    parameters: Parameters = field(default_factory=Parameters)

    def seeds(self) -> NDArray[np.float64]:
        """Positions of the particles that the drawing gives, shape (N, 2), in px of the image.

        Raises
        ------
        ValueError
            When nothing is drawn.
        """
        if not self.shapes:
            raise ValueError("There is nothing to start from: draw a circle or place points on the image first.")
        return np.concatenate([shape.seeds() for shape in self.shapes])

    @property
    def recipe(self) -> tuple[object, ...]:
        """Everything that acts only when a run starts; a run with another recipe is out of date."""
        late = tuple(getattr(self.parameters, name) for name, info in PARAMETERS.items() if info.invalidates == "run")
        return (self.image, self.shapes, late)
