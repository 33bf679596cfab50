"""What can be written besides the result of a run: selections, contours, surfaces and labels, each as a result."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpm_core.contours.contour import Contour
from cpm_core.contours.ground_truth import MAX_LABEL
from cpm_core.contours.surface import surface_from_labels
from cpm_core.formats.common.provenance import Outcome
from cpm_core.formats.contours.mask import find_label_outlines
from cpm_core.image.image import Image
from cpm_core.image.surface import Surface
from cpm_core.medial_axis.centerlines import Centerlines
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.numerics.types import Extent, copy_with
from cpm_core.objects import Selection
from cpm_core.parameters.formatting import quote_value
from cpm_core.parameters.provenance import Provenance
from cpm_core.results import boundaries_in_image, boundaries_result, objects_result
from cpm_core.results.result import Result

Exportable = Outcome | Centerlines | Selection | Surface | Sequence[Selection] | Sequence[Contour] | NDArray[np.integer]
"""Everything that can be exported."""


def as_result(given: Exportable, image: Image | None = None) -> Outcome | Centerlines:
    """Return what is to be written as a result, in an image where one is known; ValueError if it cannot be written.

    Contours and a surface without an image have one that just holds them, in px.
    """
    if isinstance(given, Result | Skeleton | Centerlines):
        return given
    if isinstance(given, np.ndarray):
        return _result_of_labels(given, image)
    if isinstance(given, Surface):
        shape = _shape_around(given.vertices) if image is None else image.shape
        found = _result_in(image, shape, "surface", surface=given)
        return replace(found, spacing=given.spacing, unit=given.unit)
    several: Any = [given] if isinstance(given, Selection | Contour) else given
    if isinstance(several, Sequence) and len(several):
        if all(isinstance(one, Selection) for one in several):
            return objects_result(several, image)
        if all(isinstance(one, Contour) and one.points.shape[1] == 2 for one in several):
            shape = _shape_around(np.concatenate([one.points for one in several])) if image is None else image.shape
            return _result_in(image, shape, "contours", contours=tuple(several))
    raise ValueError(
        f"{quote_value(given)} cannot be exported: give a result, selections or contours of an image, a surface, or "
        "an array of labels."
    )


def _result_of_labels(given: NDArray[Any], image: Image | None) -> Result:
    """Return the objects of labels, shape (H, W) or (P, H, W), which stay as they are in label masks."""
    if given.dtype.kind not in "bui" or given.ndim not in (2, 3) or not given.size:
        raise ValueError(
            f"the array holds values of type {given.dtype} in the shape {given.shape}, but labels are whole numbers in "
            "that of an image or a volume."
        )
    if image is not None and image.shape != given.shape:
        raise ValueError(f"the labels have the shape {given.shape}, but {image.source} has {image.shape}.")
    if given.min() < 0 or given.max() > MAX_LABEL:
        raise ValueError(f"the labels are {given.min()} to {given.max()}, but must be 0 outside and up to {MAX_LABEL}.")
    labels = given.astype(np.int32)
    found = _result_in(image, given.shape, "labels")
    if labels.ndim == 3:
        return copy_with(found, surface=surface_from_labels(labels, found.spacing, found.unit), labels=labels)
    contours = tuple(
        Contour(points, True, group=number, hole=hole)
        for number, outlines in find_label_outlines(labels)
        for points, hole in outlines
    )
    return copy_with(found, contours=contours, labels=labels)


def _result_in(image: Image | None, shape: Extent, source: str, **found: Any) -> Result:
    """Return what was found in an image, or in one of a shape whose pixels have no known size, as a result."""
    if image is None:
        return boundaries_result(shape, source, **found)
    return boundaries_in_image(image, Provenance(), **found)


def _shape_around(places: NDArray[np.float64]) -> Extent:
    """Return the shape of an image that just holds some places, shape (N, D) [px]."""
    return tuple((np.ceil(places.max(axis=0, initial=0.0)).astype(int) + 1).tolist())
