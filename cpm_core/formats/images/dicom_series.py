"""Frames and series of DICOM: single images of files, and those that belong together, ordered by their places."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.formats.images.decoded import Decoded
from cpm_core.formats.images.stack import Stack
from cpm_core.image.geometry import Geometry
from cpm_core.image.image import MINIMUM_SIDE
from cpm_core.numerics.types import Array, Texts, record

_ORDER = ("TemporalPositionIdentifier", "AcquisitionNumber", "EchoNumbers", "TriggerTime", "InstanceNumber")
"""What orders images of one place."""

_TAGS = (
    *("SeriesInstanceUID", "SeriesNumber", "SeriesDescription", "Modality", *_ORDER),
    *("Rows", "Columns", "NumberOfFrames", "SamplesPerPixel", "BitsAllocated"),
    *("PixelSpacing", "ImagerPixelSpacing", "NominalScannedPixelSpacing", "SequenceOfUltrasoundRegions"),
    *("SliceThickness", "SpacingBetweenSlices", "ImagePositionPatient", "ImageOrientationPatient"),
    *("SharedFunctionalGroupsSequence", "PerFrameFunctionalGroupsSequence", "GridFrameOffsetVector"),
    *("RescaleSlope", "RescaleIntercept", "RescaleType", "FrameTime", "FrameIncrementPointer"),
)
"""What is read of a header; the rest of a folder of thousand files is not waited for."""

_CENTIMETERS = 3
"""Unit of the sizes of a pixel in ultrasound."""

_ONE_PLACE = 1e-3
"""Slices nearer than this lie in one place [mm]."""

_UNEVEN = 0.02
"""By how much distances of slices may differ, as a fraction: positions are often rounded."""

_ASIDE = 0.5
"""How far slices may lie beside the line through the first and the last of them [smallest sides of a pixel]."""

_ALIKE = 4
"""Decimals by which directions and sizes of a pixel are compared: some programs write six digits, some all."""


@record
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
    origin : ndarray or None
        Position of the first pixel (x, y, z) in LPS [mm].
    along : ndarray, shape (2, 3), or None
        Unit vectors from a column to the next, and from a row to the next.
    spacing : tuple of float or None
        Size of a pixel along (row, col), in `unit`.
    unit : str or None
        Unit of length.
    thickness : float or None
        How far slices are apart where they have no position [mm]: their distance if it is given, or their thickness.
    notes : tuple of str
        What is to be said of the size of a pixel.
    slope, intercept : float
        What turns stored values into those that are meant.
    in_time : bool
        Whether the images of the file follow in time.
    hounsfield : bool
        Whether these values are Hounsfield units.
    """

    path: Path
    index: int
    series: str
    title: str
    number: tuple[float, ...]
    shape: tuple[int, int]
    each: float
    origin: Array | None
    along: Array | None
    spacing: tuple[float, float] | None
    unit: str | None
    thickness: float | None
    notes: Texts
    slope: float
    intercept: float
    in_time: bool
    hounsfield: bool

    @property
    def acquisition(self) -> float:
        """Number of its acquisition; 0 where that is not known."""
        return self.number[_ORDER.index("AcquisitionNumber")]


Decode = Callable[[Sequence[Frame]], Decoded]
"""Reads the pixels of frames, which become planes."""


def frames_of(pydicom: Any, path: Path) -> list[Frame]:
    """The frames of a file; ValueError, or anything, when it is damaged, and none when it has no pixels."""
    header = pydicom.dcmread(path, stop_before_pixels=True, force=True, specific_tags=list(_TAGS))
    if "Rows" not in header or "Columns" not in header:
        return []
    count = int(header.get("NumberOfFrames", 1) or 1)
    own = header.get("PerFrameFunctionalGroupsSequence") or []
    return [_frame(path, index, header, own[index : index + 1], count) for index in range(count)]


