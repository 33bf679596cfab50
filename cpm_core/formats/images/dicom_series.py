"""Frames and series of DICOM: single images of files, and those that belong together, ordered by their places."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.image.geometry import Geometry, Triple
from cpm_core.image.image import MINIMUM_SIDE
from cpm_core.numerics.types import Array

_ORDER = ("TemporalPositionIdentifier", "AcquisitionNumber", "EchoNumbers", "TriggerTime", "InstanceNumber")
"""What orders images of one place."""

_TAGS = (
    *("SeriesInstanceUID", "SeriesNumber", "SeriesDescription", "Modality", *_ORDER),
    *("Rows", "Columns", "NumberOfFrames", "SamplesPerPixel", "BitsAllocated"),
    *("PixelSpacing", "ImagerPixelSpacing", "NominalScannedPixelSpacing", "SequenceOfUltrasoundRegions"),
    *("SliceThickness", "SpacingBetweenSlices", "ImagePositionPatient", "ImageOrientationPatient"),
    *("SharedFunctionalGroupsSequence", "PerFrameFunctionalGroupsSequence", "GridFrameOffsetVector"),
    *("RescaleSlope", "RescaleIntercept", "FrameTime", "FrameIncrementPointer"),
)
"""What is read of a header; the rest of a folder of thousand files is not waited for."""

_CENTIMETERS = 3
"""Unit of the sizes of a pixel in ultrasound."""

_ONE_PLACE = 1e-3
"""Slices nearer than this lie in one place [mm]."""

_UNEVEN = 0.02
"""By how much distances of slices may differ, as a fraction: positions are often rounded."""

_ALIKE = 4
"""Decimals by which directions and sizes of a pixel are compared: some programs write six digits, some all."""


@dataclass(frozen=True)
class Frame:
    """One image of a file.

    Attributes
    ----------
    path : Path
        The file.
    index : int
        Number of the image in it, from 0.
    series, title : str
        Identifier of its series, and what it is called.
    number : tuple of float
        What orders images of one place: time, echo, number.
    shape : tuple of int
        Rows and columns.
    each : float
        Bytes of a pixel.
    origin : tuple of float or None
        Position of the first pixel (x, y, z) in LPS [mm].
    along : tuple of tuple of float or None
        Unit vectors from a column to the next, and from a row to the next.
    spacing : tuple of float or None
        Size of a pixel along (row, col), in `unit`.
    unit : str or None
        Unit of length.
    thickness : float or None
        How far slices are apart where they have no position [mm]: their distance if it is given, or their thickness.
    detector : bool
        Whether the size of a pixel is that on the detector.
    slope, intercept : float
        What turns stored values into those that are meant.
    in_time : bool
        Whether the images of the file follow in time.
    """

    path: Path
    index: int
    series: str
    title: str
    number: tuple[float, ...]
    shape: tuple[int, int]
    each: float
    origin: Triple | None
    along: tuple[Triple, Triple] | None
    spacing: tuple[float, float] | None
    unit: str | None
    thickness: float | None
    detector: bool
    slope: float
    intercept: float
    in_time: bool


def frames_of(pydicom: Any, path: Path) -> list[Frame]:
    """The frames of a file; ValueError, or anything, when it is damaged, and none when it has no pixels."""
    header = pydicom.dcmread(path, stop_before_pixels=True, force=True, specific_tags=list(_TAGS))
    if "Rows" not in header or "Columns" not in header:
        return []
    count = int(header.get("NumberOfFrames", 1) or 1)
    own = header.get("PerFrameFunctionalGroupsSequence") or []
    if count < 1 or 0 < len(own) < count:
        raise ValueError("the number of its images is not valid")
    return [_frame(path, index, header, own[index : index + 1], count) for index in range(count)]


def _frame(path: Path, index: int, header: Any, own: list[Any], count: int) -> Frame:
    groups = [*own, *(header.get("SharedFunctionalGroupsSequence") or [])[:1]]

    def value(name: str, sequence: str) -> Any:
        """An entry of the image, of all images, or of the file."""
        items = ((group.get(sequence) or [None])[0] for group in groups)
        found = (item.get(name) for item in items if item is not None and item.get(name) is not None)
        return next(found, header.get(name))

    spacing, unit, detector = _spacing(header, value("PixelSpacing", "PixelMeasuresSequence"))
    origin = _triple(_numbers(value("ImagePositionPatient", "PlanePositionSequence"), 3))
    along = _along(_numbers(value("ImageOrientationPatient", "PlaneOrientationSequence"), 6))
    if count > 1 and not own:
        origin = _in_grid(header, origin, along, count, index)
    apart = (value(name, "PixelMeasuresSequence") for name in ("SpacingBetweenSlices", "SliceThickness"))
    return Frame(
        path,
        index,
        str(header.get("SeriesInstanceUID", "")),
        str(header.get("SeriesDescription", "") or header.get("SeriesNumber", "") or header.get("Modality", "")),
        (*(_number(header.get(name), 0.0) for name in _ORDER), float(index)),
        (int(header.Rows), int(header.Columns)),
        float(header.get("SamplesPerPixel", 1) or 1) * float(header.get("BitsAllocated", 16) or 16) / 8.0,
        origin,
        along,
        spacing,
        unit,
        next((size for size in (abs(_number(one, 0.0)) for one in apart) if size), None),
        detector,
        _number(value("RescaleSlope", "PixelValueTransformationSequence"), 1.0) or 1.0,
        _number(value("RescaleIntercept", "PixelValueTransformationSequence"), 0.0),
        count > 1 and not own and origin is None and ("FrameTime" in header or "FrameIncrementPointer" in header),
    )


def _in_grid(
    header: Any, first: Triple | None, along: tuple[Triple, Triple] | None, count: int, index: int
) -> Triple | None:
    """Position of an image of a grid of doses, which lists the distances of its images from the first one."""
    offsets = _numbers(header.get("GridFrameOffsetVector"), count)
    if first is None or along is None or offsets is None:
        return None
    return _triple(np.array(first) + (offsets[index] - offsets[0]) * np.cross(*along))


def _spacing(header: Any, given: Any) -> tuple[tuple[float, float] | None, str | None, bool]:
    """Size of a pixel along (row, col), its unit, and whether it is that on the detector."""
    on_detector, nominal = header.get("ImagerPixelSpacing"), header.get("NominalScannedPixelSpacing")
    for sides, detector in ((given, False), (on_detector, True), (nominal, False)):
        found = _numbers(sides, 2)
        if found is not None and min(found) > 0.0:
            return (found[0], found[1]), "mm", detector
    regions = set()
    for region in header.get("SequenceOfUltrasoundRegions") or []:
        row, col = (abs(_number(region.get(f"PhysicalDelta{axis}"), 0.0)) for axis in "YX")
        units = {region.get(f"PhysicalUnits{axis}Direction") for axis in "YX"}
        if units == {_CENTIMETERS} and min(row, col) > 0.0:
            regions.add((row, col))
    return (regions.pop(), "cm", False) if len(regions) == 1 else (None, None, False)


def _along(turn: list[float] | None) -> tuple[Triple, Triple] | None:
    """Directions of columns and rows; None when they are not at right angles, as where nobody filled them in."""
    if turn is None:
        return None
    column, row = np.array(turn[:3]), np.array(turn[3:])
    lengths = np.linalg.norm(column), np.linalg.norm(row)
    if min(lengths) < 0.5 or abs(column @ row) > 0.05 * lengths[0] * lengths[1]:
        return None
    return _vector(column / lengths[0]), _vector(row / lengths[1])


def _numbers(given: Any, count: int) -> list[float] | None:
    """So many finite numbers; None for anything else."""
    try:
        found = [float(number) for number in given]
    except (TypeError, ValueError):
        return None
    return found if len(found) == count and all(map(math.isfinite, found)) else None


def _number(given: Any, otherwise: float) -> float:
    """A finite number, of several the first."""
    try:
        found = float(given[0] if isinstance(given, (list, tuple)) or hasattr(given, "append") else given)
    except (TypeError, ValueError, IndexError):
        return otherwise
    return found if math.isfinite(found) else otherwise


def _triple(numbers: Sequence[float] | Array | None) -> Triple | None:
    return None if numbers is None else _vector(numbers)


def _vector(numbers: Sequence[float] | Array) -> Triple:
    x, y, z = (float(number) for number in numbers)
    return x, y, z


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
        Distance of neighboring planes; None when the files do not give it.
    stretch : tuple of int or None
        First plane of the longest part that is evenly spaced, and the one after its last; None when all are.
    geometry : Geometry or None
        Where the first plane of the stretch lies, moved back to the first of all.
    places : tuple of Geometry
        Where each plane lies.
    notes, of_volume : tuple of str
        What is to be reported of it, and of a volume made of it.
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
        along = None if frame.along is None else tuple(np.round(np.ravel(frame.along), _ALIKE - 1).tolist())
        spacing = None if frame.spacing is None else tuple(round(side, _ALIKE) for side in frame.spacing)
        kind = (frame.series, frame.shape, along, spacing, frame.origin is None)
        groups.setdefault(kind, []).append(frame)
    found = [series for group in groups.values() for series in _ordered(group)]
    return tuple(sorted(found, key=lambda series: (series.title, -len(series.frames[0]))))


def _ordered(group: list[Frame]) -> list[Series]:
    """A series in the order of its places, and what else of it makes a volume next to its longest even part."""
    first = group[0]
    group = sorted(group, key=lambda frame: frame.number)
    notes: tuple[str, ...] = ("The size of a pixel is that on the detector.",) if first.detector else ()
    if first.origin is None or first.along is None:
        return [_without_places(group, notes)]
    normal = np.cross(*first.along)
    places: list[list[Frame]] = []
    heights: list[float] = []
    for height, frame in sorted(
        ((float(normal @ np.array(frame.origin)), frame) for frame in group), key=lambda pair: pair[0]
    ):
        if heights and height - heights[-1] < _ONE_PLACE:
            places[-1].append(frame)
        else:
            places.append([frame])
            heights.append(height)
    times = min(map(len, places))
    if times < max(map(len, places)):
        notes += ("At some places it has more slices than at others; the first of them were taken.",)
    ordered = [sorted(place, key=lambda frame: frame.number) for place in places]
    by_time = tuple(tuple(place[time] for place in ordered) for time in range(times))
    at = np.array(heights)
    found = [_placed(first.title, by_time, at, normal, notes)]
    parts = _even_parts(at)
    for begin, end in parts:
        if (begin, end) != _longest(parts) and end - begin >= MINIMUM_SIDE:
            title = f"{first.title}, slices {begin + 1} to {end}".lstrip(", ")
            part = _placed(title, tuple(time[begin:end] for time in by_time), at[begin:end], normal, notes)
            found.append(replace(part, partial=True))
    return found


def _without_places(frames: list[Frame], notes: tuple[str, ...]) -> Series:
    """A series whose files do not give its places: images in time, or slices in the order of their numbers."""
    first = frames[0]
    if first.in_time or len(frames) == 1:
        return Series(first.title, tuple((frame,) for frame in frames), first.thickness, notes=notes)
    apart = "" if first.thickness is None else f", {first.thickness:g} mm apart"
    note = f"The places of its slices are not given; they were taken in their order{apart}."
    return Series(first.title, (tuple(frames),), first.thickness, notes=notes, of_volume=(note,))


def _placed(
    title: str, frames: tuple[tuple[Frame, ...], ...], heights: Array, normal: Array, notes: tuple[str, ...]
) -> Series:
    """A series by the positions of its slices along their normal."""
    planes, along = frames[0], frames[0][0].along
    assert along is not None
    begin, end, note = _stretch(heights)
    origins = np.array([frame.origin for frame in planes])
    if end - begin > 1:
        step = (origins[end - 1] - origins[begin]) / (end - 1 - begin)
        depth = float(np.linalg.norm(step))
    else:
        depth = planes[0].thickness or 1.0
        step = normal * depth
    places = tuple(Geometry(_vector(one), (_vector(normal), along[1], along[0]), "LPS", depth) for one in origins)
    geometry = Geometry(
        _vector(origins[begin] - begin * step), (_vector(step / depth), along[1], along[0]), "LPS", depth
    )
    stretch = None if end - begin == len(planes) else (begin, end)
    return Series(title, frames, depth, stretch, geometry, places, notes, note)


def _even_parts(heights: Array) -> list[tuple[int, int]]:
    """First slice of each part that is evenly spaced, and the one after its last; neighbors may share a slice."""
    gaps = np.diff(heights)
    found, begin = [], 0
    for index in range(len(gaps)):
        part = gaps[begin : index + 1]
        if np.ptp(part) > _UNEVEN * np.median(part):
            found.append((begin, index + 1))
            begin = index
    return [*found, (begin, len(heights))]


def _longest(parts: list[tuple[int, int]]) -> tuple[int, int]:
    return max(parts, key=lambda part: part[1] - part[0])


def _stretch(heights: Array) -> tuple[int, int, tuple[str, ...]]:
    """First slice of the longest part that is evenly spaced, the one after its last, and what is wrong next to it."""
    begin, end = _longest(_even_parts(heights))
    if end - begin == len(heights):
        return 0, len(heights), ()
    gaps = np.diff(heights)
    usual = float(np.median(gaps[begin : end - 1]))
    odd = begin - 1 if begin > 0 else end - 1
    ratio = float(gaps[odd]) / usual
    missing = round(ratio) - 1
    wrong = f"Its slices are from {gaps.min():.4g} to {gaps.max():.4g} mm apart."
    if missing >= 1 and math.isclose(ratio, missing + 1, rel_tol=_UNEVEN):
        lack = "1 slice is missing" if missing == 1 else f"{missing} slices are missing"
        wrong = f"Between slices {odd + 1} and {odd + 2} lie {gaps[odd]:.4g} mm, elsewhere {usual:.4g} mm: {lack}."
    return (
        begin,
        end,
        (
            wrong,
            f"The longest even part has {end - begin} slices, {begin + 1} to {end}, {usual:.4g} mm apart.",
        ),
    )
