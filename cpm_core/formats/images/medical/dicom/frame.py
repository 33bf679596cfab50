"""Frames: one image each of a DICOM file, with what its header tells of its size and place."""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.formats.images.decoded import UnreadableError
from cpm_core.image.geometry import Triple
from cpm_core.numerics.memory import free

_TAGS = (
    "SeriesInstanceUID",
    "SeriesNumber",
    "SeriesDescription",
    "SOPClassUID",
    "Modality",
    "InstanceNumber",
    "AcquisitionNumber",
    "TemporalPositionIdentifier",
    "TriggerTime",
    "EchoNumbers",
    "Rows",
    "Columns",
    "NumberOfFrames",
    "SamplesPerPixel",
    "BitsAllocated",
    "PixelSpacing",
    "ImagerPixelSpacing",
    "NominalScannedPixelSpacing",
    "SliceThickness",
    "SpacingBetweenSlices",
    "ImagePositionPatient",
    "ImageOrientationPatient",
    "SequenceOfUltrasoundRegions",
    "SharedFunctionalGroupsSequence",
    "PerFrameFunctionalGroupsSequence",
    "RescaleSlope",
    "RescaleIntercept",
    "FrameTime",
    "FrameIncrementPointer",
    "GridFrameOffsetVector",
)
"""What is read of a header; the rest of a folder of thousand files is not waited for."""

_BEGINNING, _LENGTH_ENTRY = 132, 12
"""Bytes of a file up to its first entry, and those of the entry that tells the length of the first ones."""

_PART = 2**22
"""Bytes that are read and unpacked at once."""

_CENTIMETERS = 3
"""Unit of the sizes of a pixel in ultrasound."""


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
        How far slices are apart where they have no position [mm]: their distance if it is told, or their thickness.
    detector : bool
        Whether the size of a pixel is that on the detector.
    slope, intercept : float
        What turns stored values into those that are meant.
    film : bool
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
    film: bool


def frames_of(pydicom: Any, path: Path) -> list[Frame]:
    """The frames of a file; ValueError, or anything, when it is damaged, and none when it has no pixels."""
    check_inflated(pydicom, path)
    header = pydicom.dcmread(path, stop_before_pixels=True, force=True, specific_tags=list(_TAGS))
    if "Rows" not in header or "Columns" not in header:
        return []
    count = int(header.get("NumberOfFrames", 1) or 1)
    shared = (header.get("SharedFunctionalGroupsSequence") or [None])[0]
    own = header.get("PerFrameFunctionalGroupsSequence") or []
    if count < 1 or 0 < len(own) < count:
        raise ValueError("the number of its images is not valid")
    return [_frame(path, index, header, [own[index]] if own else [], shared) for index in range(count)]


def check_inflated(pydicom: Any, path: Path) -> None:
    """Raise UnreadableError for a file that is packed as a whole and does not fit into memory, which pydicom takes."""
    with path.open("rb") as stream:
        if not stream.read(_BEGINNING).endswith(b"DICM"):
            return
        entries = pydicom.filereader.read_file_meta_info(path)
        if not getattr(entries.get("TransferSyntaxUID"), "is_deflated", False):
            return
        stream.seek(_BEGINNING + _LENGTH_ENTRY + int(entries.FileMetaInformationGroupLength))
        unpacker, size, most = zlib.decompressobj(-zlib.MAX_WBITS), 0, free() / 2.0
        part = stream.read(_PART)
        while part and not unpacker.eof:
            size += len(unpacker.decompress(part, _PART))
            part = unpacker.unconsumed_tail or stream.read(_PART)
            if size > most:
                raise UnreadableError(f"{path.name} unpacks to more than the free memory: save it without packing.")


