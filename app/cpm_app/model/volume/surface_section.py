"""Cuts of surfaces, objects (painted ones too) and center lines by a slice."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache

import numpy as np
import scipy
import skimage

from cpm_app.model.document.objects import AnySelection
from cpm_app.model.volume.slices import Slice
from cpm_core import Contour, Selection, Skeleton, Surface, VolumeSelection
from cpm_core.contours import PackedBody, PackedVoxels, slice_surface
from cpm_core.numerics import Array, Place, polyline
from cpm_core.numerics.polyline import as_line
from cpm_core.numerics.types import Line
from cpm_core.objects.segmented import SegmentedObject, SegmentedObjects
from cpm_core.objects.segmented.segmented_object import Clicks

_CACHED_SURFACE_CUTS = 32
"""Number of cuts of surfaces that are cached, as every move of the pointer needs them again."""

_CACHED_BODY_CUTS = 256
"""Number of cuts of objects that are cached: an edit leaves the cuts of other objects valid."""


@lru_cache(maxsize=_CACHED_SURFACE_CUTS)
def cut_surface(surface: Surface, cut: Slice) -> tuple[Contour, ...]:
    """Cut a surface by a slice: closed contours in the slice, and open ones where the surface has a rim."""
    lines = slice_surface(surface, cut.axis, cut.index)
    return tuple(replace(line, points=line.points[:, ::-1]) for line in lines) if cut.transposed else lines


_CLICK_DISTANCE = 1.0
"""Largest distance of a click that a slice shows [voxels]."""


def _cut_into_closed_lines(surface: Surface, here: Slice) -> tuple[Contour, ...]:
    """Return the closed lines in which a slice cuts a surface."""
    return tuple(each for each in cut_surface(surface, here) if each.closed and len(each.points) > 2)


@lru_cache(maxsize=_CACHED_BODY_CUTS)
def cut_body(body: PackedBody, here: Slice) -> tuple[Line, ...]:
    """Return the closed lines in which a slice cuts a body; around voxels they run halfway to their neighbors."""
    return tuple(_iterate_boundary_lines(body, here))


def _iterate_boundary_lines(body: PackedBody, here: Slice) -> Iterable[Line]:
    if isinstance(body, PackedVoxels):
        first, shape = [*body.first], [*body.shape]
        first[here.axis], shape[here.axis] = here.index, 1
        pixels = np.pad(replace(here, index=0).slice_array(body.mask_in_box(first, shape)), 1)
        begin = np.array(here.drop_axis(tuple(first))) - 1.0
        curves = skimage.measure.find_contours(pixels.astype(np.float32), 0.5)  # type: ignore[no-untyped-call]
        for curve in curves:
            yield as_line(curve[:-1] + begin)
    else:
        for contour in _cut_into_closed_lines(body.surface, here):
            line = as_line(contour.points)
            if len(set(line)) > 2:
                yield line


def cut_objects(objects: SegmentedObjects, here: Slice) -> SegmentedObjects:
    """Cut objects by a slice, as objects of an image, with the clicks near it."""
    items = tuple(cut for item in objects.items if (cut := _cut_object(item, here)) is not None)
    edited = objects.edited if any(item.number == objects.edited for item in items) else 0
    return replace(objects, items=items, clicks=select_near_clicks(objects.clicks, here), edited=edited)


def _cut_object(item: SegmentedObject, here: Slice) -> SegmentedObject | None:
    boundary = cut_body(item.surface[0], here) if item.surface else ()
    return replace(item, clicks=(), boundary=boundary, surface=()) if boundary else None


def select_near_clicks(clicks: Clicks, here: Slice) -> Clicks:
    """Select the clicks near a slice, as clicks in it."""
    near = []
    for click in clicks:
        places = tuple(here.drop_axis(at) for at in click.places if abs(at[here.axis] - here.index) <= _CLICK_DISTANCE)
        if places:
            near.append(replace(click, places=places))
    return tuple(near)


def cut_selection(selection: AnySelection, here: Slice) -> Selection:
    """Cut a selection by a slice: only its boundary is given."""
    nowhere = np.empty((0, 2))
    lines = _cut_into_closed_lines(selection.surface, here) if isinstance(selection, VolumeSelection) else ()
    return Selection(np.zeros((0, 0), bool), lines, (), 1.0, nowhere, nowhere)


def object_contains(item: SegmentedObject, place: Place) -> bool:
    """Tell whether a position (row, col) [px], or (plane, row, col), lies in an object."""
    if len(place) == 2:
        return bool(item.encloses(np.array([place], float))[0])
    if any(isinstance(body, PackedVoxels) for body in item.surface):
        return bool(item.surface[0].mask_in_box([round(at) for at in place], (1, 1, 1)).all())
    here = Slice(0, round(place[0]))
    within = np.array([here.drop_axis(place)], float)
    lines = cut_body(item.surface[0], here) if item.surface else ()
    return bool(sum(bool(polyline.points_inside(line, within)[0]) for line in lines) % 2)


def object_size(item: SegmentedObject) -> float:
    """Return the volume of an object, in the unit of its image; the area [px²] in a plane."""
    return item.surface[0].volume if item.surface else item.area


_CENTERLINE_DISTANCE = 1.5
"""Largest distance of center lines that a slice shows [voxels]."""


def cut_skeleton(found: Skeleton, here: Slice) -> Skeleton:
    """Return the pieces of center lines near a slice, as the skeleton of an image."""
    pieces = [
        piece
        for contour, radii in zip(found.contours, found.radii, strict=True)
        for piece in _find_near_stretches(contour.path, np.append(radii, radii[0]) if contour.closed else radii, here)
    ]
    return replace(
        Skeleton((), (), here.drop_axis(found.shape), here.drop_axis(found.spacing), found.unit, found.source),
        contours=tuple(Contour(points, False) for points, _ in pieces),
        radii=tuple(radii for _, radii in pieces),
    )


def _find_near_stretches(path: Array, radii: Array, here: Slice) -> list[tuple[Array, Array]]:
    """Return the stretches of a line near a slice, projected onto it, with the vertices before and after."""
    near = np.abs(path[:, here.axis] - here.index) <= _CENTERLINE_DISTANCE
    found = []
    for run in polyline.find_marked_runs(scipy.ndimage.binary_dilation(near)):
        flat = here.project_points(path[run])
        distinct = np.append(True, (np.diff(flat, axis=0) != 0.0).any(axis=1))
        if distinct.sum() > 1:
            found.append((flat[distinct], radii[run][distinct]))
    return found
