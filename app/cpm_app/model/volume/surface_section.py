"""Cuts of surfaces, objects (painted ones too) and center lines by a slice."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy
import skimage

from cpm_app.model.volume.slices import Slice
from cpm_core import Contour, Selection, Skeleton, Surface
from cpm_core.contours import slice_surface
from cpm_core.image.region import Region
from cpm_core.numerics import Array, Mask, polyline
from cpm_core.numerics.grids import Window, enclose_windows, running_maximum
from cpm_core.numerics.polyline import as_line
from cpm_core.numerics.types import NO_POINTS, Line
from cpm_core.numerics.weak_cache import WeakCache
from cpm_core.objects.segmented import SegmentedObjects, boundary_from_polygon, polygon_from_boundary
from cpm_core.objects.segmented.segmented_object import Clicks

_SURFACE_CUTS = WeakCache[tuple[Contour, ...]](32)
"""Cuts of surfaces, as every move of the pointer needs them again."""

_BODY_CUTS = WeakCache[tuple[Line, ...]](256)
"""Cuts of objects: an edit leaves the cuts of other objects valid."""

_REACH = 2
"""Distance from painted voxels within which the boundary follows voxels [voxels]."""


def cut_surface(surface: Surface, cut: Slice) -> tuple[Contour, ...]:
    """Cut a surface by a slice: closed contours in the slice, and open ones where the surface has a rim."""
    return _SURFACE_CUTS.get(_cut_surface, surface, cut)


def _cut_surface(surface: Surface, cut: Slice) -> tuple[Contour, ...]:
    lines = slice_surface(surface, cut.axis, cut.index)
    return tuple(replace(line, points=line.points[:, ::-1]) for line in lines) if cut.transposed else lines


_CLICK_DISTANCE = 1.0
"""Largest distance of a click that a slice shows [voxels]."""


def _cut_into_closed_lines(surface: Surface, here: Slice) -> tuple[Contour, ...]:
    """Return the closed lines in which a slice cuts a surface."""
    return tuple(each for each in cut_surface(surface, here) if each.encloses_area)


def cut_region(region: Region, here: Slice) -> tuple[Line, ...]:
    """Return the closed lines in which a slice cuts a region; around voxels they run halfway to their neighbors.

    The lines of a surface are kept but near voxels that were painted.
    """
    return _BODY_CUTS.get(_cut_region, region, here)


def _cut_region(region: Region, here: Slice) -> tuple[Line, ...]:
    if region.surface is None:
        return _outline_pixels(*_cut_voxels(region, here))
    exact = tuple(as_line(contour.points) for contour in _cut_into_closed_lines(region.surface, here))
    exact = tuple(line for line in exact if len(set(line)) > 2)
    if region.pixels is None:
        return exact
    window = enclose_windows(region.window, region.unpainted.window)
    (before, begin), (after, _) = (_cut_voxels(one, here, window) for one in (region.unpainted, region))
    changed = before != after
    if not changed.any():
        return exact
    near: Mask = running_maximum(np.pad(changed, _REACH), _REACH)
    there = polygon_from_boundary(_outline_pixels(near, begin - _REACH))
    old, new = polygon_from_boundary(exact), polygon_from_boundary(_outline_pixels(after, begin))
    return boundary_from_polygon(old.difference(there).union(new.intersection(there)))


def _cut_voxels(region: Region, here: Slice, window: Window | None = None) -> tuple[Mask, Array]:
    """Return the pixels of a region in a slice, by default in its own box, and the first row and column."""
    box = list(window or region.window)
    box[here.axis] = slice(here.index, here.index + 1)
    pixels = replace(here, index=0).slice_array(region.cut_out(tuple(box)))
    return pixels, np.array(here.drop_axis(tuple(side.start for side in box)))


def _outline_pixels(pixels: Mask, begin: Array) -> tuple[Line, ...]:
    """Return the outlines of pixels that begin at a row and column."""
    padded = np.pad(pixels, 1).astype(np.float32)
    curves = skimage.measure.find_contours(padded, 0.5)  # type: ignore[no-untyped-call]
    return tuple(as_line(curve[:-1] + begin - 1.0) for curve in curves)


def cut_objects(objects: SegmentedObjects, here: Slice) -> SegmentedObjects:
    """Cut objects by a slice, as objects of an image, with the clicks near it."""
    cuts = ((item, cut_region(item.region, here)) for item in objects.items)
    items = tuple(replace(item, clicks=(), region=Region(boundary)) for item, boundary in cuts if boundary)
    edited = objects.edited if any(item.number == objects.edited for item in items) else 0
    return replace(objects, items=items, clicks=select_near_clicks(objects.clicks, here), edited=edited)


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
    lines = () if selection.surface is None else _cut_into_closed_lines(selection.surface, here)
    boundary, shape = Region(tuple(as_line(line.points) for line in lines)), here.drop_axis(selection.shape)
    return Selection(boundary, shape, NO_POINTS, NO_POINTS, lines, confidence=selection.confidence)


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
