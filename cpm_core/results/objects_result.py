"""Objects as a result, for everything that takes one: writers, measurements, comparison."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cpm_core.contours.contour import Bridge, Contour
from cpm_core.contours.surface import join_surfaces
from cpm_core.field.edge_map import edge_map
from cpm_core.field.interpolation import interpolate_field
from cpm_core.image.image import Image
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array, Extent, Sides
from cpm_core.objects.outline import OBJECT_SMOOTHING
from cpm_core.objects.selection import Selection
from cpm_core.objects.volume_partition import VolumeSelection, require_image
from cpm_core.parameters.formatting import quote_value
from cpm_core.parameters.provenance import Provenance
from cpm_core.results.result import Result


def objects_result(
    selections: Sequence[Selection | VolumeSelection],
    image: Image,
    names: Sequence[str] = (),
    channel: str = "luminance",
) -> Result:
    """Make a result whose contours are the boundaries of objects, or whose surface is that of bodies.

    Parameters
    ----------
    selections : sequence of Selection, or of VolumeSelection
        Objects in one image, or bodies in one volume.
    image : Image
        The image, or the volume.
    names : sequence of str, optional
        Name of each object; ``"object 1"``, ``"object 2"`` and so on by default. Bodies have numbers only.
    channel : str, optional
        Channel of a color image whose edges the objects follow.

    Returns
    -------
    Result
        All contours of an object share its number as their `Contour.group`, so that label masks have one label for each
        object and none in its holes. Its gaps are the `bridges`. Each body has its own label as well.

    Raises
    ------
    ValueError
        When `names` are not texts, or not one for each object.

    Examples
    --------
    >>> image = cpm.example("disks")
    >>> chosen = cpm.partition(image).select([(32, 18)])
    >>> cpm.objects_result([chosen], image, ["left"]).contours[0].name
    'left'
    """
    if isinstance(names, str) or not isinstance(names, Sequence) or not all(isinstance(name, str) for name in names):
        raise ValueError(
            f"names is {quote_value(names)} but must be a list of names, one for each object, or left out."
        )
    if names and len(names) != len(selections):
        raise ValueError(f"there are {len(names)} names for {len(selections)} objects: give one for each.")
    place = (image.shape, image.spacing, image.unit, image.source)
    clicks = tuple(
        {"shape": "object", "inside": selection.inside.tolist(), "outside": selection.outside.tolist()}
        for selection in selections
    )
    taken = image.resolve_channel(channel)
    made = Provenance(
        "objects", {"channel": taken}, shapes=clicks, sha256=image.sha256, of_file=bool(image.file_sha256)
    )
    if image.ndim == 3:
        bodies = [(at, one.surface) for at, one in enumerate(selections, 1) if isinstance(one, VolumeSelection)]
        surface = join_surfaces(bodies, image.spacing, image.unit) if bodies else None
        found = replace(boundaries_result((), (), *place), surface=surface)
    else:
        objects = [one for one in selections if isinstance(one, Selection)]
        titles = names or [f"object {number}" for number in range(1, len(objects) + 1)]
        contours = [
            replace(contour, group=number, name=title)
            for number, (selection, title) in enumerate(zip(objects, titles, strict=True), start=1)
            for contour in selection.contours
        ]
        found = boundaries_result(contours, _measure_gaps(objects, image.gray_levels(channel)), *place)
    return replace(found, image=image, channel=taken, provenance=made)


def _measure_gaps(selections: Sequence[Selection], gray: Array) -> list[Bridge]:
    """Measure the length of the gaps of objects, and the edge strength along them."""
    strength = edge_map(gray, OBJECT_SMOOTHING)
    bridges = []
    for gap in (gap for selection in selections for gap in selection.gaps):
        mean = float(interpolate_field(strength[None], polyline.sample_path(gap, 1.0)).mean())
        bridges.append(Bridge(gap, polyline.path_length(gap), mean))
    return bridges


def replace_by_objects(result: Result, selections: Sequence[Selection | VolumeSelection]) -> Result:
    """Replace what a run found by objects selected from it; the provenance is that of the run, with the objects."""
    found = objects_result(selections, require_image(result), channel=result.channel)
    drawn = (*result.provenance.shapes, *found.provenance.shapes)
    return replace(found, provenance=replace(result.provenance, method="objects", shapes=drawn))


def boundaries_result(
    contours: Sequence[Contour],
    bridges: Sequence[Bridge],
    shape: Extent,
    spacing: Sides,
    unit: str | None,
    source: str,
) -> Result:
    """Build a result from the boundaries of objects and their gaps, in the image that the others describe."""
    return Result(
        np.empty((0, 2)),
        tuple(contours),
        None,
        0,
        True,
        "the objects have been selected",
        shape,
        spacing,
        unit,
        source,
        bridges=tuple(bridges),
    )
