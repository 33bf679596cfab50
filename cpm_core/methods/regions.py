"""Methods of scikit-image that divide the image into regions, step by step where they have steps."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import scipy
import skimage
from numpy.typing import NDArray

from cpm_core.image.image import Image
from cpm_core.methods.method import (
    ContourMethod,
    ContourState,
    Settings,
    Start,
    build_region_state,
    declare_setting,
    iterate_until_at_rest,
    signed_region_distance,
    unit_gray,
)
from cpm_core.numerics.grids import measure_depth
from cpm_core.numerics.types import Array, Extent, frozen

_MAX_CHAN_VESE_STEPS = 500


@frozen
class ChanVeseSettings(Settings):
    """Parameters of Chan-Vese, as scikit-image's ``chan_vese`` has them.

    Attributes
    ----------
    mu : float
        Weight of the length of the boundary. Larger values give a shorter and rounder boundary and leave out small
        regions.
    lambda1 : float
        Weight of the differences of gray levels from their mean inside. Larger values make the inside more uniform.
    lambda2 : float
        Weight of the differences of gray levels from their mean outside. Larger values make the outside more uniform.
    """

    mu: float = declare_setting(0.25, 0.0, 100.0)
    lambda1: float = declare_setting(1.0, 0.0, 100.0)
    lambda2: float = declare_setting(1.0, 0.0, 100.0)


def evolve_chan_vese(image: Image, start: Start, settings: ChanVeseSettings) -> Iterator[ContourState]:
    """Evolve Chan-Vese."""
    gray = unit_gray(image)

    def iterate_functions() -> Iterator[Array]:
        """Yield the function after each step, shape (H, W)."""
        # the signed distance in units of the depth of the start: the farther from 0, the less a pixel is moved
        distance = signed_region_distance(start.mask(image.shape))
        phi = np.clip(distance / max(float(distance.max()), 1.0), -1.0, 1.0)
        while True:
            yield phi
            _, phi, _ = skimage.segmentation.chan_vese(  # type: ignore[no-untyped-call]
                gray, settings.mu, settings.lambda1, settings.lambda2, 0.0, 1, 0.5, phi, True
            )

    return iterate_until_at_rest(iterate_functions(), 0.0, _MAX_CHAN_VESE_STEPS)


CHAN_VESE = ContourMethod(
    "chan_vese",
    "Chan-Vese",
    "A level set that divides the image into two regions, each of gray levels near its mean; it needs no edges.",
    "Chan and Vese (2001), doi:10.1109/83.902291; scikit-image's chan_vese",
    ChanVeseSettings,
    evolve_chan_vese,
)


Bits = NDArray[np.int8]

_MAX_MORPHOLOGICAL_STEPS = 1000

_STEPS_PER_CALL = 4

_SMOOTHING_LOCK = threading.Lock()
"""scikit-image's smoothing alternates between two operators in the whole process, also between runs that take turns.

