"""DICOM: single images, series in time, volumes in one file, slices in a folder, and slides, read by pydicom."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.formats.common.content import UnreadableError, read_content
from cpm_core.formats.common.printable import make_printable
from cpm_core.formats.images.decoded import DecodedImage, check_pixel_count, decode_bands, decode_samples
from cpm_core.formats.images.dicom_series import DicomFrame, group_series, read_file_frames
from cpm_core.formats.images.dicom_slide import open_slide
from cpm_core.formats.images.reading import Reading, select_series
from cpm_core.formats.images.stack import Stack, stack_from_levels, stack_planes
from cpm_core.image.gray_levels import NO_DATA_VALUE
from cpm_core.image.image import MINIMUM_SIDE
from cpm_core.numerics.packages import require_package
from cpm_core.numerics.types import Numbers, Texts
from cpm_core.parameters.formatting import quote_value

FILE_KINDS = {".dcm": "DICOM image, or a folder with the slices of a series", ".dicom": "the same", ".ima": "the same"}

_DICOM_MARK = b"DICM"
"""Mark of a DICOM file."""

_DICOM_MARK_OFFSET = 128
"""Offset of the mark [bytes]."""

_FIRST_GROUPS = (b"\x08\x00", b"\x02\x00")
"""Groups that the first entry of a file without the mark may belong to."""

_MAX_FIRST_ENTRY = 64
"""Largest first entry of a file whose entries do not state their type [bytes]."""

_MAX_FILES_BELOW = 20_000
"""Largest number of files in the folders below one that is searched for series."""

_JPEG_SYNTAX_PREFIX = "1.2.840.10008.1.2.4."
"""Prefix of the transfer syntaxes of the JPEG family."""

_JPEG_DECODERS = {
    **dict.fromkeys(("50", "51", "57", "70"), "jpeg_decode"),
    **dict.fromkeys(("80", "81"), "jpegls_decode"),
    **dict.fromkeys(("90", "91", "201", "202", "203"), "jpeg2k_decode"),
}
"""Rest of the transfer syntax -> function of imagecodecs."""

_PIXEL_ENTRIES = ("PixelData", "FloatPixelData", "DoubleFloatPixelData")
"""Entries that may hold the pixels."""

# pydicom logs a warning for everything unusual in a file; the user gets one sentence on what matters instead.
logging.getLogger("pydicom").addHandler(logging.NullHandler())


def can_read(head: bytes, _path: Path) -> bool:
    """Return whether a file begins like DICOM: with its mark, or for old files with an entry."""
    if head.startswith(_DICOM_MARK, _DICOM_MARK_OFFSET):
        return True
    if head[:2] not in _FIRST_GROUPS or len(head) < _DICOM_MARK_OFFSET or head[3:4] != b"\0":
        return False
    short = int.from_bytes(head[4:8], "little")
    return (head[4:6].isalpha() and head[4:6].isupper()) or (
        short % 2 == 0 and 0 < short <= _MAX_FIRST_ENTRY and head[8 + short :][:2] in _FIRST_GROUPS
    )


def holds_dicom_series(folder: Path) -> bool:
    """Return whether a folder holds a DICOM file, by the first bytes of its files."""
    return bool(_list_dicom_files(folder, max_count=1))


def holds_dicom_series_below(folder: Path) -> bool:
    """Return whether a folder below a folder holds a DICOM file; False for a file."""
    return any(True for _ in _find_dicom_files_below(folder))


def find_sibling_dicom_files(path: Path, max_count: int) -> list[Path]:
    """List up to `max_count` DICOM files in the folder of a DICOM file; none for other files or folders."""
    return _list_dicom_files(path.parent, max_count) if is_dicom(path) else []


def _list_dicom_files(folder: Path, max_count: int | None = None) -> list[Path]:
    """List the DICOM files of a folder by their first bytes, sorted by name, `max_count` at most."""
    try:
        paths = sorted(folder.iterdir())
    except OSError:
        return []
    return list(islice((path for path in paths if not path.name.startswith(".") and is_dicom(path)), max_count))


def _find_dicom_files_below(folder: Path) -> Iterator[Path]:
    """Find the DICOM files in the folders below a folder, as on the CD of a patient, in the order of their names.

    UnreadableError when there are so many files that it is no such folder.
    """
    count = 0
    for place, folders, files in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        count += len(files)
        if count > _MAX_FILES_BELOW:
            raise UnreadableError(
                f"{folder.name} has more than {_MAX_FILES_BELOW} files in the folders below it: choose one of these."
            )
        yield from (path for name in sorted(files) if not name.startswith(".") and is_dicom(path := Path(place, name)))


def is_dicom(path: Path) -> bool:
    """Return whether a file is DICOM, by its first bytes; False for a folder."""
    try:
        return can_read(read_content(path, head_size=512), path)
    except UnreadableError:
        return False


def open_image_file(path: Path, reading: Reading) -> Stack:
    """Open a file, or the selected series of a folder, by default the one with the most images.

    Raises
    ------
    UnreadableError
        When no file holds an image.
    """
    name = make_printable(path.name)
    frames, unread = read_frames(path)
    if not frames:
        folder = path if path.is_dir() else path.parent
        levels = open_slide(name, path, _list_dicom_files(folder) or _find_dicom_files_below(folder), reading)
        if levels is None:
            raise UnreadableError(f"{name} contains no DICOM image: choose another file or folder.")
        return stack_from_levels(levels)

    groups = group_series(frames, name, partial(decode_frames, name))
    series = sorted((one for group in groups for one in group), key=lambda one: (one.series, -one.shape[0]))
    titles = tuple(title for one in series for title in one.series)
    number = select_series(reading, titles, name, int(np.argmax([one.times * one.shape[0] for one in series])))
    chosen = series[number]
    notes = []
    if len(groups) > 1 and reading.series is None:
        which = f"{number + 1} ({quote_value(titles[number])})"
        notes.append(f"Of its {len(groups)} series that with the most images was taken, {which}.")
        if chosen.shape[0] < MINIMUM_SIDE and chosen.times == 1 and chosen.volume_range is None:
            differ = f"Its {len(frames)} images have {len(groups)} different sizes, directions or series."
            chosen = replace(chosen, volume_range=(0, chosen.shape[0]), volume_notes=(differ,))
    if unread:
        notes.append(f"{unread} of its files {'was' if unread == 1 else 'were'} left out, which cannot be read.")
    return replace(chosen, series=titles, series_number=number, notes=(*notes, *chosen.notes))


def read_frames(path: Path) -> tuple[list[DicomFrame], int]:
    """Read the frames of a file, or of all files of a folder, and count those that cannot be read.

    A folder without any, and a DICOMDIR, stand for all files in the folders below.
    """
    import pydicom  # only here, because it takes long to import

    if path.is_file():
        frames = read_file_frames(pydicom, path)
        if frames or not _is_directory_of_files(path):
            return frames, 0
        folder = path.parent
    else:
        folder = path
        frames, unread = _read_frames_of(_list_dicom_files(folder))
        if frames:
            return frames, unread
    return _read_frames_of(_find_dicom_files_below(folder))


def _read_frames_of(files: Iterable[Path]) -> tuple[list[DicomFrame], int]:
    """Read the frames of files, and count those that cannot be read."""
    import pydicom

    frames: list[DicomFrame] = []
    unread = 0
    for file in files:
        try:
            frames += read_file_frames(pydicom, file)
        except Exception:
            unread += 1
    return frames, unread


def _is_directory_of_files(path: Path) -> bool:
    """Return whether a DICOM file is a DICOMDIR, which lists the files of a medium."""
    import pydicom

    known = pydicom.dcmread(path, force=True, specific_tags=["FileSetID"]).file_meta
    return known.get("MediaStorageSOPClassUID") == pydicom.uid.MediaStorageDirectoryStorage


def decode_frames(name: str, frames: Sequence[DicomFrame]) -> DecodedImage:
    """Decode the pixels of frames as planes; `name` is that of their file or folder in messages."""
    opened: tuple[Path | None, Any] = (None, None)
    found = []
    for frame in frames:
        if opened[0] != frame.path:
            opened = frame.path, _read_dataset(frame.path)
        found.append(_decode_frame(opened[1], frame, name))
    return stack_planes(found)


def _read_dataset(path: Path) -> Any:
    """Read a file, completing the transfer syntax of old files."""
    import pydicom

    dataset = pydicom.dcmread(path, force=True)
    if "TransferSyntaxUID" not in dataset.file_meta:  # an old file without the mark
        implicit, _ = dataset.original_encoding
        kinds = pydicom.uid.ImplicitVRLittleEndian if implicit else pydicom.uid.ExplicitVRLittleEndian
        dataset.file_meta.TransferSyntaxUID = kinds
    return dataset


def _decode_frame(dataset: Any, frame: DicomFrame, name: str) -> DecodedImage:
    """Decode one image of a file: values in the unit of the file, bright where they should appear bright."""
    check_pixel_count(name, *frame.shape)
    stored = _unpack_pixels(dataset, frame, name)
    if stored.shape[:2] != frame.shape:
        raise ValueError("the pixels have another size than the header says")
    colors = str(dataset.get("PhotometricInterpretation", "MONOCHROME2")).strip()
    if colors == "PALETTE COLOR":
        from pydicom.pixels.processing import apply_color_lut

        table = apply_color_lut(stored, dataset)
        bright = table if table.max(initial=0) < 256 else table >> 8  # some programs write eight bits in sixteen
        return decode_bands(bright.astype(np.uint8)[..., :3])
    bits = int(dataset.get("BitsStored", 8 * stored.dtype.itemsize))
    if stored.ndim == 3:
        return decode_samples(stored[..., :3], white=2.0**bits - 1.0)
    values: Numbers = stored
    notes: Texts = ()
    window = frame.window
    if colors == "MONOCHROME1":
        ends = -1 if int(dataset.get("PixelRepresentation", 0)) else 2**bits - 1
        values, notes = ends - stored.astype(np.int64), ("It counts from white to black and was inverted.",)
        if window is not None:
            turned = frame.slope * ends + 2.0 * frame.intercept
            window = turned - window[1], turned - window[0]
    if (frame.slope, frame.intercept) != (1.0, 0.0):
        values = values * np.float64(frame.slope) + np.float64(frame.intercept)
    return DecodedImage(_mask_padding(dataset, values, stored), notes=notes, window=window)


def _mask_padding(dataset: Any, values: Numbers, stored: Numbers) -> Numbers:
    """Set pixels that only fill the rectangle, as outside the circle of a scanner, to `NO_DATA_VALUE`."""
    names = ("PixelPaddingValue", "FloatPixelPaddingValue", "DoubleFloatPixelPaddingValue")
    given = next((dataset.get(name) for name in names if dataset.get(name) is not None), None)
    try:
        first, last = float(given), float(dataset.get("PixelPaddingRangeLimit", given))  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return values
    bits = int(dataset.get("BitsStored", 16))
    if int(dataset.get("PixelRepresentation", 0)):  # some programs write negative numbers without their sign
        first, last = (one - 2.0**bits if one >= 2.0 ** (bits - 1) else one for one in (first, last))
    absent = (stored >= min(first, last)) & (stored <= max(first, last))
    return np.where(absent, np.float64(NO_DATA_VALUE), values) if absent.any() else values


def _unpack_pixels(dataset: Any, frame: DicomFrame, name: str) -> Numbers:
    """Unpack the stored values of an image, shape (rows, columns) or (rows, columns, 3)."""
    from pydicom import encaps
    from pydicom.pixels.utils import pixel_array

    if not any(kind in dataset for kind in _PIXEL_ENTRIES):
        raise UnreadableError(f"{name} contains no DICOM image: choose another file or folder.")
    try:
        return np.asarray(pixel_array(dataset, index=frame.index))
    except Exception as error:  # decoders raise exceptions of any kind; another package may be able to decode it
        syntax = dataset.file_meta.TransferSyntaxUID
        colors = dataset.get("PhotometricInterpretation")
        codec = (
            _JPEG_DECODERS.get(str(syntax).removeprefix(_JPEG_SYNTAX_PREFIX))
            if str(syntax).startswith(_JPEG_SYNTAX_PREFIX)
            else None
        )
        if codec is None and "missing dependencies" in str(error):
            raise UnreadableError(
                f"{name} is packed as {make_printable(str(syntax.name))[:80]}, which is not read: "
                "save it without packing."
            ) from error
        unpacked = ("RGB", "YBR_RCT", "YBR_ICT")  # the last two by JPEG 2000 itself
        colored = int(dataset.get("SamplesPerPixel", 1)) != 1 and colors not in unpacked
        if codec is None or colored:
            raise
    require_package("imagecodecs", name)
    import imagecodecs  # only here, because it takes long to import

    count = int(dataset.get("NumberOfFrames", 1) or 1)
    content = encaps.get_frame(dataset.PixelData, frame.index, number_of_frames=count)
    found = np.asarray(getattr(imagecodecs, codec)(content))
    if int(dataset.get("PixelRepresentation", 0)) and found.dtype.kind == "u":  # the first of its bits is the sign
        half = 1 << (int(dataset.BitsStored) - 1)
        return (found.astype(np.int32) & (2 * half - 1) ^ half) - half
    return found
