"""What the widget for napari finds: objects by places and drawn lines, and runs, as work that can be interrupted."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import skimage

import cpm_core as cpm
from cpm_core.contours import surfaces_joined
from cpm_core.contours.surface import surface_of_labels
from cpm_core.numerics import Array, Index
from cpm_core.objects import boundaries_result, without_run
from cpm_core.shapes import starts_along

Said = tuple[str, Array | None]
"""How far work has come: a sentence, and where the particles are."""

Work = Generator[Said, None, Any]
"""Work that reports how far it has come, and can be interrupted then."""

_PAUSE = 0.1
"""Least time between two reports of a run [s]."""


def objects_at(image: cpm.Image, inside: Array, outside: Array, drawn: Sequence[cpm.Contour]) -> Work:
    """Find an object at each place inside, in the box of each closed line, and along each open one, as a result.

    None has a place outside. A place in an object that has been found gives no other.
    """
    if image.ndim == 3 and drawn:
        raise ValueError("In a volume, objects are found at points: choose no shapes, or a run from the shapes.")
    partition: Any = without_run(image)
    found: list[Any] = []
    prompts = [{"inside": inside[[number]]} for number in range(len(inside))]
    prompts += [{"box": np.array(one.box)} if one.closed else {"stroke": one.points} for one in drawn]
    for number, prompt in enumerate(prompts, 1):
        yield f"Object {number} of {len(prompts)}", None
        if "inside" in prompt and any(one.holds(prompt["inside"]).all() for one in found):
            continue
        one = partition.select(**prompt)
        wrong = outside[one.holds(outside)]
        one = partition.select(**prompt, outside=wrong, previous=one) if len(wrong) else one
        if one.found and not one.only_places:
            found.append(one)
    if not found:
        raise ValueError("No object was found there: move the points, or draw a box around an object.")
    if image.ndim == 2:
        return cpm.objects_result(found, image)
    surface = surfaces_joined([(at, one.surface) for at, one in enumerate(found, 1)], image.spacing, image.unit)
    empty = boundaries_result((), (), image.shape, image.spacing, image.unit, image.source)
    return replace(empty, surface=surface)


def corrected(image: cpm.Image, labels: Index, number: int, inside: Array, outside: Array) -> Work:
    """Correct the object of a label by places, as labels; all others stay as they are."""
    partition: Any = without_run(image)
    mask = labels == number
    pixels = np.argwhere(mask).astype(float)
    if not len(pixels):
        raise ValueError(f"No pixel has the label {number}: select the label of the object to correct in its layer.")
    yield f"Label {number}", None
    middle = pixels[[np.linalg.norm(pixels - pixels.mean(axis=0), axis=1).argmin()]]
    if image.ndim == 2:
        before = partition.selection_of(mask, middle)
    else:
        surface = surface_of_labels(mask.astype(np.int32), image.spacing, image.unit)
        before = cpm.VolumeSelection(partition, surface, middle, np.empty((0, 3)))
    better = partition.select(np.concatenate([middle, inside]), outside, previous=before).mask
    return np.where(better & ((labels == 0) | mask), number, np.where(mask, 0, labels))


def run(image: cpm.Image, seeds: Array, parameters: Callable[[], cpm.Parameters]) -> Work:
    """Run from seeds to a result; the parameters of each step are those of the moment."""
    moments, then = cpm.evolve(image, seeds, parameters()), 0.0
    for moment in moments:
        moments.parameters = parameters()
        if time.monotonic() - then > _PAUSE:
            yield f"Step {moment.step}, {moment.count} particles", moment.position
            then = time.monotonic()
    return moments.result


def seeds_of(drawn: Sequence[cpm.Contour], labels: Index | None) -> Array:
    """Particles along drawn lines, and along the boundaries of labels."""
    seeds = [start.seeds() for start in starts_along(drawn)]
    if labels is not None:
        boundaries = skimage.segmentation.find_boundaries(labels, mode="inner")  # type: ignore[no-untyped-call]
        seeds.append(np.argwhere(boundaries)[::2].astype(float))
    if not seeds:
        raise ValueError("Draw a shape in or around an object, or choose labels: particles start along them.")
    return np.concatenate(seeds)
