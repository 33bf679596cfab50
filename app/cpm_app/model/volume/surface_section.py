"""Cuts of surfaces, objects (painted ones too) and center lines by a slice."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache

import numpy as np
import scipy
import skimage

from cpm_app.model.volume.slices import Slice
from cpm_core import Contour, Selection, Skeleton, Surface
from cpm_core.contours import slice_surface
from cpm_core.image.region import Region
from cpm_core.numerics import Array, polyline
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
def cut_region(region: Region, here: Slice) -> tuple[Line, ...]:
    """Return the closed lines in which a slice cuts a region; around voxels they run halfway to their neighbors."""
    return tuple(_iterate_boundary_lines(region, here))


def _iterate_boundary_lines(region: Region, here: Slice) -> Iterable[Line]:
    if region.surface is None:
        window = list(region.window)
        window[here.axis] = slice(here.index, here.index + 1)
        pixels = np.pad(replace(here, index=0).slice_array(region.cut_out(tuple(window))), 1)
        begin = np.array(here.drop_axis(region.origin)) - 1.0
        curves = skimage.measure.find_contours(pixels.astype(np.float32), 0.5)  # type: ignore[no-untyped-call]
        for curve in curves:
            yield as_line(curve[:-1] + begin)
    else:
        for contour in _cut_into_closed_lines(region.surface, here):
            line = as_line(contour.points)
            if len(set(line)) > 2:
                yield line


def cut_objects(objects: SegmentedObjects, here: Slice) -> SegmentedObjects:
    """Cut objects by a slice, as objects of an image, with the clicks near it."""
    items = tuple(cut for item in objects.items if (cut := _cut_object(item, here)) is not None)
    edited = objects.edited if any(item.number == objects.edited for item in items) else 0
    return replace(objects, items=items, clicks=select_near_clicks(objects.clicks, here), edited=edited)


def _cut_object(item: SegmentedObject, here: Slice) -> SegmentedObject | None:
    boundary = cut_region(item.region, here)
    return replace(item, clicks=(), region=Region(boundary)) if boundary else None


def select_near_clicks(clicks: Clicks, here: Slice) -> Clicks:
    """Select the clicks near a slice, as clicks in it."""
    near = []
    for click in clicks:
        places = tuple(here.drop_axis(at) for at in click.places if abs(at[here.axis] - here.index) <= _CLICK_DISTANCE)
        if places:
            near.append(replace(click, places=places))
    return tuple(near)


def cut_selection(selection: Selection, here: Slice) -> Selection:
    """Cut a selection by a slice: only its boundary and its confidence are given."""
    nowhere = np.empty((0, 2))
    lines = () if selection.surface is None else _cut_into_closed_lines(selection.surface, here)
    boundary, shape = Region(tuple(as_line(line.points) for line in lines)), here.drop_axis(selection.shape)
    return Selection(boundary, shape, nowhere, nowhere, lines, confidence=selection.confidence)


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