def _frame(path: Path, index: int, header: Any, own: list[Any], count: int) -> Frame:
    groups = [*own, *(header.get("SharedFunctionalGroupsSequence") or [])[:1]]

    def value(name: str, sequence: str) -> Any:
        """An entry of the image, of all images, or of the file."""
        items = ((group.get(sequence) or [None])[0] for group in groups)
        found = (item.get(name) for item in items if item is not None and item.get(name) is not None)
        return next(found, header.get(name))

    spacing, unit, notes = _spacing(header, value("PixelSpacing", "PixelMeasuresSequence"))
    origin = _numbers(value("ImagePositionPatient", "PlanePositionSequence"), 3)
    along = _along(_numbers(value("ImageOrientationPatient", "PlaneOrientationSequence"), 6))
    if count > 1 and not own:  # a grid of doses lists the distances of its images from the first one
        offsets = _numbers(header.get("GridFrameOffsetVector"), count)
        if origin is not None and along is not None and offsets is not None:
            origin = origin + (offsets[index] - offsets[0]) * np.cross(*along)
        else:
            origin = None
    apart = (value(name, "PixelMeasuresSequence") for name in ("SpacingBetweenSlices", "SliceThickness"))
    return Frame(
        path,
        index,
        str(header.get("SeriesInstanceUID", "")),
        str(header.get("SeriesDescription", "") or header.get("SeriesNumber", "") or header.get("Modality", "")),
        (*(_number(header.get(name)) for name in _ORDER), float(index)),
        (int(header.Rows), int(header.Columns)),
        float(header.get("SamplesPerPixel", 1) or 1) * float(header.get("BitsAllocated", 16) or 16) / 8.0,
        origin,
        along,
        spacing,
        unit,
        next((size for size in (abs(_number(one)) for one in apart) if size), None),
        notes,
        _number(value("RescaleSlope", "PixelValueTransformationSequence")) or 1.0,
        _number(value("RescaleIntercept", "PixelValueTransformationSequence")),
        count > 1 and not own and origin is None and ("FrameTime" in header or "FrameIncrementPointer" in header),
        header.get("Modality") == "CT"
        and value("RescaleIntercept", "PixelValueTransformationSequence") is not None
        and value("RescaleType", "PixelValueTransformationSequence") in (None, "", "HU"),
    )


def _spacing(header: Any, given: Any) -> tuple[tuple[float, float] | None, str | None, Texts]:
    """Size of a pixel along (row, col), its unit, and what is to be said of it."""
    on_detector, nominal = header.get("ImagerPixelSpacing"), header.get("NominalScannedPixelSpacing")
    for sides in (given, on_detector, nominal):
        found = _numbers(sides, 2)
        if found is not None and min(found) > 0.0:
            notes = ("The size of a pixel is that on the detector.",) if sides is on_detector else ()
            return (float(found[0]), float(found[1])), "mm", notes
    regions = set()
    for region in header.get("SequenceOfUltrasoundRegions") or []:
        row, col = (abs(_number(region.get(f"PhysicalDelta{axis}"))) for axis in "YX")
        units = {region.get(f"PhysicalUnits{axis}Direction") for axis in "YX"}
        if units == {_CENTIMETERS} and min(row, col) > 0.0:
            regions.add((row, col))
    return (regions.pop(), "cm", ()) if len(regions) == 1 else (None, None, ())


def _along(turn: Array | None) -> Array | None:
    """Directions of columns and rows; None when they are not at right angles, as where nobody filled them in."""
    if turn is None:
        return None
    lengths = np.linalg.norm(turn.reshape(2, 3), axis=1)
    if lengths.min() < 0.5 or abs(turn[:3] @ turn[3:]) > 0.05 * lengths.prod():
        return None
    return turn.reshape(2, 3) / lengths[:, None]


def _numbers(given: Any, count: int) -> Array | None:
    """So many finite numbers; None for anything else."""
    try:
        found = np.array([float(number) for number in given])
    except (TypeError, ValueError):
        return None
    return found if len(found) == count and np.isfinite(found).all() else None


def _number(given: Any) -> float:
    """A finite number, of several the first; 0 for anything else."""
    found = _numbers(given[:1] if hasattr(given, "append") else [given], 1)
    return 0.0 if found is None else float(found[0])


