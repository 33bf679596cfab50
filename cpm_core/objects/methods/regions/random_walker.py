"""The random walker by scikit-image: each pixel goes to the seeds that a random walk from it reaches first."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import skimage
from numpy.typing import NDArray

from cpm_core.image.image import Image
from cpm_core.objects.methods.gray import unit_gray
from cpm_core.objects.methods.method import ContourMethod, Start
from cpm_core.objects.methods.regions.certain import certain_pixels
from cpm_core.objects.methods.settings import Settings, number
from cpm_core.objects.methods.states import LevelSetState

OBJECT, BACKGROUND = 1, 2
_DIRECT = 300_000
"""Pixels up to which the equations are solved directly, which is faster; beyond, with less memory, by iteration."""


@dataclass(frozen=True)
class RandomWalkerSettings(Settings):
    """Parameters of the random walker."""

    beta: float = number(
        2000.0, "β", "Edges", "How hard it is for a walk to cross a difference of gray levels.",
        "More of it follows weaker edges, and noise.", (0.0, 1e6), (10.0, 5000.0), 10.0,
    )  # fmt: skip
    depth: float = number(
        0.8, "d", "Depth of the seeds",
        "From a start around the object: the depth from which pixels are its seeds, as a fraction of the greatest.",
        "More of it leaves seeds only in the middle.", (0.0, 0.99), (0.0, 0.95), 0.05,
    )  # fmt: skip
    margin: float = number(
        0.0, "b", "Background",
        "Distance from a start inside the object from which pixels are seeds of the background; at 0 at the border.",
        "More of it leaves more room around the start.", (0.0, 1e5), (0.0, 200.0), 1.0, "px",
    )  # fmt: skip


_NO_WARNING = 1.0
"""Error of probabilities up to which scikit-image does not warn; only which of two is larger counts."""


def seeds(start: Start, shape: tuple[int, ...], settings: RandomWalkerSettings) -> NDArray[np.int32]:
    """Labels of the seeds, shape (H, W): `OBJECT`, `BACKGROUND`, or 0 where there is none.

    A start in the object is all object, and the border of the image, or what lies far from the start, background. A
    start around the object has only its middle in the object, and what lies outside it is background.
    """
    inner, outer = certain_pixels(start, shape, settings.depth, settings.margin)
    return np.where(inner, OBJECT, np.where(outer, BACKGROUND, 0)).astype(np.int32)


def _evolve(image: Image, start: Start, settings: RandomWalkerSettings) -> Iterator[LevelSetState]:
    inside = start.mask(image.shape)
    yield LevelSetState(values=inside, level=0.5)
    labels = seeds(start, image.shape, settings)
    if {OBJECT, BACKGROUND} - set(np.unique(labels).tolist()):
        missing = "object" if not (labels == OBJECT).any() else "background"
        yield LevelSetState(1, f"there are no seeds of the {missing}", values=inside, level=0.5)
        return
    mode = "bf" if labels.ndim == 2 and labels.size <= _DIRECT else "cg_j"
    found = skimage.segmentation.random_walker(unit_gray(image), labels, settings.beta, mode, prob_tol=_NO_WARNING)
    yield LevelSetState(1, "all pixels have been decided", True, found == OBJECT, 0.5)


RANDOM_WALKER = ContourMethod(
    "random_walker",
    "Random walker",
    "Each pixel goes to the seeds, inside the start or at the border, that a random walk from it reaches first.",
    "Grady (2006), doi:10.1109/TPAMI.2006.233; scikit-image's random_walker",
    RandomWalkerSettings,
    _evolve,
    1,
    in_volumes=True,
)
