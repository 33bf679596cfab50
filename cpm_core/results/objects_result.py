"""Objects as a result, for everything that takes one: writers, measurements, comparison."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cpm_core.contours.contour import Bridge
from cpm_core.contours.surface import join_surfaces
from cpm_core.image.image import Image
from cpm_core.image.surface import Label
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array, Extent, Sides
from cpm_core.objects.outline import measure_strengths
from cpm_core.objects.segmented import SegmentedObjects, class_label, object_label, selection_from_object
from cpm_core.objects.selection import Selection
from cpm_core.objects.volume_partition import require_image
from cpm_core.parameters.formatting import quote_value
from cpm_core.parameters.provenance import Provenance
from cpm_core.results.result import Result


def objects_result(
    selections: Sequence[Selection],
    image: Image | None = None,
    names: Sequence[str] = (),
    channel: str = "luminance",
) -> Result:
    """Make a result whose contours, or whose surface, are the boundaries of objects.

    Parameters
    ----------
    selections : sequence of Selection
        Objects in one image, or bodies in one volume.
    image : Image, optional
        The image; by default that of the selections.
    names : sequence of str, optional
        Name of each object; ``"object 1"``, ``"object 2"`` and so on by default. Bodies have numbers only.
    channel : str, optional
        Channel of a color image whose edges the objects follow.

    Returns
    -------
    Result
        All contours of an object share its number as their `Contour.group`, and all triangles of a body have it in
        `Surface.numbers`, so that labels have one number for each object and none in its holes. Gaps are the
        `bridges`.

    Raises
    ------
    ValueError
        When no image is known, an object was selected in an image with other axes, or `names` are not texts, or not one
        for each object.

    Examples
    --------
    >>> image = cpm.example("disks")
    >>> chosen = cpm.partition(image).select([(32, 18)])
    >>> cpm.objects_result([chosen], names=["left"]).contours[0].name
    'left'
    >>> body = cpm.partition(cpm.example("ball")).select([(15, 15, 15)])
    >>> cpm.objects_result([body]).labels.max(), cpm.objects_result([body]).table()["label"]
    (np.int32(1), array([1]))
    """
    if isinstance(names, str) or not isinstance(names, Sequence) or not all(isinstance(name, str) for name in names):
        raise ValueError(
            f"names is {quote_value(names)} but must be a list of names, one for each object, or left out."
        )
    if names and len(names) != len(selections):
        raise ValueError(f"there are {len(names)} names for {len(selections)} objects: give one for each.")
    image = image or next((one.image for one in selections if one.image is not None), None)
    if image is None:
        raise ValueError("no image is known for the objects: name it, or select objects of an image.")
    if not all(len(one.shape) == image.ndim for one in selections):
        raise ValueError(f"{image.source} has {image.ndim} axes: give objects that were selected in such an image.")
    titles = enumerate(names or [""] * len(selections), start=1)
    labels = [Label(number, object_label(number, name), category=class_label(1)) for number, name in titles]
    return _build_image_result(selections, labels, image, channel)


def _build_image_result(selections: Sequence[Selection], labels: Sequence[Label], image: Image, channel: str) -> Result:
    """Build the result of objects in an image that is known, with the label of each."""
    gaps = [gap for one in selections for gap in one.gaps]
    taken = image.resolve_channel(channel)
    clicks = tuple(
        {"shape": "object", "inside": selection.inside.tolist(), "outside": selection.outside.tolist()}
        for selection in selections
    )
    nothing = boundaries_in_image(image, Provenance("objects", {"channel": taken}, shapes=clicks), channel=taken)
    return replace(_join_objects(nothing, selections, labels), bridges=tuple(_measure_gaps(gaps, image, channel)))


def _join_objects(nothing: Result, selections: Sequence[Selection], labels: Sequence[Label]) -> Result:
    """Add objects, each with its label, to a result that has none.

    The contours of an object have its number as their group, and holes are marked, so that a label mask has one label
    for it and none in its holes. Gaps become bridges of strength 0, as theirs is unknown. The provenance names the
    larger models that answered.
    """
    parts = [
        (replace(to, confidence=float(one.confidence) if one.confidence > 0.0 else None), one)
        for to, one in zip(labels, selections, strict=True)
    ]
    contours = (
        replace(
            line,
            group=to.number,
            name=to.name,
            color=to.color,
            category=to.category,
            confidence=to.confidence,
        )
        for to, one in parts
        for line in one.contours
    )
    bodies, surface = [(to, one.surface) for to, one in parts if one.surface is not None], None
    if bodies:
        joined = join_surfaces([(to.number, body) for to, body in bodies], nothing.spacing, nothing.unit)
        surface = replace(joined, labels=tuple(to for to, _ in bodies))
    bridges = tuple(Bridge(gap, polyline.path_length(gap), 0.0) for one in selections for gap in one.gaps)
    models = ", ".join(sorted({one.model for one in selections if one.model}))
    made = replace(nothing.provenance, model=models)
    return replace(nothing, contours=tuple(contours), bridges=bridges, surface=surface, provenance=made)


def add_segmented_objects(
    nothing: Result, objects: SegmentedObjects, only: Container[int] | None = None
) -> Result | None:
    """Add the objects of a session, or those with some numbers, to a result without any, with class, name and color.

    Hidden objects are left out; None when no other remains.
    """
    shown = [item for item in objects.items if not item.hidden and (only is None or item.number in only)]
    labels = []
    for item in shown:
        class_name = objects.classes[item.category - 1].name
        title = object_label(item.number, item.name, class_name)
        labels.append(Label(item.number, title, objects.color_of(item), class_label(item.category, class_name)))
    selections = [selection_from_object(item, nothing.shape) for item in shown]
    return _join_objects(nothing, selections, labels) if shown else None


def _measure_gaps(gaps: Sequence[Array], image: Image, channel: str) -> list[Bridge]:
    """Measure the gaps of outlines, each of shape (K, 2) [px], in their image."""
    strengths = measure_strengths(image.gray_levels(channel), gaps)
    return [Bridge(gap, polyline.path_length(gap), mean) for gap, mean in zip(gaps, strengths, strict=True)]


def replace_by_objects(
    result: Result,
    selections: Sequence[Selection],
    known: SegmentedObjects | None = None,
) -> Result:
    """Replace what a run found by objects selected from it; the provenance is that of the run, with the objects.

    They are of the class that the next of the `known` objects gets, by default of one without a color.
    """
    name, color, category = "", "", 1
    if known is not None:
        category = known.category
        name, color = known.classes[category - 1].name, known.classes[category - 1].color
    labels = [
        Label(number, object_label(number, class_name=name), color, class_label(category, name))
        for number in range(1, len(selections) + 1)
    ]
    found = _build_image_result(selections, labels, require_image(result), result.channel)
    drawn = (*result.provenance.shapes, *found.provenance.shapes)
    made = replace(result.provenance, method="objects", shapes=drawn, model=found.provenance.model)
    return replace(found, provenance=made)


def boundaries_in_image(image: Image, made: Provenance, **found: Any) -> Result:
    """Build the result of `boundaries_result` in an image, whose hash is added to the provenance."""
    known = replace(made, sha256=image.sha256, of_file=bool(image.file_sha256))
    place = image.shape, image.source, image.spacing, image.unit
    return boundaries_result(*place, image=image, provenance=known, **found)


def boundaries_result(
    shape: Extent, source: str, spacing: Sides | None = None, unit: str | None = None, **found: Any
) -> Result:
    """Build a result of no run, in an image of a shape: boundaries of objects, and what else is found, by name."""
    sides = spacing or (1.0,) * len(shape)
    reason = "the objects have been selected"
    return replace(Result(np.empty((0, len(shape))), (), None, 0, True, reason, shape, sides, unit, source), **found)
