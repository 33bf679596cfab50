"""Grab cut by OpenCV: minimum cuts between object and background, whose colors are learned in turn; one cut a step."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.image.image import Image
from cpm_core.numerics.types import Mask
from cpm_core.objects.methods.gray import unit_gray
from cpm_core.objects.methods.method import ContourMethod, Needed, Start
from cpm_core.objects.methods.regions.certain import certain_pixels
from cpm_core.objects.methods.settings import Settings, number
from cpm_core.objects.methods.states import LevelSetState

MOST_STEPS = 50

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


def _evolve(image: Image, start: Start, settings: GrabCutSettings) -> Iterator[LevelSetState]:
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
    for step in range(1, MOST_STEPS + 1):
        how = opencv.GC_INIT_WITH_MASK if step == 1 else opencv.GC_EVAL
        opencv.grabCut(samples, labels, None, behind, before, 1, how)
        found = _inside(labels)
        rest, inside = bool(np.array_equal(found, inside)), found
        reason = "the cut is at rest" if rest else f"stopped after {step} steps" if step == MOST_STEPS else ""
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
    _evolve,
    MOST_STEPS,
    OPENCV,
)
