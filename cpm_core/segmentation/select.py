"""Objects of an image: what they are selected from, and one or all of them at once."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.image.image import Image, as_image
from cpm_core.model.starts import uniform_grid
from cpm_core.model.volume.starts import seeds_everywhere
from cpm_core.numerics.real_numbers import as_positions, check_finite_number
from cpm_core.objects.all_bodies import find_bodies_everywhere
from cpm_core.objects.all_objects import find_objects_everywhere
from cpm_core.objects.partition import Partition, partition_without_run
from cpm_core.objects.prior.larger_models import check_model
from cpm_core.objects.selection import Selection
from cpm_core.objects.similar_objects import find_similar_objects
from cpm_core.objects.volume_partition import VolumePartition, require_image
from cpm_core.parameters import PRESETS, Parameters, choose_parameters
from cpm_core.parameters.formatting import quote_value
from cpm_core.results.result import Result
from cpm_core.segmentation.evolve import segment

EVERYWHERE_PARAMETERS = Parameters(smoothing=1.5)
"""Parameters of the run from everywhere whose contours guide outlines: they follow even the faintest edges."""


def partition(
    values: ArrayLike | Image | Result, parameters: Parameters | str | None = None, *, model: str = ""
) -> Partition | VolumePartition:
    """Prepare an image with its contours, or a volume with the bodies of its surface, to select objects from.

    Parameters
    ----------
    values : array_like, shape (H, W) or (P, H, W), or Image, or Result
        An image, in which a run from everywhere finds the contours; a volume, which needs no run; or the result of a
        run.
    parameters : Parameters or str, optional
        Parameters of the run on an image. Unless they are given, contours follow even the faintest edges, and outlines
        with them.
    model : str, optional
        The larger model that answers prompts on an image in place of the network: one of `MODELS`, once `fetch_model`
        has fetched it, or a folder with the ONNX files of an encoder and a decoder. In a volume the address of a server
        of nnInteractive, ``"http://..."``, which gets the volume and the points.

    Returns
    -------
    Partition or VolumePartition
        To select objects from.

    Raises
    ------
    ValueError
        For an unusable image, a result that does not know its image, or a model that cannot be used.

    Examples
    --------
    >>> partition = cpm.partition(cpm.example("disks"))
    >>> partition.select([(32, 18)])
    <Selection 301 px, 1 contour, 0 gaps, 92 % sure>
    """
    image = require_image(values) if isinstance(values, Result) else as_image(values)
    check_model(model, image.ndim)
    if isinstance(values, Result):
        return Partition.from_result(values, model) if image.ndim == 2 else VolumePartition.from_result(values, model)
    if image.ndim == 3:
        return VolumePartition(image, model=model)
    given = EVERYWHERE_PARAMETERS if parameters is None else parameters
    return Partition.from_result(_run_everywhere(image, given), model)


def _run_everywhere(image: Image, parameters: Parameters | str | None = None) -> Result:
    """Run from everywhere in an image or a volume, by the preset for that unless parameters are given."""
    seeds, preset = (uniform_grid(image.shape), "automatic") if image.ndim == 2 else (seeds_everywhere(image), "volume")
    return segment(image, seeds, choose_parameters(parameters, PRESETS[preset]))


def select(
    values: ArrayLike | Image,
    inside: ArrayLike = (),
    outside: ArrayLike = (),
    *,
    start: ArrayLike = (),
    box: ArrayLike = (),
    stroke: ArrayLike = (),
    previous: Selection | None = None,
    prior: bool = True,
    model: str = "",
) -> Selection:
    """Select an object of an image at once, without a run of the particles before.

    Parameters
    ----------
    values : array_like, shape (H, W), or Image
        Image.
    inside, outside, box, stroke, previous
        As for `Partition.select`.
    start : array_like, shape (N, 2)
        A closed line in the object, such as the seeds of a circle; `inside` adds further points to it.
    prior : bool
        Whether the network answers. Without it, particles find the contours of the whole image first, which takes about
        a second, and what they enclose is selected.
    model : str
        The larger model that answers in place of the network, as for `partition`.

    Returns
    -------
    Selection
        The object.

    Examples
    --------
    >>> cpm.select(cpm.example("disks"), [(32, 18)]).contains(np.array([(32.0, 18.0), (32.0, 46.0)])).tolist()
    [True, False]
    """
    check_model(model, ndim=2)
    image = as_image(values)
    if image.ndim == 3:
        raise ValueError("select is for images: in a volume, use partition(volume).select with the same points.")
    if prior:
        cut = Partition(image, (), model=model)
    else:
        cut = replace(Partition.from_result(_run_everywhere(image, EVERYWHERE_PARAMETERS)), uses_network=False)
    places = np.concatenate([as_positions(given, 2) for given in (start, inside)])
    return cut.select(places, outside, stroke=stroke, box=box, previous=previous)


def select_all(
    values: ArrayLike | Image | Result | Partition | VolumePartition,
    like: Sequence[Selection] = (),
    *,
    parameters: Parameters | str | None = None,
    min_confidence: float = 0.0,
) -> tuple[Selection, ...]:
    """Select all objects of an image or a volume, or all that are similar to some.

    Parameters
    ----------
    values : array_like, shape (H, W) or (P, H, W), or Image, or Result, or Partition, or VolumePartition
        An image or a volume, in which a run from everywhere finds contours or a surface; the result of a run, whose
        `Result.objects` are selected; or a partition, with the contours that it has.
    like : sequence of Selection
        Some of them. Without any, the network evaluates what contours bound, alone, together or with gaps: the likely
        objects are selected; in a volume the bodies that the surface encloses, split at necks.
    parameters : Parameters or str, optional
        Parameters of the run from everywhere, else the preset ``"automatic"``, or ``"volume"``, as in the window.
    min_confidence : float
        Least `Selection.confidence` of an object, from 0 to 1.

    Returns
    -------
    tuple of Selection
        The objects, given ones first, otherwise the best. None overlap, except objects in objects, such as a nucleus
        in a cell.

    Examples
    --------
    >>> image = cpm.example("disks")
    >>> len(cpm.select_all(image, [cpm.select(image, [(32, 18)])])), len(cpm.select_all(image))
    (2, 2)
    """
    check_finite_number("min_confidence", min_confidence, lambda share: 0.0 <= share <= 1.0, "from 0 to 1")
    if not isinstance(like, Sequence) or not all(isinstance(one, Selection) for one in like):
        raise ValueError(f"like is {quote_value(like)} but must be a list of selections.")
    if not like:
        if isinstance(values, Partition):
            all_objects: Iterable[Selection] = find_objects_everywhere(values)
        elif isinstance(values, VolumePartition):
            all_objects = find_bodies_everywhere(values)
        else:
            result = values if isinstance(values, Result) else _run_everywhere(as_image(values), parameters)
            all_objects = result.objects
        return tuple(one for one in all_objects if not one.confidence < min_confidence)
    if isinstance(values, Partition | VolumePartition):
        cut = values
    else:
        cut = partition(values) if isinstance(values, Result) else partition_without_run(as_image(values))
    found = list(like)
    for one in like:
        for other in find_similar_objects(cut, one):
            if other.confidence >= min_confidence and not any(other.region.count_shared(each.region) for each in found):
                found.append(other)
    return tuple(found)
