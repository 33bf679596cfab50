"""Frames and series of DICOM: single images of files, grouped and ordered by their positions."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.formats.images.decoded import DecodedImage
from cpm_core.formats.images.stack import Stack
from cpm_core.image.geometry import Geometry
from cpm_core.image.image import MINIMUM_SIDE
from cpm_core.numerics.types import Array, Texts, record

_ORDERING_TAGS = ("TemporalPositionIdentifier", "AcquisitionNumber", "EchoNumbers", "TriggerTime", "InstanceNumber")
"""Tags that order the images at one position."""

_HEADER_TAGS = (
    *("SeriesInstanceUID", "SeriesNumber", "SeriesDescription", "Modality", *_ORDERING_TAGS),
    *("Rows", "Columns", "NumberOfFrames", "SamplesPerPixel", "BitsAllocated"),
    *("PixelSpacing", "ImagerPixelSpacing", "NominalScannedPixelSpacing", "PixelAspectRatio"),
    "SequenceOfUltrasoundRegions",
    *("SliceThickness", "SpacingBetweenSlices", "ImagePositionPatient", "ImageOrientationPatient"),
    *("SharedFunctionalGroupsSequence", "PerFrameFunctionalGroupsSequence", "GridFrameOffsetVector"),
    *("DetectorInformationSequence", "SliceVector", "TotalPixelMatrixRows"),
    *("RescaleSlope", "RescaleIntercept", "RescaleType", "FrameTime", "FrameIncrementPointer"),
    *("WindowCenter", "WindowWidth"),
)
"""Tags that are read from a header; reading all would take long for a folder of a thousand files."""

_UNIT_CENTIMETER = 3
"""Code of the unit of pixel sizes in ultrasound."""

_SAME_SLICE_DISTANCE = 1e-3
"""Distance below which slices are at the same position [mm]."""

_MAX_UNEVENNESS = 0.02
"""Largest relative difference of slice distances in an even stack: positions are often rounded."""

_MAX_SLICE_SHIFT = 0.5
"""Largest distance of slices from the line through the first and the last one [smallest side of a pixel]."""

_SAME_DIRECTION = 1e-3
"""Largest difference of directions in a series: some programs write six digits, some round in each slice."""

_SAME_SIZE = 1e-4
"""Largest difference of pixel sizes in a series, in their unit."""

_TIME_POINTERS = (0x00181063, 0x00181065, 0x00540030, 0x00540070, 0x00540100)
"""Tags for time that may set the frames of a file apart: frame time and its vector; phase, time slot, time slice."""


@record
class DicomFrame:
    """One image of a file.

    Attributes
    ----------
    path : Path
        The file.
    index : int
        Index of the image in the file, from 0.
    series, title : str
        Identifier and name of its series.
    sort_key : tuple of float
        Sort key of the images at one position: time, echo, number.
    shape : tuple of int
        Rows and columns.
    bytes_per_pixel : float
        Bytes of a pixel.
    origin : ndarray or None
        Position of the first pixel (x, y, z) in LPS [mm].
    directions : ndarray, shape (2, 3), or None
        Unit vectors from a column to the next, and from a row to the next.
    spacing : tuple of float or None
        Size of a pixel along (row, col), in `unit`, or without a unit their ratio.
    unit : str or None
        Unit of length.
    thickness : float or None
        Distance of slices without a position [mm]: as stated, or else their thickness.
    notes : tuple of str
        Notes on the size of a pixel.
    slope, intercept : float
        Rescaling of stored values: slope * stored + intercept.
    window : tuple of float or None
        Rescaled values that are to be shown as the darkest and the brightest.
    is_time_series : bool
        Whether the images of the file are a time series.
    hounsfield : bool
        Whether the rescaled values are Hounsfield units.
    """

    path: Path
    index: int
    series: str
    title: str
    sort_key: tuple[float, ...]
    shape: tuple[int, int]
    bytes_per_pixel: float
    origin: Array | None
    directions: Array | None
    spacing: tuple[float, float] | None
    unit: str | None
    thickness: float | None
    notes: Texts
    slope: float
    intercept: float
    window: tuple[float, float] | None
    is_time_series: bool
    hounsfield: bool

    @property
    def acquisition(self) -> float:
        """Number of its acquisition; 0 if unknown."""
        return self.sort_key[_ORDERING_TAGS.index("AcquisitionNumber")]


DecodeFrames = Callable[[Sequence[DicomFrame]], DecodedImage]
"""Reads the pixels of frames as planes."""


def read_file_frames(pydicom: Any, path: Path) -> list[DicomFrame]:
    """Read the frames of a file, none without pixels or of a slide in tiles; a damaged file raises any exception."""
    header = pydicom.dcmread(path, stop_before_pixels=True, force=True, specific_tags=list(_HEADER_TAGS))
    if "Rows" not in header or "Columns" not in header or "TotalPixelMatrixRows" in header:
        return []
    count = int(header.get("NumberOfFrames", 1) or 1)
    own = header.get("PerFrameFunctionalGroupsSequence") or []
    return [_build_frame(path, index, header, own[index : index + 1], count) for index in range(count)]


def _build_frame(path: Path, index: int, header: Any, own: list[Any], count: int) -> DicomFrame:
    """Build a frame from the header and its own functional group."""
    groups = [*own, *(header.get("SharedFunctionalGroupsSequence") or [])[:1]]

    def find_value(name: str, sequence: str) -> Any:
        """Find an entry of the frame, of all frames, or of the file."""
        items = ((group.get(sequence) or [None])[0] for group in groups)
        found = (item.get(name) for item in items if item is not None and item.get(name) is not None)
        return next(found, header.get(name))

    level, width = (_parse_number(find_value(f"Window{name}", "FrameVOILUTSequence")) for name in ("Center", "Width"))
    spacing, unit, notes = _parse_pixel_spacing(header, find_value("PixelSpacing", "PixelMeasuresSequence"))
    # slices of nuclear medicine lie where their detector says
    detector = (header.get("DetectorInformationSequence") or [{}])[0]
    place = find_value("ImagePositionPatient", "PlanePositionSequence") or detector.get("ImagePositionPatient")
    turn = find_value("ImageOrientationPatient", "PlaneOrientationSequence") or detector.get("ImageOrientationPatient")
    origin, along = _parse_numbers(place, 3), _parse_directions(_parse_numbers(turn, 6))
    given = (find_value(name, "PixelMeasuresSequence") for name in ("SpacingBetweenSlices", "SliceThickness"))
    apart = next((step for step in map(_parse_number, given) if step), None)
    if count > 1 and not own:  # dose grids list the offsets of their images from the first one
        offsets = _parse_numbers(header.get("GridFrameOffsetVector"), count)
        slices = _parse_numbers(header.get("SliceVector"), count)
        if slices is not None and apart and (np.diff(slices) > 0.0).all():
            offsets = apart * slices  # below 0 where they run against their normal
        if origin is not None and along is not None and offsets is not None:
            origin = origin + (offsets[index] - offsets[0]) * np.cross(*along)
        else:
            origin = None
    return DicomFrame(
        path,
        index,
        str(header.get("SeriesInstanceUID", "")),
        str(header.get("SeriesDescription", "") or header.get("SeriesNumber", "") or header.get("Modality", "")),
        (*(_parse_number(header.get(name)) for name in _ORDERING_TAGS), float(index)),
        (int(header.Rows), int(header.Columns)),
        float(header.get("SamplesPerPixel", 1) or 1) * float(header.get("BitsAllocated", 16) or 16) / 8.0,
        origin,
        along,
        spacing,
        unit,
        apart and abs(apart),
        notes,
        _parse_number(find_value("RescaleSlope", "PixelValueTransformationSequence")) or 1.0,
        _parse_number(find_value("RescaleIntercept", "PixelValueTransformationSequence")),
        (level - 0.5 * width, level + 0.5 * width) if width > 0.0 else None,
        count > 1 and not own and origin is None and _is_time_series(header),
        header.get("Modality") == "CT"
        and find_value("RescaleIntercept", "PixelValueTransformationSequence") is not None
        and find_value("RescaleType", "PixelValueTransformationSequence") in (None, "", "HU"),
    )


def _parse_pixel_spacing(header: Any, given: Any) -> tuple[tuple[float, float] | None, str | None, Texts]:
    """Parse the size of a pixel along (row, col), its unit, and notes on it."""
    on_detector, nominal = header.get("ImagerPixelSpacing"), header.get("NominalScannedPixelSpacing")
    for sides in (given, on_detector, nominal):
        found = _parse_numbers(sides, 2)
        if found is not None and min(found) > 0.0:
            notes = ("The size of a pixel is that on the detector.",) if sides is on_detector else ()
            return (float(found[0]), float(found[1])), "mm", notes
    regions = set()
    for region in header.get("SequenceOfUltrasoundRegions") or []:
        row, col = (abs(_parse_number(region.get(f"PhysicalDelta{axis}"))) for axis in "YX")
        units = {region.get(f"PhysicalUnits{axis}Direction") for axis in "YX"}
        if units == {_UNIT_CENTIMETER} and min(row, col) > 0.0:
            regions.add((row, col))
    if len(regions) == 1:
        return regions.pop(), "cm", ()
    ratio = _parse_numbers(header.get("PixelAspectRatio"), 2)  # height to width
    return ((float(ratio[0] / ratio[1]), 1.0) if ratio is not None and min(ratio) > 0.0 else None), None, ()


def _is_time_series(header: Any) -> bool:
    """Return whether the file says that its frames differ in time."""
    pointer = header.get("FrameIncrementPointer")
    if pointer is None or pointer == "":
        return "FrameTime" in header
    named = {int(tag) for tag in (pointer if isinstance(pointer, Iterable) else [pointer])}
    return not named.isdisjoint(_TIME_POINTERS)


def _parse_directions(turn: Array | None) -> Array | None:
    """Parse the directions of columns and rows, shape (2, 3); None unless perpendicular, as when left unset."""
    if turn is None:
        return None
    lengths = np.linalg.norm(turn.reshape(2, 3), axis=1)
    if lengths.min() < 0.5 or abs(turn[:3] @ turn[3:]) > 0.05 * lengths.prod():
        return None
    return turn.reshape(2, 3) / lengths[:, None]


def _parse_numbers(given: Any, count: int) -> Array | None:
    """Parse this many finite numbers, shape (count,); None for anything else."""
    try:
        found = np.array([float(number) for number in given])
    except (TypeError, ValueError):
        return None
    return found if len(found) == count and np.isfinite(found).all() else None


def _parse_number(given: Any) -> float:
    """Parse a finite number, the first of several; 0 for anything else."""
    found = _parse_numbers(given[:1] if hasattr(given, "append") else [given], 1)
    return 0.0 if found is None else float(found[0])


def group_series(frames: Sequence[DicomFrame], name: str, decode: DecodeFrames) -> list[list[Stack]]:
    """Group the frames of a file or folder into series, each with its evenly spaced parts.

    Frames of a series share image size, orientation and pixel size. Its longest evenly spaced part comes first,
    followed by all other such parts.
    """
    groups: list[list[DicomFrame]] = []
    for frame in frames:
        group = next((one for one in groups if _match_frames(one[0], frame)), None)
        if group is None:
            groups.append([frame])
        else:
            group.append(frame)
    found = []
    for group in groups:
        group.sort(key=lambda frame: frame.sort_key)
        if group[0].origin is None or group[0].directions is None:
            found.append(list(_stack_without_positions(group, name, decode)))
        else:
            found += [list(_stack_by_position(part, name, decode)) for part in _split_acquisitions(group)]
    return found


def _match_frames(one: DicomFrame, other: DicomFrame) -> bool:
    """Return whether two frames belong to one series and have the same size, directions and size of a pixel."""
    return (
        (one.series, one.shape, one.unit, one.origin is None)
        == (other.series, other.shape, other.unit, other.origin is None)
        and _are_close(one.directions, other.directions, _SAME_DIRECTION)
        and _are_close(one.spacing, other.spacing, _SAME_SIZE)
    )


def _are_close(one: ArrayLike | None, other: ArrayLike | None, tolerance: float) -> bool:
    """Return whether both are missing, or differ by no more than a tolerance."""
    if one is None or other is None:
        return one is other
    return bool(np.abs(np.subtract(one, other)).max() <= tolerance)


def _split_acquisitions(frames: list[DicomFrame]) -> list[list[DicomFrame]]:
    """Split a series by acquisition if their slices interleave unevenly."""
    heights, places = _group_by_position(frames)
    if not _is_interleaved(places) or _is_evenly_spaced(np.diff(heights)):
        return [frames]
    acquisitions: dict[float, list[DicomFrame]] = {}
    for frame in frames:
        title = f"{frame.title}, acquisition {frame.acquisition:g}".lstrip(", ")
        acquisitions.setdefault(frame.acquisition, []).append(replace(frame, title=title))
    return list(acquisitions.values())


def _is_interleaved(places: list[list[DicomFrame]]) -> bool:
    """Return whether slices of several acquisitions interleave rather than follow one another."""
    owners = [frozenset(frame.acquisition for frame in place) for place in places]
    changes = sum(one.isdisjoint(other) for one, other in itertools.pairwise(owners))
    return changes >= max(2, len(frozenset[float]().union(*owners)))


def _is_evenly_spaced(gaps: Array) -> bool:
    """Return whether the distances of slices, shape (N,), are about equal."""
    return not len(gaps) or bool(np.ptp(gaps) <= _MAX_UNEVENNESS * np.median(gaps))


def _group_by_position(frames: list[DicomFrame]) -> tuple[list[float], list[list[DicomFrame]]]:
    """Return the heights of slices along their normal, in order, and the frames at each height."""
    assert frames[0].directions is not None
    normal = np.cross(*frames[0].directions)
    heights, places = list[float](), list[list[DicomFrame]]()
    for height, frame in sorted(((float(normal @ one.origin), one) for one in frames), key=lambda pair: pair[0]):
        if heights and height - heights[-1] < _SAME_SLICE_DISTANCE:
            places[-1].append(frame)
        else:
            places.append([frame])
            heights.append(height)
    return heights, places


def _stack_without_positions(frames: list[DicomFrame], name: str, decode: DecodeFrames) -> Iterator[Stack]:
    """Yield a series without positions: images in time, or slices in the order of their numbers."""
    first = frames[0]
    if first.is_time_series or len(frames) == 1:
        yield _build_stack(first.title, [[frame] for frame in frames], first.thickness, name, decode)
        return
    apart = "" if first.thickness is None else f", {first.thickness:g} mm apart"
    note = f"The places of its slices are not given; they were taken in their order{apart}."
    yield replace(_build_stack(first.title, [frames], first.thickness, name, decode), volume_notes=(note,))


def _stack_by_position(frames: list[DicomFrame], name: str, decode: DecodeFrames) -> Iterator[Stack]:
    """Yield a series ordered along the normal of its slices, then its other evenly spaced parts."""
    first, (heights, places) = frames[0], _group_by_position(frames)
    assert first.directions is not None
    normal = np.cross(*first.directions)
    times = min(map(len, places))
    notes = ("At some places it has more slices than at others; the first of them were taken.",)
    ordered = [sorted(place, key=lambda frame: frame.sort_key) for place in places]
    by_time = [[place[time] for place in ordered] for time in range(times)]
    gaps, parts = np.diff(heights), [[0, 0]]
    mixed = ("Slices of several acquisitions lie between one another; they were taken as one volume.",)
    for end in range(1, len(heights)):
        if not _is_evenly_spaced(gaps[parts[-1][0] : end]):
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
        doubts: Texts = mixed if _is_interleaved(places[begin : last + 1]) else ()
        if aside > _MAX_SLICE_SHIFT * min(first.spacing or (1.0,)):
            doubts += (f"Its slices are shifted sideways by up to {aside:.3g} mm; they were taken as if in line.",)
        found = replace(_build_stack(title, kept, depth, name, decode), volume_notes=doubts)
        if found.unit == "mm":
            axes = (first.directions[1], first.directions[0])
            lies = [Geometry(one, (normal, *axes), "LPS", depth) for one in origins]  # type: ignore[arg-type]
            at = Geometry(origins[shift] - shift * step, (step / depth, *axes), "LPS", depth)  # type: ignore[arg-type]
            found = replace(found, geometry=at, plane_geometries=tuple(lies))
        if times < max(map(len, places)):
            found = replace(found, notes=found.notes + notes)
        if whole and count + 1 < len(heights):
            found = replace(
                found, volume_range=(begin, last + 1), volume_notes=(*_describe_gap(gaps, begin, last), *doubts)
            )
        yield found


def _build_stack(
    title: str, frames: list[list[DicomFrame]], depth: float | None, name: str, decode: DecodeFrames
) -> Stack:
    """Build a stack from frames by time and position."""
    first, planes = frames[0][0], len(frames[0])
    row, col = first.spacing or (1.0, 1.0)
    # depth in millimeters with pixels in centimeters occurs only in ultrasound, which has no slices
    between = depth if depth and first.unit == "mm" else row
    return Stack(
        name,
        (planes, *first.shape),
        lambda time, _channel, begin, end: decode(frames[time][begin:end]),
        first.bytes_per_pixel,
        len(frames),
        1,
        (between, row, col),
        first.unit,
        notes=first.notes,
        plane_word="frame" if planes == 1 else "plane",
        series=(title,),
        hounsfield=first.hounsfield,
    )


def _describe_gap(gaps: Array, begin: int, last: int) -> tuple[str, str]:
    """Describe the irregularity next to the longest even part, and which slices that part has."""
    usual = float(np.median(gaps[begin:last]))
    odd = begin - 1 if begin > 0 else last
    ratio = float(gaps[odd]) / usual
    missing = round(ratio) - 1
    wrong = f"Its slices are from {gaps.min():.4g} to {gaps.max():.4g} mm apart."
    if missing >= 1 and math.isclose(ratio, missing + 1, rel_tol=_MAX_UNEVENNESS):
        lack = "1 slice is missing" if missing == 1 else f"{missing} slices are missing"
        wrong = f"Between slices {odd + 1} and {odd + 2} lie {gaps[odd]:.4g} mm, elsewhere {usual:.4g} mm: {lack}."
    part = f"The longest even part has {last - begin + 1} slices, {begin + 1} to {last + 1}, {usual:.4g} mm apart."
    return wrong, part
