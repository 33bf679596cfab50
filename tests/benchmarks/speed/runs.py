"""Whole runs, from the image to the contours, beside level sets and snakes on the same image."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import skimage

from cpm_core.image.image import Image
from cpm_core.image.pyramid import max_scales
from cpm_core.model.starts import circle, uniform_grid
from cpm_core.model.volume.starts import sphere
from cpm_core.numerics.types import Array
from cpm_core.parameters import PRESETS
from cpm_core.segmentation.evolve import segment
from tests.benchmarks.speed.measurement import Measurement, Patience, seconds_of
from tests.benchmarks.speed.scenes import HAND, objects, one_object, ring

_RADIUS, _AROUND, _SNAKE = 12.0, 33.0, 200
"""Radius of the circle inside one object, and of that around it from which a snake starts [px]; points of the snake."""

_AUTOMATIC = PRESETS["automatic"]


def whole_runs(patience: Patience, image: Image | None = None) -> Iterator[Measurement]:
    """Runs that start everywhere, one row for each peer, on an image or else on a synthetic scene.

    On the scene also a run that starts in one object, and one in a volume.
    """
    values = image.values if image is not None else objects((160, 220) if patience.quick else HAND)
    name = image.source if image is not None else "scene"
    what = f"{name} {_size(values)}, start everywhere"
    peers = _level_sets(values)
    ours, *theirs = seconds_of(patience, lambda: _everywhere(values), *peers.values())
    for peer, seconds in zip(peers, theirs, strict=True):
        yield Measurement("run", what, ours, "s", peer, seconds)
    if image is None:
        yield _one_object(values, patience)
        yield _in_a_volume(patience)


def _everywhere(values: Array) -> object:
    return segment(values, uniform_grid(values.shape), replace(_AUTOMATIC, scales=_scales(values)))


def _scales(values: Array) -> int:
    """As many scales as usual, or as a small image permits."""
    return min(_AUTOMATIC.scales, max_scales(values.shape))


def _level_sets(values: Array) -> dict[str, Callable[[], object]]:
    """Other methods that need no seeds either."""
    gray = (values - values.min()) / max(float(np.ptp(values)), 1e-300)
    methods = skimage.segmentation

    def geodesic() -> object:
        slope = methods.inverse_gaussian_gradient(gray)
        return methods.morphological_geodesic_active_contour(slope, 230, init_level_set="disk", balloon=1)

    return {
        "morphological GAC, 230 iterations": geodesic,
        "morphological Chan-Vese, 35 iterations": lambda: methods.morphological_chan_vese(gray, 35),
        "Chan-Vese, 200 iterations": lambda: methods.chan_vese(gray, max_num_iter=200),
    }


def _one_object(values: Array, patience: Patience) -> Measurement:
    """A circle in one object, beside a snake around it; both times include the preparation of the whole image."""
    center = one_object(values.shape)
    angle = 2.0 * np.pi * np.arange(_SNAKE) / _SNAKE
    around = np.array(center) + _AROUND * np.stack([np.sin(angle), np.cos(angle)], axis=1)

    def snake() -> object:
        smooth = skimage.filters.gaussian(values / 255.0, 2.0)
        return skimage.segmentation.active_contour(smooth, around, alpha=0.015, beta=1.0, gamma=0.01)

    ours, peer = seconds_of(patience, lambda: segment(values, circle(center, _RADIUS)), snake)
    what = f"scene {_size(values)}, circle in one object"
    return Measurement("run", what, ours, "s", "active contour from around it", peer)


def _in_a_volume(patience: Patience) -> Measurement:
    """A sphere in a ring, to the surface, beside a level set from the same sphere until it has filled the ring."""
    values = ring(40 if patience.quick else 64)
    middle, iterations = 0.5 * (len(values) - 1), round(1.1 * len(values))
    center, radius = (middle, middle + 0.28 * len(values), middle), 0.08 * len(values)
    began = np.linalg.norm(np.moveaxis(np.indices(values.shape), 0, -1) - center, axis=-1) < radius

    def ours() -> object:
        return segment(values, sphere(center, radius, 150), PRESETS["volume"])

    def geodesic() -> object:
        slope = skimage.segmentation.inverse_gaussian_gradient(values / 255.0, alpha=1000.0, sigma=1.0)
        level_set = skimage.segmentation.morphological_geodesic_active_contour
        return level_set(slope, iterations, init_level_set=began, balloon=1, threshold=0.4)

    ours()  # compiles the loops of volumes
    seconds, peer = seconds_of(patience, ours, geodesic)
    what = f"ring {_size(values)}, sphere in it"
    return Measurement("run", what, seconds, "s", f"morphological GAC, {iterations} iterations", peer)


def _size(values: Array) -> str:
    return " x ".join(map(str, values.shape))
