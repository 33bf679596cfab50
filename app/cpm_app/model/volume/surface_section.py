"""The lines in which a slice cuts surfaces, objects, painted ones among them, and center lines."""

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
from cpm_core.contours import Measures, PackedBody, PackedVoxels, section_of
from cpm_core.numerics import Array, Place, polyline
from cpm_core.numerics.polyline import as_line
from cpm_core.numerics.types import Line
from cpm_core.objects.segmented import Click, SegmentedObject, SegmentedObjects

_MOST, _MOST_OF_OBJECTS = 32, 256
"""Cuts that are kept: they are asked for again whenever the pointer moves, an edit leaves those of other objects."""


@lru_cache(maxsize=_MOST)
def section(surface: Surface, cut: Slice) -> tuple[Contour, ...]:
    """Where a slice cuts a surface: closed contours in the slice, and open ones where the surface has a rim."""
    return section_of(surface, cut.axis, cut.index)


def unmeasured(contour: Contour, number: int) -> Measures:
    """Measures of a section, which is shown and not listed: only its number and length are known."""
    return Measures(
        number=number,
        label=0,
        name="",
        color="",
        closed=contour.closed,
        junctions=0,
        length=contour.length,
        area=0.0,
        strength=0.0,
        contrast=None,
        inside=0,
        length_in_units=0.0,
        area_in_units=0.0,
        net_area=0.0,
        net_area_in_units=0.0,
    )


_NEAR = 1.0
"""Distance from a slice up to which it shows a click [voxels]."""


def _closed(surface: Surface, here: Slice) -> tuple[Contour, ...]:
    """The closed lines in which a slice cuts a surface."""
    return tuple(each for each in section(surface, here) if each.closed and len(each.points) > 2)


@lru_cache(maxsize=_MOST_OF_OBJECTS)
def boundary_in(body: PackedBody, here: Slice) -> tuple[Line, ...]:
    """The closed lines in which a slice cuts a body; around voxels they run halfway to others."""
    return tuple(_lines(body, here))


def _lines(body: PackedBody, here: Slice) -> Iterable[Line]:
    if isinstance(body, PackedVoxels):
        first, shape = [*body.first], [*body.shape]
        first[here.axis], shape[here.axis] = here.index, 1
        pixels = np.pad(body.part(first, shape).any(axis=here.axis), 1)
        begin = np.array(here.within(tuple(first))) - 1.0
        curves = skimage.measure.find_contours(pixels.astype(np.float32), 0.5)  # type: ignore[no-untyped-call]
        for curve in curves:
            yield as_line(curve[:-1] + begin)
    else:
        for contour in _closed(body.surface, here):
            line = as_line(contour.points)
            if len(set(line)) > 2:
                yield line


def objects_in(objects: SegmentedObjects, here: Slice) -> SegmentedObjects:
    """The objects that a slice cuts, as objects of an image, and the clicks near it."""
    items = tuple(cut for item in objects.items if (cut := _cut(item, here)) is not None)
    edited = objects.edited if any(item.number == objects.edited for item in items) else 0
    return replace(objects, items=items, clicks=tuple(_near(objects.clicks, here)), edited=edited)


def _cut(item: SegmentedObject, here: Slice) -> SegmentedObject | None:
    boundary = boundary_in(item.surface[0], here) if item.surface else ()
    return replace(item, clicks=(), boundary=boundary, surface=()) if boundary else None


def _near(clicks: Iterable[Click], here: Slice) -> Iterable[Click]:
    for click in clicks:
        places = tuple(here.within(at) for at in click.places if abs(at[here.axis] - here.index) <= _NEAR)
        if places:
            yield replace(click, places=places)


def selection_in(selection: AnySelection, here: Slice) -> Selection:
    """What a slice shows of a selection: its boundary alone."""
    nowhere = np.empty((0, 2))
    lines = _closed(selection.surface, here) if isinstance(selection, VolumeSelection) else ()
    return Selection(np.zeros((0, 0), bool), lines, (), 1.0, nowhere, nowhere)


def holds(item: SegmentedObject, place: Place) -> bool:
    """Whether a place (row, col) [px], or (plane, row, col), lies in an object."""
    if len(place) == 2:
        return bool(item.encloses(np.array([place], float))[0])
    if any(isinstance(body, PackedVoxels) for body in item.surface):
        return bool(item.surface[0].part([round(at) for at in place], (1, 1, 1)).all())
    here = Slice(0, round(place[0]))
    within = np.array([here.within(place)], float)
    lines = boundary_in(item.surface[0], here) if item.surface else ()
    return bool(sum(bool(polyline.inside(line, within)[0]) for line in lines) % 2)


def size_of(item: SegmentedObject) -> float:
    """Volume of an object, in the unit of its volume; its area [px²] in an image."""
    return item.surface[0].volume if item.surface else item.area


_LINES_NEAR = 1.5
"""Distance from a slice up to which it shows center lines [voxels]."""


def skeleton_in(found: Skeleton, here: Slice) -> Skeleton:
    """The pieces of center lines near a slice, as those of an image."""
    pieces = [
        piece
        for contour, radii in zip(found.contours, found.radii, strict=True)
        for piece in _pieces(contour.path, np.append(radii, radii[0]) if contour.closed else radii, here)
    ]
    return replace(
        Skeleton((), (), here.within(found.shape), here.within(found.spacing), found.unit, found.source),
        contours=tuple(Contour(points, False) for points, _ in pieces),
        radii=tuple(radii for _, radii in pieces),
    )


def _pieces(path: Array, radii: Array, here: Slice) -> list[tuple[Array, Array]]:
    """Stretches of a line near a slice, flattened, with the vertices before and after."""
    near = np.abs(path[:, here.axis] - here.index) <= _LINES_NEAR
    found = []
    for run in polyline.stretches(scipy.ndimage.binary_dilation(near)):
        flat = here.flattened(path[run])
        distinct = np.append(True, (np.diff(flat, axis=0) != 0.0).any(axis=1))
        if distinct.sum() > 1:
            found.append((flat[distinct], radii[run][distinct]))
    return found
