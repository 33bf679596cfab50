"""Edits: pure functions from a document to the next one, and hit testing of shapes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import field, replace
from typing import Literal

import numpy as np

from cpm_app.model.document.document import Document
from cpm_app.model.parameters import controls
from cpm_core import Parameters
from cpm_core.numerics import Array, Place, Position, check_voxel_sides, polyline
from cpm_core.numerics.types import Sides, frozen
from cpm_core.shapes import Everywhere, Points, SeedingKind, Shape


def add_shape(document: Document, shape: Shape) -> Document:
    """Add a shape, drawn last."""
    return replace(document, shapes=(*document.shapes, shape))


def replace_shape(document: Document, index: int, shape: Shape) -> Document:
    """Replace the shape at `index`."""
    shapes = list(document.shapes)
    shapes[index] = shape
    return replace(document, shapes=tuple(shapes))


def move_shape(document: Document, index: int, offset: Place) -> Document:
    """Move the shape at `index` by an offset along each axis."""
    return replace_shape(document, index, document.shapes[index].translated(offset))


def delete_shape(document: Document, index: int) -> Document:
    """Delete the shape at `index`."""
    return replace(document, shapes=document.shapes[:index] + document.shapes[index + 1 :])


def toggle_everywhere(document: Document, kind: SeedingKind) -> Document:
    """Add this start all over the image, or remove it where it is there."""
    start = Everywhere(kind)
    if start in document.shapes:
        return delete_shape(document, document.shapes.index(start))
    return add_shape(document, start)


def erase_shapes(document: Document, path: Sequence[Place], radius: float) -> Document:
    """Erase what lies within `radius` of an eraser's path [px].

    Points are erased one by one, and other shapes as a whole. In a volume the radius is in sides of the smallest voxel.
    """
    spacing = document.image.spacing if document.image is not None and len(path[0]) == 3 else (1.0,)
    left = [_erase_from_shape(shape, path, radius, np.array(spacing) / min(spacing)) for shape in document.shapes]
    return replace(document, shapes=tuple(shape for shape in left if shape is not None))


def _erase_from_shape(shape: Shape, path: Sequence[Place], radius: float, sides: Array) -> Shape | None:
    """Return what erasing leaves of a shape; None if nothing."""
    if isinstance(shape, Points):
        near = polyline.distances_to_path(np.array(path) * sides, shape.seeds() * sides) <= radius
        if not near.any():
            return shape
        left = tuple(point for point, gone in zip(shape.positions, near.tolist(), strict=True) if not gone)
        return Points(left) if left else None
    stops = polyline.resample_path(np.array(path, float), 0.5 * radius).tolist()
    return None if any(shape.distance_to(tuple(at)) <= radius for at in stops) else shape


def set_shapes(document: Document, shapes: tuple[Shape, ...]) -> Document:
    """Replace all shapes."""
    return replace(document, shapes=shapes)


def clear_shapes(document: Document) -> Document:
    """Remove all shapes."""
    return set_shapes(document, ())


def set_pixel_size(document: Document, spacing: Sides, unit: str | None, *, by_hand: bool = True) -> Document:
    """Set the size of a pixel by hand, or as the file gives it.

    ValueError when voxels are flatter than can be computed.
    """
    if document.image is None:
        return document
    if by_hand and len(spacing) == 3:
        check_voxel_sides("The size of a voxel", spacing)
    own = {"spacing": spacing, "unit": unit} if by_hand else {"spacing": None, "unit": None}
    reading = replace(document.image.reading, **own)
    return replace(document, image=replace(document.image, spacing=spacing, unit=unit, reading=reading))


def set_parameter(document: Document, name: str, value: float | str) -> Document:
    """Set one control; see `cpm_app.model.parameters.controls.set_control_value`."""
    return replace(document, parameters=controls.set_control_value(document.parameters, name, value))


def apply_preset(document: Document, parameters: Parameters) -> Document:
    """Set the parameters of a preset; the channel stays, because it belongs to the image."""
    return set_parameters(document, replace(parameters, channel=document.parameters.channel))


def set_parameters(document: Document, parameters: Parameters) -> Document:
    """Replace all parameters, with no more scales than the image has room for."""
    return replace(document, parameters=document.fit_scales(parameters))


HitPart = Literal["handle", "body"]


@frozen
class ShapeHit:
    """Index of the shape that was hit, and its part: the handle at a place reshapes it, the body moves it."""

    index: int
    part: HitPart
    handle: Position | None = field(default=None, compare=False)


def find_shape_at(
    shapes: tuple[Shape, ...], position: Position, tolerance: float, selected: int | None = None
) -> ShapeHit | None:
    """Find the shape under a position (row, col) [px of the image]: first the selected one, then the last drawn.

    `tolerance` is the distance up to which a line, handle or point is hit [px of the image]. Only the selected shape
    shows handles.
    """
    handles = shapes[selected].handles() if selected is not None and selected < len(shapes) else ()
    near = min(handles, key=lambda handle: math.dist(handle, position), default=None)
    if selected is not None and near is not None and math.dist(near, position) <= tolerance:
        return ShapeHit(selected, "handle", near)
    front_first = sorted(range(len(shapes)), key=lambda index: (index != selected, -index))
    under = [index for index in front_first if shapes[index].distance_to(position) <= tolerance]
    under += [index for index in front_first if shapes[index].encloses(position)]
    return ShapeHit(under[0], "body") if under else None
