"""Methods of scikit-image and OpenCV that divide the image into regions, step by step where they have steps.

The smoothing of scikit-image's morphological snakes alternates between two operators, and which one is next is kept for
the whole process: a function that is called twice may give two results, and two runs that take turns disturb each
other. `_Turn` puts the same operator first before each call, so that a run gives what the function gives in a process
of its own.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy
import skimage
from numpy.typing import NDArray

from cpm_core.image.image import Image
from cpm_core.numerics.types import Array, Mask
from cpm_core.objects.methods.gray import unit_gray
from cpm_core.objects.methods.level_sets import distance_of
from cpm_core.objects.methods.method import ContourMethod, Needed, Start
from cpm_core.objects.methods.settings import Settings, number
from cpm_core.objects.methods.states import LevelSetState, until_at_rest


def certain_pixels(start: Start, shape: tuple[int, ...], depth: float, margin: float) -> tuple[Mask, Mask]:
    """Pixels of the object and of the background, of this shape each; they may overlap at the border of the image.

    A start in the object is all object, and the border of the image, or what lies farther than `margin` from the
    start, background. A start around the object has in the object what is deeper in it than the fraction `depth` of
    the greatest depth, and what lies outside it is background.
    """
    inside = start.mask(shape)
    edt = scipy.ndimage.distance_transform_edt
    rim = np.ones(shape, dtype=bool)
    rim[(slice(1, -1),) * len(shape)] = False
    if start.around:
        deep = edt(np.pad(inside, 1))[(slice(1, -1),) * len(shape)]
        return inside & (deep >= depth * deep.max()), ~inside | rim
    return inside, edt(~inside) >= margin if margin > 0.0 else rim


_CHAN_VESE_STEPS = 500

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


def _chan_vese(image: Image, start: Start, settings: ChanVeseSettings) -> Iterator[LevelSetState]:
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
        if not rest and state.step == _CHAN_VESE_STEPS:
            state = replace(state, stop_reason=f"stopped after {_CHAN_VESE_STEPS} steps")


CHAN_VESE = ContourMethod(
    "chan_vese",
    "Chan-Vese",
    "A level set that divides the image into two regions, each of gray levels near its mean; it needs no edges.",
    "Chan and Vese (2001), doi:10.1109/83.902291; scikit-image's chan_vese",
    ChanVeseSettings,
    _chan_vese,
    _CHAN_VESE_STEPS,
)


Bits = NDArray[np.int8]
_Steps = Callable[[Bits, int, Callable[[Bits], None]], Any]
"""Does a number of steps from a mask and hands over the mask before them and after each."""

_MORPHOLOGICAL_STEPS = 1000

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
    return until_at_rest(_states(first, steps), _EVERY, _REST, _MORPHOLOGICAL_STEPS)


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


def _morph_gac(image: Image, start: Start, settings: MorphologicalGacSettings) -> Iterator[LevelSetState]:
    factor = skimage.segmentation.inverse_gaussian_gradient(  # type: ignore[no-untyped-call]
        unit_gray(image), settings.steepness, settings.sigma
    )

    balloon = start.onward * settings.balloon

    def steps(mask: Bits, count: int, tell: Callable[[Bits], None]) -> object:
        return skimage.segmentation.morphological_geodesic_active_contour(  # type: ignore[no-untyped-call]
            factor, count, mask, settings.smoothing, settings.threshold, balloon, tell
        )

    return _run(image, start, steps)


def _morph_chan_vese(image: Image, start: Start, settings: MorphologicalChanVeseSettings) -> Iterator[LevelSetState]:
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
    _morph_gac,
    _MORPHOLOGICAL_STEPS,
    in_volumes=True,
)

MORPHOLOGICAL_CHAN_VESE = ContourMethod(
    "morph_chan_vese",
    "Morphological Chan-Vese",
    "Chan-Vese with masks in place of a level set: pixels at the boundary go to the region whose mean is nearer.",
    _REFERENCE + "morphological_chan_vese",
    MorphologicalChanVeseSettings,
    _morph_chan_vese,
    _MORPHOLOGICAL_STEPS,
    in_volumes=True,
)


_OBJECT_SEED, _BACKGROUND_SEED = 1, 2
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
    """Labels of the seeds, shape (H, W): `_OBJECT_SEED`, `_BACKGROUND_SEED`, or 0 where there is none.

    A start in the object is all object, and the border of the image, or what lies far from the start, background. A
    start around the object has only its middle in the object, and what lies outside it is background.
    """
    inner, outer = certain_pixels(start, shape, settings.depth, settings.margin)
    return np.where(inner, _OBJECT_SEED, np.where(outer, _BACKGROUND_SEED, 0)).astype(np.int32)


def _random_walk(image: Image, start: Start, settings: RandomWalkerSettings) -> Iterator[LevelSetState]:
    inside = start.mask(image.shape)
    yield LevelSetState(values=inside, level=0.5)
    labels = seeds(start, image.shape, settings)
    if {_OBJECT_SEED, _BACKGROUND_SEED} - set(np.unique(labels).tolist()):
        missing = "object" if not (labels == _OBJECT_SEED).any() else "background"
        yield LevelSetState(1, f"there are no seeds of the {missing}", values=inside, level=0.5)
        return
    mode = "bf" if labels.ndim == 2 and labels.size <= _DIRECT else "cg_j"
    found = skimage.segmentation.random_walker(unit_gray(image), labels, settings.beta, mode, prob_tol=_NO_WARNING)
    yield LevelSetState(1, "all pixels have been decided", True, found == _OBJECT_SEED, 0.5)


RANDOM_WALKER = ContourMethod(
    "random_walker",
    "Random walker",
    "Each pixel goes to the seeds, inside the start or at the border, that a random walk from it reaches first.",
    "Grady (2006), doi:10.1109/TPAMI.2006.233; scikit-image's random_walker",
    RandomWalkerSettings,
    _random_walk,
    1,
    in_volumes=True,
)


_GRAB_CUT_STEPS = 50

OPENCV = Needed("cv2", "opencv-python-headless", "opencv")

BACKGROUND, OBJECT, MAYBE_BACKGROUND, MAYBE_OBJECT = range(4)
"""What is said of a pixel, as OpenCV numbers it; the first two are certain."""

_MODEL = (1, 65)
"""Shape of what OpenCV keeps of the colors of a region."""

_SEED = 0
"""Of the random numbers by which OpenCV first groups colors: a run gives the same again."""


@dataclass(frozen=True)
class GrabCutSettings(Settings):
    """Parameters of grab cut."""

    smoothing: float = number(
        0.0, "σ", "Smoothing", "Width of the Gaussian that smooths the image before it is cut.",
        "More of it removes noise and rounds corners.", (0.0, 50.0), (0.0, 8.0), 0.5, "px",
    )  # fmt: skip
    depth: float = number(
        1.0, "d", "Depth of the seeds",
        "From a start around the object: the depth from which pixels certainly belong to it, as a fraction of the "
        "greatest; at 1 none does.",
        "Less of it makes more pixels of the start certain.", (0.0, 1.0), (0.0, 1.0), 0.05,
    )  # fmt: skip
    margin: float = number(
        0.0, "b", "Background",
        "Distance from a start inside the object from which pixels are certainly background; at 0 at the border.",
        "More of it leaves more room around the start.", (0.0, 1e5), (0.0, 200.0), 1.0, "px",
    )  # fmt: skip


def samples_of(image: Image, smoothing: float) -> NDArray[np.uint8]:
    """The colors of an image, or three times its gray levels, as OpenCV takes them, shape (H, W, 3)."""
    if image.colors is None:
        channels = [unit_gray(image)] * 3
    else:
        channels = [image.colors.samples[..., channel] / 255.0 for channel in (2, 1, 0)]
    smooth = (scipy.ndimage.gaussian_filter(one, smoothing, mode="nearest") for one in channels)
    return np.stack([np.rint(255.0 * np.clip(one, 0.0, 1.0)).astype(np.uint8) for one in smooth], axis=-1)


def first_labels(start: Start, shape: tuple[int, ...], settings: GrabCutSettings) -> NDArray[np.uint8]:
    """What the start says of each pixel, shape (H, W).

    A start in the object is object, and what lies around it is background unless the colors say otherwise; the border
    of the image, or what lies far from the start, is certainly background. A start around the object may be object all
    over, and what lies outside it is background.
    """
    inner, outer = certain_pixels(start, shape, settings.depth, settings.margin)
    if start.around:
        labels = np.where(outer, BACKGROUND, np.where(inner & (settings.depth < 1.0), OBJECT, MAYBE_OBJECT))
    else:
        labels = np.where(inner, OBJECT, np.where(outer, BACKGROUND, MAYBE_BACKGROUND))
    return labels.astype(np.uint8)


def _inside(labels: NDArray[np.uint8]) -> Mask:
    return np.asarray((labels == OBJECT) | (labels == MAYBE_OBJECT))


def _grab_cut(image: Image, start: Start, settings: GrabCutSettings) -> Iterator[LevelSetState]:
    opencv: Any = OPENCV.module()
    yield LevelSetState(values=start.mask(image.shape), level=0.5)
    labels = first_labels(start, image.shape, settings)
    inside = _inside(labels)
    if not inside.any() or inside.all():
        missing = "background" if inside.all() else "object"
        yield LevelSetState(1, f"there are no seeds of the {missing}", values=inside, level=0.5)
        return
    samples, behind, before = samples_of(image, settings.smoothing), np.zeros(_MODEL), np.zeros(_MODEL)
    opencv.setRNGSeed(_SEED)
    for step in range(1, _GRAB_CUT_STEPS + 1):
        how = opencv.GC_INIT_WITH_MASK if step == 1 else opencv.GC_EVAL
        opencv.grabCut(samples, labels, None, behind, before, 1, how)
        found = _inside(labels)
        rest, inside = bool(np.array_equal(found, inside)), found
        reason = "the cut is at rest" if rest else f"stopped after {step} steps" if step == _GRAB_CUT_STEPS else ""
        if not inside.any() or inside.all():
            reason = "the contour has left the image" if inside.all() else "nothing is left"
        yield LevelSetState(step, reason, rest, found, 0.5)
        if reason:
            return


GRAB_CUT = ContourMethod(
    "grab_cut",
    "Grab cut",
    "Minimum cuts between object and background, whose colors or gray levels are learned from the cut before.",
    "Rother, Kolmogorov and Blake (2004), doi:10.1145/1015706.1015720; OpenCV's grabCut",
    GrabCutSettings,
    _grab_cut,
    _GRAB_CUT_STEPS,
    OPENCV,
)
