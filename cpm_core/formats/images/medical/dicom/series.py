"""Series: frames that belong together, in the order in which they lie, and how far they are apart."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cpm_core.formats.images.medical.dicom.frame import Frame
from cpm_core.image.geometry import Geometry, Triple
from cpm_core.image.image import MINIMUM_SIDE
from cpm_core.numerics.types import Array

_ONE_PLACE = 1e-3
"""Slices nearer than this lie in one place [mm]."""

_UNEVEN = 0.02
"""By how much distances of slices may differ, as a fraction: positions are often rounded."""

_ALIKE = 4
"""Decimals by which directions and sizes of a pixel are compared: some programs write six digits, some all."""


@dataclass(frozen=True, eq=False)
class Series:
    """Frames of one size, direction and size of a pixel.

    Attributes
    ----------
    title : str
        What it is called.
    frames : tuple of tuple of Frame
        For each time the frames from the first plane to the last.
    depth : float or None
        Distance of neighboring planes; None when the files do not tell.
    stretch : tuple of int or None
        First plane of the longest part that is evenly spaced, and the one after its last; None when all are.
    geometry : Geometry or None
        Where the first plane of the stretch lies, moved back to the first of all.
    places : tuple of Geometry
        Where each plane lies.
    notes, of_volume : tuple of str
        What is to be said of it, and of a volume made of it.
    partial : bool
        Whether it is a part of another one.
    """

    title: str
    frames: tuple[tuple[Frame, ...], ...]
    depth: float | None
    stretch: tuple[int, int] | None = None
    geometry: Geometry | None = None
    places: tuple[Geometry, ...] = ()
    notes: tuple[str, ...] = ()
    of_volume: tuple[str, ...] = ()
    partial: bool = False


def all_series(frames: Sequence[Frame]) -> tuple[Series, ...]:
    """The series among frames, in the order of their names."""
    groups: dict[tuple[object, ...], list[Frame]] = {}
    for frame in frames:
        groups.setdefault(_kind(frame), []).append(frame)
    found = [series for group in groups.values() for series in _ordered(group)]
    return tuple(sorted(found, key=lambda series: (series.title, -len(series.frames[0]))))


def _kind(frame: Frame) -> tuple[object, ...]:
    along = None if frame.along is None else tuple(np.round(np.ravel(frame.along), _ALIKE - 1).tolist())
    spacing = None if frame.spacing is None else tuple(round(side, _ALIKE) for side in frame.spacing)
    return frame.series, frame.shape, along, spacing, frame.origin is None


def _ordered(group: list[Frame]) -> list[Series]:
    """A series, and where it is not evenly spaced what else of it makes a volume beside its longest even part."""
    first = group[0]
    notes: tuple[str, ...] = ("The size of a pixel is that on the detector.",) if first.detector else ()
    if first.origin is None or first.along is None:
        return [_without_places(sorted(group, key=lambda frame: frame.number), notes)]
    column, row = np.array(first.along)
    normal = np.cross(column, row)
    places: list[list[Frame]] = []
    at: list[float] = []
    for frame in sorted(group, key=lambda frame: float(normal @ np.array(frame.origin))):
        height = float(normal @ np.array(frame.origin))
        if at and height - at[-1] < _ONE_PLACE:
            places[-1].append(frame)
        else:
            places.append([frame])
            at.append(height)
    ordered = [sorted(place, key=lambda frame: frame.number) for place in places]
    times = min(map(len, ordered))
    if times < max(map(len, ordered)):
        notes += ("At some places it has more slices than at others; the first of them were taken.",)
    by_time = tuple(tuple(place[time] for place in ordered) for time in range(times))
    heights = np.array(at)
    parts = _even_parts(heights)
    found = [_placed(first.title, by_time, heights, normal, notes)]
    for begin, end in parts:
        if (begin, end) != _longest(parts) and end - begin >= MINIMUM_SIDE:
            title = f"{first.title}, slices {begin + 1} to {end}".lstrip(", ")
            part = _placed(title, tuple(time[begin:end] for time in by_time), heights[begin:end], normal, notes)
            found.append(replace(part, partial=True))
    return found


def _without_places(frames: list[Frame], notes: tuple[str, ...]) -> Series:
    """A series whose files do not tell where they lie: a film, or slices in the order of their numbers."""
    first, title = frames[0], frames[0].title
    if first.film or len(frames) == 1:
        return Series(title, tuple((frame,) for frame in frames), first.thickness, notes=notes)
    if first.thickness is None:
        told = "It does not tell where its slices lie or how far they are apart; they were taken in their order."
    else:
        told = (
            "It does not tell where its slices lie; they were taken in their order, as far apart as they say "
            f"({first.thickness:g} mm)."
        )
    return Series(title, (tuple(frames),), first.thickness, notes=notes, of_volume=(told,))


def _placed(
    title: str, frames: tuple[tuple[Frame, ...], ...], at: Array, normal: Array, notes: tuple[str, ...]
) -> Series:
    """A series by the positions of its slices along their normal."""
    planes = frames[0]
    begin, end, told = _stretch(at)
    origins = np.array([frame.origin for frame in planes])
    if end - begin > 1:
        step = (origins[end - 1] - origins[begin]) / (end - 1 - begin)
        depth = float(np.linalg.norm(step))
    else:
        depth = planes[0].thickness or 1.0
        step = normal * depth
    along = planes[0].along
    assert along is not None
    directions = (_triple(step / depth), along[1], along[0])
    origin = _triple(origins[begin] - begin * step)
    places = tuple(Geometry(_triple(one), (_triple(normal), along[1], along[0]), "LPS", depth) for one in origins)
    stretch = None if end - begin == len(planes) else (begin, end)
    geometry = Geometry(origin, directions, "LPS", depth)
    return Series(title, frames, depth, stretch, geometry, places, notes, told)


def _even_parts(at: Array) -> list[tuple[int, int]]:
    """First slice of each part that is evenly spaced, and the one after its last; neighbors may share a slice."""
    gaps = np.diff(at)
    found, begin = [], 0
    for index in range(len(gaps)):
        part = gaps[begin : index + 1]
        if np.ptp(part) > _UNEVEN * np.median(part):
            found.append((begin, index + 1))
            begin = index
    return [*found, (begin, len(at))]


def _stretch(at: Array) -> tuple[int, int, tuple[str, ...]]:
    """First slice of the longest part that is evenly spaced, the one after its last, and what is wrong beside it."""
    begin, end = _longest(_even_parts(at))
    if end - begin == len(at):
        return 0, len(at), ()
    gaps = np.diff(at)
    usual = float(np.median(gaps[begin : end - 1]))
    odd = begin - 1 if begin > 0 else end - 1
    ratio = float(gaps[odd]) / usual
    missing = round(ratio) - 1
    longest = f"The longest even part has {end - begin} slices, {begin + 1} to {end}, {usual:.4g} mm apart."
    if missing < 1 or not math.isclose(ratio, missing + 1, rel_tol=_UNEVEN):
        return begin, end, (f"Its slices are from {gaps.min():.4g} to {gaps.max():.4g} mm apart.", longest)
    lack = "1 slice is missing" if missing == 1 else f"{missing} slices are missing"
    between = f"Between slices {odd + 1} and {odd + 2} lie {gaps[odd]:.4g} mm, elsewhere {usual:.4g} mm: {lack}."
    return begin, end, (between, longest)


def _longest(parts: list[tuple[int, int]]) -> tuple[int, int]:
    return max(parts, key=lambda part: part[1] - part[0])


def _triple(vector: Array) -> Triple:
    x, y, z = vector.tolist()
    return x, y, z
