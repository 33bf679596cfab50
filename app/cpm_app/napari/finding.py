"""Computations of the widget for napari, which can be interrupted: objects at points and drawn lines, and runs."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Sequence
from typing import Any

import numpy as np
import skimage

import cpm_core as cpm
from cpm_core.contours.surface import surface_from_labels
from cpm_core.image.region import Region
from cpm_core.numerics import Array, Index
from cpm_core.objects import partition_without_run
from cpm_core.results import replace_by_objects
from cpm_core.shapes import starts_from_contours

WorkProgress = tuple[str, Array | None]
"""Progress: a sentence, and positions of particles, shape (N, D), if any."""

Work = Generator[WorkProgress, None, Any]
"""Computation that yields its progress, where it can be interrupted, and returns its outcome."""

_REPORT_INTERVAL = 0.1
"""Shortest time between two reports of a run [s]."""


def find_objects_at(
    image: cpm.Image, inside: Array, outside: Array, drawn: Sequence[cpm.Contour], model: str = ""
) -> Work:
    """Find an object at each positive point, in the box of each closed line, and along each open one.

    Parameters
    ----------
    image : Image
        Image, or volume, where objects are found at points only.
    inside, outside : ndarray, shape (N, D)
        Positive and negative points (row, col) [px] or (plane, row, col) [voxels]. A positive point in an object that
        has been found gives no other; no object contains a negative point.
    drawn : sequence of Contour
        Closed lines, which are boxes, and open ones, which are scribbles.
    model : str
        The larger model that answers in place of the network.

    Yields
    ------
    tuple
        Progress.

    Returns
    -------
    Result
        The objects.

    Raises
    ------
    ValueError
        When no object is found, or lines are drawn in a volume.
    """
    if image.ndim == 3 and drawn:
        raise ValueError("In a volume, objects are found at points: choose no shapes, or a run from the shapes.")
    partition: Any = partition_without_run(image, model=model)
    found: list[Any] = []
    prompts = [{"inside": inside[[number]]} for number in range(len(inside))]
    prompts += [{"box": np.array(one.box)} if one.closed else {"stroke": one.points} for one in drawn]
    for number, prompt in enumerate(prompts, 1):
        yield f"Object {number} of {len(prompts)}", None
        if "inside" in prompt and any(one.contains(prompt["inside"]).all() for one in found):
            continue
        one = partition.select(**prompt)
        wrong = outside[one.contains(outside)]
        one = partition.select(**prompt, outside=wrong, previous=one) if len(wrong) else one
        if one.has_boundary and not one.has_only_points:
            found.append(one)
    if not found:
        raise ValueError("No object was found there: move the points, or draw a box around an object.")
    return cpm.objects_result(found, image)


def correct_label(image: cpm.Image, labels: Index, number: int, inside: Array, outside: Array, model: str = "") -> Work:
    """Correct the object of a label by points; all others stay as they are.

    Parameters
    ----------
    image : Image
        Image or volume.
    labels : ndarray of int, shape (H, W) or (P, H, W)
        Labels, 0 for none.
    number : int
        Label of the object.
    inside, outside : ndarray, shape (N, D)
        Positive and negative points (row, col) [px] or (plane, row, col) [voxels].
    model : str
        The larger model that answers in place of the network.

    Yields
    ------
    tuple
        Progress.

    Returns
    -------
    ndarray of int
        Labels, in the shape of `labels`.

    Raises
    ------
    ValueError
        When no pixel has the label.
    """
    partition: Any = partition_without_run(image, model=model)
    mask = labels == number
    pixels = np.argwhere(mask).astype(float)
    if not len(pixels):
        raise ValueError(f"No pixel has the label {number}: select the label of the object to correct in its layer.")
    yield f"Label {number}", None
    middle = pixels[[np.linalg.norm(pixels - pixels.mean(axis=0), axis=1).argmin()]]
    if image.ndim == 2:
        previous = partition.build_selection(mask, middle)
    else:
        surface = surface_from_labels(mask.astype(np.int32), image.spacing, image.unit)
        previous = partition.build_selection(Region(surface=surface), middle)
    better = partition.select(np.concatenate([middle, inside]), outside, previous=previous).mask
    return np.where(better & ((labels == 0) | mask), number, np.where(mask, 0, labels))


def run_from_seeds(image: cpm.Image, seeds: Array, parameters: Callable[[], cpm.Parameters]) -> Work:
    """Run from seeds (N, D) to the objects that the run proposes; each step takes the parameters of its moment.

    Yields the progress from time to time, and returns a `Result`: that of the run itself where it proposes nothing.
    """
    states, reported = cpm.evolve(image, seeds, parameters()), 0.0
    for state in states:
        states.parameters = parameters()
        if time.monotonic() - reported > _REPORT_INTERVAL:
            yield f"Step {state.step}, {state.count} particles", state.position
            reported = time.monotonic()
    yield "Objects", states.moment.position
    found = states.result
    return replace_by_objects(found, found.objects) if found.objects else found


def collect_drawn_seeds(drawn: Sequence[cpm.Contour], labels: Index | None) -> Array:
    """Return seeds (N, D) along drawn lines, and along the boundaries of labels.

    `labels` have shape (H, W) or (P, H, W). ValueError when there are neither.
    """
    seeds = [start.seeds() for start in starts_from_contours(drawn)]
    if labels is not None:
        boundaries = skimage.segmentation.find_boundaries(labels, mode="inner")  # type: ignore[no-untyped-call]
        seeds.append(np.argwhere(boundaries)[::2].astype(float))
    if not seeds:
        raise ValueError("Draw a shape in or around an object, or choose labels: particles start along them.")
    return np.concatenate(seeds)