def all_series(frames: Sequence[Frame], name: str, decode: Decode) -> list[list[Stack]]:
    """The series among the frames of a file or folder, each with what else of it makes a volume.

    Frames of a series have one size, direction and size of a pixel. Besides its longest part that is evenly spaced, all
    other such parts are offered.
    """
    groups: dict[tuple[object, ...], list[Frame]] = {}
    for frame in frames:
        along = None if frame.along is None else tuple(np.round(frame.along.ravel(), _ALIKE - 1).tolist())
        spacing = None if frame.spacing is None else tuple(round(side, _ALIKE) for side in frame.spacing)
        kind = (frame.series, frame.shape, along, spacing, frame.origin is None)
        groups.setdefault(kind, []).append(frame)
    found = []
    for group in groups.values():
        group.sort(key=lambda frame: frame.number)
        if group[0].origin is None or group[0].along is None:
            found.append(list(_without_places(group, name, decode)))
        else:
            found += [list(_placed(part, name, decode)) for part in _apart(group)]
    return found


def _apart(frames: list[Frame]) -> list[list[Frame]]:
    """The acquisitions of a series as series of their own, where their slices lie between one another unevenly."""
    heights, places = _places(frames)
    if not _interleaved(places) or _is_even(np.diff(heights)):
        return [frames]
    acquisitions: dict[float, list[Frame]] = {}
    for frame in frames:
        title = f"{frame.title}, acquisition {frame.acquisition:g}".lstrip(", ")
        acquisitions.setdefault(frame.acquisition, []).append(replace(frame, title=title))
    return list(acquisitions.values())


def _interleaved(places: list[list[Frame]]) -> bool:
    """Whether slices of several acquisitions lie between one another, not one acquisition behind the other."""
    owners = [frozenset(frame.acquisition for frame in place) for place in places]
    changes = sum(one.isdisjoint(other) for one, other in itertools.pairwise(owners))
    return changes >= max(2, len(frozenset[float]().union(*owners)))


def _is_even(gaps: Array) -> bool:
    """Whether slices are about as far apart as one another."""
    return not len(gaps) or bool(np.ptp(gaps) <= _UNEVEN * np.median(gaps))


def _places(frames: list[Frame]) -> tuple[list[float], list[list[Frame]]]:
    """The heights of slices along their normal, in order, and the frames at each of them."""
    assert frames[0].along is not None
    normal = np.cross(*frames[0].along)
    heights, places = list[float](), list[list[Frame]]()
    for height, frame in sorted(((float(normal @ one.origin), one) for one in frames), key=lambda pair: pair[0]):
        if heights and height - heights[-1] < _ONE_PLACE:
            places[-1].append(frame)
        else:
            places.append([frame])
            heights.append(height)
    return heights, places


def _without_places(frames: list[Frame], name: str, decode: Decode) -> Iterator[Stack]:
    """A series whose files do not give its places: images in time, or slices in the order of their numbers."""
    first = frames[0]
    if first.in_time or len(frames) == 1:
        yield _stack(first.title, [[frame] for frame in frames], first.thickness, name, decode)
        return
    apart = "" if first.thickness is None else f", {first.thickness:g} mm apart"
    note = f"The places of its slices are not given; they were taken in their order{apart}."
    yield replace(_stack(first.title, [frames], first.thickness, name, decode), of_volume=(note,))


