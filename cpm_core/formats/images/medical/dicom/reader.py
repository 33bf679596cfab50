"""The reader of DICOM: one file, or a folder with the files of a series."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.formats.common.printable import printable
from cpm_core.formats.images.choice import FIRST, Choice, series_of
from cpm_core.formats.images.decoded import Decoded, UnreadableError
from cpm_core.formats.images.medical.dicom import pixels
from cpm_core.formats.images.medical.dicom.frame import Frame, frames_of
from cpm_core.formats.images.medical.dicom.series import Series, all_series
from cpm_core.formats.images.stacks.stack import Stack, as_planes, check_content, joined, plane_of
from cpm_core.parameters.quotation import shown

FORMAT = "DICOM"
READS = {".dcm": "DICOM image, or a folder with the slices of a series", ".dicom": "the same", ".ima": "the same"}

FOLDER = bytes(128) + b"DICM"
"""What stands for the first bytes of a folder with a series."""

_MARK, _PLACE = b"DICM", 128
_GROUPS = (b"\x08\x00", b"\x02\x00")
_KINDS = (
    b"AE",
    b"AS",
    b"CS",
    b"DA",
    b"DS",
    b"DT",
    b"IS",
    b"LO",
    b"OB",
    b"OW",
    b"PN",
    b"SH",
    b"TM",
    b"UI",
    b"UL",
    b"US",
)
_LONGEST_FIRST = 64
"""Most bytes of the first entry of a file that has no kinds of entries."""


def reads(head: bytes, _path: Path) -> bool:
    """Whether the first bytes of a file are those of DICOM; old files begin with an entry, without its mark."""
    if head.startswith(_MARK, _PLACE):
        return True
    if head[:2] not in _GROUPS or len(head) < _PLACE or head[3:4] != b"\0":
        return False
    short = int.from_bytes(head[4:8], "little")
    return head[4:6] in _KINDS or (short % 2 == 0 and 0 < short <= _LONGEST_FIRST and head[8 + short :][:2] in _GROUPS)


def is_series(folder: Path) -> bool:
    """Whether a folder holds a DICOM file, by the first bytes of its files."""
    return bool(_files(folder, most=1))


def dicom_files_beside(path: Path, most: int) -> list[Path]:
    """So many DICOM files at most in the folder of a DICOM file; none for another file or a folder."""
    try:
        with path.open("rb") as stream:
            known = reads(stream.read(512), path)
        return _files(path.parent, most) if known else []
    except OSError:
        return []


def read(path: Path, choice: Choice = FIRST) -> Decoded:
    """Read one image: of a film the first, of a volume the middle one, unless one is chosen."""
    return plane_of(stack(path, choice), choice)


def stack(path: Path, choice: Choice = FIRST) -> Stack:
    """Open a file, or the series of a folder that is chosen: by default that with the most images.

    Raises
    ------
    UnreadableError
        When no file holds an image.
    """
    name = printable(path.name)
    import pydicom  # only here, because it takes long to import

    frames: list[Frame] = []
    damaged = 0
    for file in _files(path) if path.is_dir() else [path]:
        try:
            frames += frames_of(pydicom, file)
        except Exception:
            if path.is_file():
                raise
            damaged += 1
    if not frames:
        raise UnreadableError(f"{name} holds no DICOM image: choose another file or folder.")
    for frame in frames:
        if min(frame.shape) < 1:
            raise ValueError("an image has no pixels")
    series = all_series(frames)
    sizes = [len(one.frames) * len(one.frames[0]) for one in series]
    titles = tuple(one.title for one in series)
    number = series_of(choice.series, titles, int(np.argmax(sizes)), name)
    chosen = series[number]
    notes = []
    whole = sum(not one.partial for one in series)
    if whole > 1 and choice.series is None:
        which = f"{number + 1} ({shown(chosen.title)})"
        notes.append(f"Of its {whole} series that with the most images was taken, {which}.")
    if damaged:
        notes.append(f"{damaged} of its files {'is' if damaged == 1 else 'are'} damaged and left out.")
    return replace(_stack(name, chosen, tuple(notes), pydicom), series=titles, number=number)


def _stack(name: str, series: Series, notes: tuple[str, ...], pydicom: Any) -> Stack:
    first = series.frames[0][0]
    each = {frame.path for time in series.frames for frame in time}
    if len(each) == 1:
        count = len(series.frames) * len(series.frames[0])
        check_content(first.path, count * first.each * first.shape[0] * first.shape[1])
    row, col = first.spacing or (1.0, 1.0)
    planes = len(series.frames[0])
    # millimeters of a depth beside centimeters of a pixel occur in ultrasound alone, which has no slices
    depth = series.depth if series.depth and first.unit == "mm" else row

    def take(time: int, _channel: int, begin: int, end: int) -> Decoded:
        opened: tuple[Path | None, Any] = (None, None)
        found = []
        for frame in series.frames[time][begin:end]:
            if opened[0] != frame.path:
                opened = frame.path, _dataset(pydicom, frame.path)
            one = pixels.decoded(opened[1], frame)
            found.append(as_planes(one, (1, *one.values.shape)))
        return joined(found)

    return Stack(
        name,
        (planes, *first.shape),
        take,
        first.each,
        len(series.frames),
        1,
        (depth, row, col),
        first.unit,
        series.geometry if first.unit == "mm" else None,
        series.places if first.unit == "mm" else (),
        series.stretch,
        (*notes, *series.notes),
        series.of_volume,
        word="frame" if planes == 1 else "plane",
        otherwise=planes // 2,
    )


def _dataset(pydicom: Any, path: Path) -> Any:
    dataset = pydicom.dcmread(path, force=True)
    if "TransferSyntaxUID" not in dataset.file_meta:  # of an old file without a mark
        implicit, _ = dataset.original_encoding
        kinds = pydicom.uid.ImplicitVRLittleEndian if implicit else pydicom.uid.ExplicitVRLittleEndian
        dataset.file_meta.TransferSyntaxUID = kinds
    return dataset


def _files(folder: Path, most: int | None = None) -> list[Path]:
    """DICOM files of a folder by their first bytes, in the order of their names, so many at most."""
    found: list[Path] = []
    for path in sorted(folder.iterdir()):
        if path.name.startswith(".") or not path.is_file():
            continue
        try:
            with path.open("rb") as stream:
                head = stream.read(512)
        except OSError:
            continue
        if reads(head, path):
            found.append(path)
            if len(found) == most:
                break
    return found