def _frame(path: Path, index: int, header: Any, own: list[Any], shared: Any) -> Frame:
    groups = [*own, *([shared] if shared is not None else [])]

    def told(name: str, sequence: str) -> Any:
        """An entry of the image, of all images, or of the file."""
        for group in groups:
            item = (group.get(sequence) or [None])[0]
            if item is not None and item.get(name) is not None:
                return item.get(name)
        return header.get(name)

    spacing, unit, detector = _spacing(header, told("PixelSpacing", "PixelMeasuresSequence"))
    place = _numbers(told("ImagePositionPatient", "PlanePositionSequence"), 3)
    turn = _numbers(told("ImageOrientationPatient", "PlaneOrientationSequence"), 6)
    apart = told("SpacingBetweenSlices", "PixelMeasuresSequence")
    thick = told("SliceThickness", "PixelMeasuresSequence")
    thickness = next((size for size in map(_positive, (apart, thick)) if size), None)
    number = [header.get(name) for name in _ORDER]
    along = None if turn is None else _along(turn)
    slope = _number(told("RescaleSlope", "PixelValueTransformationSequence"), 1.0)
    count = int(header.get("NumberOfFrames", 1) or 1)
    if count > 1 and not own:
        place = _of_grid(header, place, along, count, index)
    return Frame(
        path,
        index,
        str(header.get("SeriesInstanceUID", "")),
        str(header.get("SeriesDescription", "") or header.get("SeriesNumber", "") or header.get("Modality", "")),
        (*(_number(one, 0.0) for one in number), float(index)),
        (int(header.Rows), int(header.Columns)),
        float(header.get("SamplesPerPixel", 1) or 1) * float(header.get("BitsAllocated", 16) or 16) / 8.0,
        None if place is None else (place[0], place[1], place[2]),
        along,
        spacing,
        unit,
        thickness,
        detector,
        slope or 1.0,
        _number(told("RescaleIntercept", "PixelValueTransformationSequence"), 0.0),
        count > 1 and not own and place is None and ("FrameTime" in header or "FrameIncrementPointer" in header),
    )


def _of_grid(
    header: Any, first: list[float] | None, along: tuple[Triple, Triple] | None, count: int, index: int
) -> list[float] | None:
    """Position of an image of a grid of doses, which tells the distances of its images from the first one."""
    offsets = _numbers(header.get("GridFrameOffsetVector"), count)
    if first is None or along is None or offsets is None:
        return None
    moved = np.array(first) + (offsets[index] - offsets[0]) * np.cross(*along)
    return [float(x) for x in moved]


_ORDER = ("TemporalPositionIdentifier", "AcquisitionNumber", "EchoNumbers", "TriggerTime", "InstanceNumber")


def _spacing(header: Any, told: Any) -> tuple[tuple[float, float] | None, str | None, bool]:
    """Size of a pixel along (row, col), its unit, and whether it is that on the detector."""
    for given, detector in (
        (told, False),
        (header.get("ImagerPixelSpacing"), True),
        (header.get("NominalScannedPixelSpacing"), False),
    ):
        sides = _numbers(given, 2)
        if sides is not None and min(sides) > 0.0:
            return (sides[0], sides[1]), "mm", detector
    regions = list(_of_ultrasound(header))
    if len(set(regions)) == 1:
        return regions[0], "cm", False
    return None, None, False


def _of_ultrasound(header: Any) -> Iterator[tuple[float, float]]:
    """Size of a pixel in each region of an ultrasound image that tells it in centimeters."""
    for region in header.get("SequenceOfUltrasoundRegions") or []:
        sides = (region.get("PhysicalDeltaY"), region.get("PhysicalDeltaX"))
        units = {region.get("PhysicalUnitsXDirection"), region.get("PhysicalUnitsYDirection")}
        row, col = (abs(_number(side, 0.0)) for side in sides)
        if units == {_CENTIMETERS} and min(row, col) > 0.0:
            yield row, col


def _along(turn: list[float]) -> tuple[Triple, Triple] | None:
    """Directions of columns and rows; None when they are not at right angles, as where nobody filled them in."""
    column, row = np.array(turn[:3]), np.array(turn[3:])
    lengths = np.linalg.norm(column), np.linalg.norm(row)
    if min(lengths) < 0.5 or abs(column @ row) > 0.05 * lengths[0] * lengths[1]:
        return None
    x, y = (column / lengths[0]).tolist(), (row / lengths[1]).tolist()
    return (x[0], x[1], x[2]), (y[0], y[1], y[2])


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


def _positive(given: Any) -> float | None:
    size = abs(_number(given, 0.0))
    return size or None