def _placed(frames: list[Frame], name: str, decode: Decode) -> Iterator[Stack]:
    """A series by the positions of its slices along their normal, and the other parts that are evenly spaced."""
    first, (heights, places) = frames[0], _places(frames)
    assert first.along is not None
    normal = np.cross(*first.along)
    times = min(map(len, places))
    notes = ("At some places it has more slices than at others; the first of them were taken.",)
    ordered = [sorted(place, key=lambda frame: frame.number) for place in places]
    by_time = [[place[time] for place in ordered] for time in range(times)]
    gaps, parts = np.diff(heights), [[0, 0]]
    mixed = ("Slices of several acquisitions lie between one another; they were taken as one volume.",)
    for end in range(1, len(heights)):
        if not _is_even(gaps[parts[-1][0] : end]):
            parts.append([end - 1, end])
        parts[-1][1] = end
    longest = max(parts, key=lambda part: part[1] - part[0])
    for begin, last in [longest, *(one for one in parts if one is not longest)]:
        whole = (begin, last) == tuple(longest)
        if not whole and last - begin + 1 < MINIMUM_SIDE:
            continue
        title = first.title if whole else f"{first.title}, slices {begin + 1} to {last + 1}".lstrip(", ")
        shift = begin if whole else 0
        kept = by_time if whole else [time[begin : last + 1] for time in by_time]
        planes, count = kept[0], last - begin
        origins = np.array([frame.origin for frame in planes])
        depth, step = planes[0].thickness or 1.0, normal * (planes[0].thickness or 1.0)
        if count:
            step = (origins[shift + count] - origins[shift]) / count
            depth = float(np.linalg.norm(step))
        line = origins[shift] + np.arange(count + 1)[:, None] * step
        aside = float(np.linalg.norm(origins[shift : shift + count + 1] - line, axis=1).max())
        doubts: Texts = mixed if _interleaved(places[begin : last + 1]) else ()
        if aside > _ASIDE * min(first.spacing or (1.0,)):
            doubts += (f"Its slices are shifted sideways by up to {aside:.3g} mm; they were taken as if in line.",)
        found = replace(_stack(title, kept, depth, name, decode), of_volume=doubts)
        if found.unit == "mm":
            axes = (first.along[1], first.along[0])
            lies = [Geometry(one, (normal, *axes), "LPS", depth) for one in origins]  # type: ignore[arg-type]
            at = Geometry(origins[shift] - shift * step, (step / depth, *axes), "LPS", depth)  # type: ignore[arg-type]
            found = replace(found, geometry=at, places=tuple(lies))
        if times < max(map(len, places)):
            found = replace(found, notes=found.notes + notes)
        if whole and count + 1 < len(heights):
            found = replace(found, stretch=(begin, last + 1), of_volume=(*_gap(gaps, begin, last), *doubts))
        yield found


def _stack(title: str, frames: list[list[Frame]], depth: float | None, name: str, decode: Decode) -> Stack:
    """Frames by their times and places."""
    first, planes = frames[0][0], len(frames[0])
    row, col = first.spacing or (1.0, 1.0)
    # millimeters of a depth next to centimeters of a pixel occur in ultrasound alone, which has no slices
    between = depth if depth and first.unit == "mm" else row
    return Stack(
        name,
        (planes, *first.shape),
        lambda time, _channel, begin, end: decode(frames[time][begin:end]),
        first.each,
        len(frames),
        1,
        (between, row, col),
        first.unit,
        notes=first.notes,
        word="frame" if planes == 1 else "plane",
        series=(title,),
        hounsfield=first.hounsfield,
    )


def _gap(gaps: Array, begin: int, last: int) -> tuple[str, str]:
    """What is wrong next to the longest part that is evenly spaced, from one slice to another, and which part it is."""
    usual = float(np.median(gaps[begin:last]))
    odd = begin - 1 if begin > 0 else last
    ratio = float(gaps[odd]) / usual
    missing = round(ratio) - 1
    wrong = f"Its slices are from {gaps.min():.4g} to {gaps.max():.4g} mm apart."
    if missing >= 1 and math.isclose(ratio, missing + 1, rel_tol=_UNEVEN):
        lack = "1 slice is missing" if missing == 1 else f"{missing} slices are missing"
        wrong = f"Between slices {odd + 1} and {odd + 2} lie {gaps[odd]:.4g} mm, elsewhere {usual:.4g} mm: {lack}."
    part = f"The longest even part has {last - begin + 1} slices, {begin + 1} to {last + 1}, {usual:.4g} mm apart."
    return wrong, part