Calls of an even number of steps, one at a time, begin with the same operator each.
"""


@frozen
class MorphologicalGacSettings(Settings):
    """Parameters of the morphological geodesic active contour, as scikit-image has them.

    Attributes
    ----------
    balloon : float
        Constant pressure that drives it on: outwards, or inwards from around the object. Larger values let the contour
        cross stronger edges.
    smoothing : int
        How often the contour is smoothed in a step. Larger values give a rounder contour.
    threshold : float
        Value of the stopping factor under which the balloon stops. Larger values stop the contour at weaker edges.
    steepness : float
        How steeply the stopping factor falls with the edge strength. Larger values make weak edges count.
    sigma : float
        Width of the Gaussian that smooths the image before its edges are found [px]. Larger values remove noise and
        round corners.
    """

    balloon: float = declare_setting(1.0, -20.0, 20.0)
    smoothing: int = declare_setting(0, 0, 20)
    threshold: float = declare_setting(0.6, 0.0, 1.0)
    steepness: float = declare_setting(100.0, 0.0, 1e5)
    sigma: float = declare_setting(3.0, 0.0, 50.0)


@frozen
class MorphologicalChanVeseSettings(Settings):
    """Parameters of morphological Chan-Vese, as scikit-image has them.

    Attributes
    ----------
    smoothing : int
        How often the contour is smoothed in a step. Larger values give a rounder contour.
    lambda1 : float
        Weight of the differences of gray levels from their mean inside. Larger values make the inside more uniform.
    lambda2 : float
        Weight of the differences of gray levels from their mean outside. Larger values make the outside more uniform.
    """

    smoothing: int = declare_setting(1, 0, 20)
    lambda1: float = declare_setting(0.7, 0.0, 100.0)
    lambda2: float = declare_setting(1.0, 0.0, 100.0)


def _evolve_morphological(image: Image, start: Start, advance: Callable[[Bits, Any], object]) -> Iterator[ContourState]:
    """Evolve a mask by `advance`, which does `_STEPS_PER_CALL` steps and hands over each."""

    def advance_from(mask: Bits) -> list[Bits]:
        found: list[Bits] = []
        with _SMOOTHING_LOCK:
            advance(mask, lambda bits: found.append(bits.copy()))
        return found

    def iterate_masks() -> Iterator[Bits]:
        some = [start.mask(image.shape).astype(np.int8)]
        yield some[0]
        while True:
            some = advance_from(some[-1])
            yield from some[1:]

    return iterate_until_at_rest(iterate_masks(), 0.5, _MAX_MORPHOLOGICAL_STEPS)


def evolve_morph_gac(image: Image, start: Start, settings: MorphologicalGacSettings) -> Iterator[ContourState]:
    """Evolve the morphological geodesic active contour."""
    factor = skimage.segmentation.inverse_gaussian_gradient(  # type: ignore[no-untyped-call]
        unit_gray(image), settings.steepness, settings.sigma
    )
    balloon = start.pressure_sign * settings.balloon
    snake = skimage.segmentation.morphological_geodesic_active_contour
    return _evolve_morphological(
        image,
        start,
        lambda mask, add: snake(factor, _STEPS_PER_CALL, mask, settings.smoothing, settings.threshold, balloon, add),  # type: ignore[no-untyped-call]
    )


def evolve_morph_chan_vese(
    image: Image, start: Start, settings: MorphologicalChanVeseSettings
) -> Iterator[ContourState]:
    """Evolve morphological Chan-Vese."""
    gray, snake = unit_gray(image), skimage.segmentation.morphological_chan_vese
    return _evolve_morphological(
        image,
        start,
        lambda mask, add: snake(  # type: ignore[no-untyped-call]
            gray, _STEPS_PER_CALL, mask, settings.smoothing, settings.lambda1, settings.lambda2, add
        ),
    )


_MORPHOLOGICAL_REFERENCE = "Márquez-Neila, Baumela and Álvarez (2014), doi:10.1109/TPAMI.2013.106; scikit-image's "

MORPHOLOGICAL_GAC = ContourMethod(
    "morph_gac",
    "Morphological GAC",
    "The geodesic active contour with masks in place of a level set: a balloon, edges that stop it, and smoothing.",
    _MORPHOLOGICAL_REFERENCE + "morphological_geodesic_active_contour",
    MorphologicalGacSettings,
    evolve_morph_gac,
)

MORPHOLOGICAL_CHAN_VESE = ContourMethod(
    "morph_chan_vese",
    "Morphological Chan-Vese",
    "Chan-Vese with masks in place of a level set: pixels at the boundary go to the region whose mean is nearer.",
    _MORPHOLOGICAL_REFERENCE + "morphological_chan_vese",
    MorphologicalChanVeseSettings,
    evolve_morph_chan_vese,
)


_OBJECT_SEED = 1
"""Label of the seeds of the object."""

_BACKGROUND_SEED = 2
"""Label of the seeds of the background."""

_MAX_DIRECT_PIXELS = 300_000
"""Pixels up to which the equations are solved directly, which is faster; beyond, with less memory, by iteration."""

_PROBABILITY_TOLERANCE = 1.0
"""Error of probabilities up to which scikit-image does not warn; only which of two is larger counts."""


@frozen
class RandomWalkerSettings(Settings):
    """Parameters of the random walker.

    Attributes
    ----------
    beta : float
        How hard it is for a walk to cross a difference of gray levels. Larger values follow weaker edges, and noise.
    depth : float
        From a start around the object: the depth from which pixels are its seeds, as a fraction of the greatest. Larger
        values leave seeds only in the middle.
    margin : float
        Distance from a start inside the object from which pixels are seeds of the background; at 0 at the border [px].
        Larger values leave more room around the start.
    """

    beta: float = declare_setting(2000.0, 0.0, 1e6)
    depth: float = declare_setting(0.8, 0.0, 0.99)
    margin: float = declare_setting(0.0, 0.0, 1e5)


def label_seeds(start: Start, shape: Extent, settings: RandomWalkerSettings) -> NDArray[np.int32]:
    """Label the seeds, of this shape: `_OBJECT_SEED`, `_BACKGROUND_SEED`, or 0 where there is none.

    A start in the object is all object; the border of the image, or what lies far from the start, is background. A
    start around the object has only its middle in the object, and what lies outside it is background.
    """
    inside = start.mask(shape)
    rim = np.ones(shape, dtype=bool)
    rim[1:-1, 1:-1] = False
    outer = rim if settings.margin == 0.0 else scipy.ndimage.distance_transform_edt(~inside) >= settings.margin
    if start.around:
        outer = rim | ~inside
        depth = measure_depth(inside)
        inside &= depth >= settings.depth * depth.max()
    return np.where(inside, _OBJECT_SEED, np.where(outer, _BACKGROUND_SEED, 0)).astype(np.int32)


def evolve_random_walker(image: Image, start: Start, settings: RandomWalkerSettings) -> Iterator[ContourState]:
    """Yield the start, and the result of the random walker."""
    inside = start.mask(image.shape)
    yield build_region_state(inside, 0.5, 0)
    labels = label_seeds(start, image.shape, settings)
    for label, what in ((_OBJECT_SEED, "object"), (_BACKGROUND_SEED, "background")):
        if not (labels == label).any():
            yield build_region_state(inside, 0.5, 1, f"there are no seeds of the {what}")
            return
    mode = "bf" if labels.size <= _MAX_DIRECT_PIXELS else "cg_j"
    found = skimage.segmentation.random_walker(
        unit_gray(image), labels, settings.beta, mode, prob_tol=_PROBABILITY_TOLERANCE
    )
    yield build_region_state(found == _OBJECT_SEED, 0.5, 1, "all pixels have been decided", converged=True)


RANDOM_WALKER = ContourMethod(
    "random_walker",
    "Random walker",
    "Each pixel goes to the seeds, inside the start or at the border, that a random walk from it reaches first.",
    "Grady (2006), doi:10.1109/TPAMI.2006.233; scikit-image's random_walker",
    RandomWalkerSettings,
    evolve_random_walker,
)
