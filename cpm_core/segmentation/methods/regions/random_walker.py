"""The random walker by scikit-image: each pixel goes to the seeds that a random walk from it reaches first."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy
import skimage
from numpy.typing import NDArray

from cpm_core.image.image import Image
from cpm_core.numerics.types import Mask
from cpm_core.segmentation.methods.gray import unit_gray
from cpm_core.segmentation.methods.method import ContourMethod, Start
from cpm_core.segmentation.methods.settings import Settings, number
from cpm_core.segmentation.methods.states import LevelSetState

OBJECT, BACKGROUND = 1, 2
_DIRECT = 40_000
"""Pixels up to which the equations are solved directly; beyond, by conjugate gradients."""


@dataclass(frozen=True)
class RandomWalkerSettings(Settings):
    """Parameters of the random walker."""

    beta: float = number(
        130.0, "β", "Edges", "How hard it is for a walk to cross a difference of gray levels.",
        "More of it follows weaker edges, and noise.", (0.0, 1e6), (10.0, 5000.0), 10.0,
    )  # fmt: skip
    depth: float = number(
        0.0, "d", "Depth of the seeds", "Depth in the start from which its pixels are seeds of the object, as a "
        "fraction of the greatest; at 0 all of them are.",
        "More of it is for a start around the object, whose seeds lie only in its middle.",
        (0.0, 0.99), (0.0, 0.95), 0.05,
    )  # fmt: skip
    margin: float = number(
        0.0, "b", "Background", "Distance from the start from which pixels are seeds of the background; at 0 only "
        "those at the border of the image are.",
        "More of it leaves more room around the start.", (0.0, 1e5), (0.0, 200.0), 1.0, "px",
    )  # fmt: skip


def seeds(inside: Mask, settings: RandomWalkerSettings) -> NDArray[np.int32]:
    """Labels of the seeds, shape (H, W): `OBJECT`, `BACKGROUND`, or 0 where there is none."""
    edt = scipy.ndimage.distance_transform_edt
    depth = edt(np.pad(inside, 1))[1:-1, 1:-1]
    rim = np.ones(inside.shape, dtype=bool)
    rim[1:-1, 1:-1] = False
    far = edt(~inside) >= settings.margin if settings.margin > 0.0 else rim
    labels = np.where(far & ~inside, BACKGROUND, 0)
    return np.where(inside & (depth >= settings.depth * depth.max()), OBJECT, labels).astype(np.int32)


def _evolve(image: Image, start: Start, settings: RandomWalkerSettings) -> Iterator[LevelSetState]:
    inside = start.mask(image.shape)
    yield LevelSetState(values=inside, level=0.5)
    labels = seeds(inside, settings)
    if {OBJECT, BACKGROUND} - set(np.unique(labels).tolist()):
        missing = "object" if not (labels == OBJECT).any() else "background"
        yield LevelSetState(1, f"there are no seeds of the {missing}", values=inside, level=0.5)
        return
    mode = "bf" if labels.size <= _DIRECT else "cg_j"
    found = skimage.segmentation.random_walker(unit_gray(image), labels, settings.beta, mode)
    yield LevelSetState(1, "all pixels have been decided", True, found == OBJECT, 0.5)


RANDOM_WALKER = ContourMethod(
    "random_walker",
    "Random walker",
    "Each pixel goes to the seeds, inside the start or at the border, that a random walk from it reaches first.",
    "Grady (2006), doi:10.1109/TPAMI.2006.233; scikit-image's random_walker",
    RandomWalkerSettings,
    _evolve,
    1,
)
