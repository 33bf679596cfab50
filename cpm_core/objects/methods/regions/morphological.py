"""Morphological snakes by scikit-image: the geodesic active contour and Chan-Vese on masks, one step at a time.

The smoothing of scikit-image alternates between two operators, and which one is next is kept for the whole process: a
function that is called twice may give two results, and two runs that take turns disturb each other. `_Turn` puts the
same operator first before each call, so that a run gives what the function gives in a process of its own.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import skimage
from numpy.typing import NDArray

from cpm_core.image.image import Image
from cpm_core.objects.methods.gray import unit_gray
from cpm_core.objects.methods.method import ContourMethod, Start
from cpm_core.objects.methods.regions.chan_vese import INSIDE, OUTSIDE
from cpm_core.objects.methods.settings import Settings, number
from cpm_core.objects.methods.states import LevelSetState, until_at_rest

Bits = NDArray[np.int8]
_Steps = Callable[[Bits, int, Callable[[Bits], None]], Any]
"""Does a number of steps from a mask and hands over the mask before them and after each."""

MOST_STEPS = 1000

_AT_A_TIME = 4
"""Steps done in one call; an even number, so that each call begins with the same operator."""

_EVERY = 40
"""A mask is at rest when it is the same after so many steps, or differs in a few pixels that alternate."""

_REST = 0.002
_SMOOTHING = (
    "How often the contour is smoothed in a step.",
    "More of it gives a rounder contour.",
)


@dataclass(frozen=True)
class MorphologicalGacSettings(Settings):
    """Parameters of the morphological geodesic active contour, as scikit-image has them."""

    balloon: float = number(
        1.0, "c", "Balloon", "Constant pressure that drives it on: outwards, or inwards from around the object.",
        "More of it lets the contour cross stronger edges.", (-20.0, 20.0), (-2.0, 2.0), 0.1,
    )  # fmt: skip
    smoothing: int = number(0, "μ", "Smoothness", *_SMOOTHING, (0, 20), (0, 4), 1)
    threshold: float = number(
        0.6, "θ", "Threshold", "Value of the stopping factor under which the balloon stops.",
        "More of it stops the contour at weaker edges.", (0.0, 1.0), (0.1, 1.0), 0.02,
    )  # fmt: skip
    steepness: float = number(
        100.0, "α", "Steepness", "How steeply the stopping factor falls with the edge strength.",
        "More of it makes weak edges count.", (0.0, 1e5), (10.0, 2000.0), 10.0,
    )  # fmt: skip
    sigma: float = number(
        3.0, "σ", "Smoothing", "Width of the Gaussian that smooths the image before its edges are found.",
        "More of it removes noise and rounds corners.", (0.1, 50.0), (0.5, 8.0), 0.5, "px",
    )  # fmt: skip


@dataclass(frozen=True)
class MorphologicalChanVeseSettings(Settings):
    """Parameters of morphological Chan-Vese, as scikit-image has them."""

    smoothing: int = number(1, "μ", "Smoothness", *_SMOOTHING, (0, 20), (0, 4), 1)
    lambda1: float = number(0.7, *INSIDE)
    lambda2: float = number(1.0, *OUTSIDE)


class _Turn:
    """Whose turn it is among the two operators of scikit-image's smoothing."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._probe = np.array([[1, 0, 1], [1, 0, 0], [0, 1, 1]], dtype=np.int8)  # only the first leaves something

    def call(self, work: Callable[[], object]) -> None:
        """Do something with the operator first that is first in a new process, while nothing else smooths."""
        with self._lock:
            if self._smoothed_probe().any():  # by the first: it is the turn of the second now
                self._smoothed_probe()
            work()

    def _smoothed_probe(self) -> Bits:
        flat = np.zeros(self._probe.shape)
        chan_vese = skimage.segmentation.morphological_chan_vese
        smoothed: Bits = chan_vese(flat, 1, self._probe, 1)  # type: ignore[no-untyped-call]
        return smoothed


_TURN = _Turn()


def _run(image: Image, start: Start, steps: _Steps) -> Iterator[LevelSetState]:
    first = start.mask(image.shape).astype(np.int8)
    return until_at_rest(_states(first, steps), _EVERY, _REST, MOST_STEPS)


def _states(first: Bits, steps: _Steps) -> Iterator[LevelSetState]:
    mask, done = first, 0
    yield LevelSetState(0, values=mask, level=0.5)
    while True:
        begin = mask
        for mask in _some(steps, begin):
            done += 1
            yield LevelSetState(done, values=mask, level=0.5)


def _some(steps: _Steps, mask: Bits) -> list[Bits]:
    """The masks after the next steps."""
    found: list[Bits] = []
    _TURN.call(lambda: steps(mask, _AT_A_TIME, lambda bits: found.append(bits.copy())))
    return found[1:]


def _geodesic(image: Image, start: Start, settings: MorphologicalGacSettings) -> Iterator[LevelSetState]:
    factor = skimage.segmentation.inverse_gaussian_gradient(  # type: ignore[no-untyped-call]
        unit_gray(image), settings.steepness, settings.sigma
    )

    balloon = start.onward * settings.balloon

    def steps(mask: Bits, count: int, tell: Callable[[Bits], None]) -> object:
        return skimage.segmentation.morphological_geodesic_active_contour(  # type: ignore[no-untyped-call]
            factor, count, mask, settings.smoothing, settings.threshold, balloon, tell
        )

    return _run(image, start, steps)


def _chan_vese(image: Image, start: Start, settings: MorphologicalChanVeseSettings) -> Iterator[LevelSetState]:
    gray = unit_gray(image)

    def steps(mask: Bits, count: int, tell: Callable[[Bits], None]) -> object:
        return skimage.segmentation.morphological_chan_vese(  # type: ignore[no-untyped-call]
            gray, count, mask, settings.smoothing, settings.lambda1, settings.lambda2, tell
        )

    return _run(image, start, steps)


_REFERENCE = "Márquez-Neila, Baumela and Álvarez (2014), doi:10.1109/TPAMI.2013.106; scikit-image's "

MORPHOLOGICAL_GAC = ContourMethod(
    "morph_gac",
    "Morphological GAC",
    "The geodesic active contour with masks in place of a level set: a balloon, edges that stop it, and smoothing.",
    _REFERENCE + "morphological_geodesic_active_contour",
    MorphologicalGacSettings,
    _geodesic,
    MOST_STEPS,
    in_volumes=True,
)

MORPHOLOGICAL_CHAN_VESE = ContourMethod(
    "morph_chan_vese",
    "Morphological Chan-Vese",
    "Chan-Vese with masks in place of a level set: pixels at the boundary go to the region whose mean is nearer.",
    _REFERENCE + "morphological_chan_vese",
    MorphologicalChanVeseSettings,
    _chan_vese,
    MOST_STEPS,
    in_volumes=True,
)
