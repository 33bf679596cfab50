"""Chan-Vese: two regions of little variance each, with a short boundary; by scikit-image, one step at a time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import skimage

from cpm_core.image.image import Image
from cpm_core.numerics.types import Array, Mask
from cpm_core.objects.methods.gray import unit_gray
from cpm_core.objects.methods.level_sets import distance_of
from cpm_core.objects.methods.method import ContourMethod, Start
from cpm_core.objects.methods.settings import Settings, number
from cpm_core.objects.methods.states import LevelSetState

MOST_STEPS = 500

INSIDE = (
    "λ₁", "Likeness inside", "Weight of the differences of gray levels from their mean inside.",
    "More of it makes the inside more uniform.", (0.0, 100.0), (0.1, 5.0), 0.1,
)  # fmt: skip
OUTSIDE = (
    "λ₂", "Likeness outside", "Weight of the differences of gray levels from their mean outside.",
    "More of it makes the outside more uniform.", (0.0, 100.0), (0.1, 5.0), 0.1,
)  # fmt: skip
"""What is said of the two weights of Chan-Vese, and their ranges, whatever they act on."""


@dataclass(frozen=True)
class ChanVeseSettings(Settings):
    """Parameters of Chan-Vese, as scikit-image's ``chan_vese`` has them."""

    mu: float = number(
        0.25, "μ", "Smoothness", "Weight of the length of the boundary.",
        "More of it gives a shorter and rounder boundary and leaves out small regions.",
        (0.0, 100.0), (0.0, 1.0), 0.01,
    )  # fmt: skip
    lambda1: float = number(1.0, *INSIDE)
    lambda2: float = number(1.0, *OUTSIDE)
    tolerance: float = number(
        1e-4, "ε", "Tolerance", "Mean change of the function in a step at which the run ends.",
        "More of it ends the run sooner.", (0.0, 1.0), (1e-5, 1e-2), 1e-5, advanced=True,
    )  # fmt: skip
    time_step: float = number(
        0.5, "Δt", "Time step", "Time between two steps.",
        "More of it takes fewer steps, and may not come to rest.", (0.01, 10.0), (0.1, 2.0), 0.1, advanced=True,
    )  # fmt: skip


def first_level_set(inside: Mask) -> Array:
    """The function that a run begins with, shape (H, W): the signed distance in units of the depth of the start.

    It is cut at -1 and 1: the farther from 0, the less a pixel is moved.
    """
    distance = distance_of(inside)
    return np.clip(distance / max(float(distance.max()), 1.0), -1.0, 1.0)


def _evolve(image: Image, start: Start, settings: ChanVeseSettings) -> Iterator[LevelSetState]:
    gray, phi = unit_gray(image), first_level_set(start.mask(image.shape))
    state = LevelSetState(values=phi)
    while True:
        yield state
        if state.stop_reason:
            return
        _, after, _ = skimage.segmentation.chan_vese(  # type: ignore[no-untyped-call]
            gray, settings.mu, settings.lambda1, settings.lambda2, 0.0, 1, settings.time_step, phi, True
        )
        rest = bool(np.sqrt(((after - phi) ** 2).mean()) <= settings.tolerance)
        phi, state = after, LevelSetState(state.step + 1, "the function is at rest" if rest else "", rest, after)
        if not rest and state.step == MOST_STEPS:
            state = replace(state, stop_reason=f"stopped after {MOST_STEPS} steps")


CHAN_VESE = ContourMethod(
    "chan_vese",
    "Chan-Vese",
    "A level set that divides the image into two regions, each of gray levels near its mean; it needs no edges.",
    "Chan and Vese (2001), doi:10.1109/83.902291; scikit-image's chan_vese",
    ChanVeseSettings,
    _evolve,
    MOST_STEPS,
)
