"""Readers of images and volumes: the content of a file selects its reader, not its suffix.

A new reader is a module with the members of `ImageReader` and an entry in `_IMAGE_READERS`.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.formats.common.content import (
    AnyPath,
    AnySource,
    UnreadableError,
    compute_fingerprint,
    explain_decoding_errors,
    find_local_file,
    read_content,
)
from cpm_core.formats.common.printable import make_printable
from cpm_core.formats.images import (
    dicom,
    metaimage,
    microscopy,
    nifti,
    nrrd,
    numpy_array,
    ome_zarr,
    raster,
    resolution,
    tiff,
)
from cpm_core.formats.images.decoded import DecodedImage
from cpm_core.formats.images.multiscale import MultiscaleImage
from cpm_core.formats.images.reading import Reading, check_unit
from cpm_core.formats.images.stack import PageAxis, Pages, Stack, read_plane, read_volume
from cpm_core.image.colors import LUMINANCE_CHOICE, LUMINANCE_NOTE, gray_from_color
from cpm_core.image.gray_levels import NO_DATA_VALUE, no_data_note
from cpm_core.image.image import MINIMUM_SIDE, Image
from cpm_core.numerics.real_numbers import as_real_array
from cpm_core.numerics.types import Callback, JsonDict


class ImageReader(Protocol):
    """A module that reads one format of images."""

    FILE_KINDS: dict[str, str]
    """Suffix -> kind of file."""

    def can_read(self, head: bytes, path: Path, /) -> bool:
        """Return whether a file is of this format, by its first 512 bytes (all of a shorter file) and its path."""

    def open_image_file(self, path: Path, reading: Reading, /) -> Stack:
        """Open a file of one or several planes; a damaged one may raise any exception."""


_IMAGE_READERS: dict[ImageReader, str] = {
    dicom: "a DICOM file",
    tiff: "a TIFF",
    microscopy: "a file of a microscope",
    numpy_array: "a NumPy array",
    nifti: "a NIfTI or Analyze volume",
    nrrd: "an NRRD volume",
    metaimage: "a MetaImage volume",
    raster: "a picture",
}
"""Readers in the order they are tried -> what they read; DICOM may begin like TIFF, and the last takes the rest."""

_SIGNATURE_SIZE = 512
"""Bytes that identify a format; signatures of medical formats are at 128 (DICOM) and 344 (NIfTI)."""

_FOREIGN_SIGNATURES: tuple[tuple[int, bytes, str], ...] = (
    (0, b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "an OIB or ZVI file of a microscope, or a document"),
    (0, b"\x89HDF\r\n\x1a\n", "an HDF5 file"),
    (0, b"CDF", "a MINC or NetCDF file"),
    (0, b"MATLAB 5.0 MAT-file", "a MATLAB file"),
    (4, b"ftyphei", "a HEIC picture"),
    (4, b"ftyp", "a video"),
    (0, b"SIMPLE  =", "a FITS image"),
    (0, b"PK\x03\x04", "an archive of files (ZIP)"),
    (0, b"\x1f\x8b", "a packed file (gzip)"),
    (0, b"%PDF-", "a PDF document"),
    (0, b"8BPS", "a Photoshop picture"),
    (0, b"\0\5\x16\7", "what macOS keeps beside a file"),
    (0, b"<", "an SVG drawing or another XML file"),
)
"""Offset, signature and description of kinds of files that are known but not read."""

IMAGES_READABLE: dict[str, str] = {
    suffix: text
    for kinds in (*(reader.FILE_KINDS for reader in _IMAGE_READERS), ome_zarr.FILE_KINDS)
    for suffix, text in kinds.items()
}
"""Suffixes of readable images -> what they are; the content of a file decides, not its suffix."""


def is_image_name(name: str) -> bool:
    """Return whether a file in a folder is an image by its name; hidden ones, such as ._NAME of macOS, are none."""
    return Path(name).suffix.lower() in IMAGES_READABLE and not name.startswith(".")


def load_image(
    path: AnySource,
    *,
    page: int | None = None,
    channel: int | None = None,
    time: int | None = None,
    series: int | str | None = None,
    color: str = "luminance",
    spacing: ArrayLike | None = None,
    unit: str | None = None,
    check_cancelled: Callback | None = None,
) -> Image:
    """Read an image file, one plane of a file of several.

    Parameters
    ----------
    path : path-like or file-like
        A file of one of the kinds in `IMAGES_READABLE`, or a folder with the slices of a DICOM series; an open file; or
        an address of fsspec, such as ``s3://bucket/name.tif`` or ``zip::https://host/names.zip``.
    page : int, optional
        Plane, page or frame, from 1; by default the first page or frame, or the middle plane of a volume.
    channel, time : int, optional
        Channel and point in time, from 1; by default the first.
    series : int or str, optional
        Series of a TIFF or of a folder, or array of an archive, by number from 1 or by name.
    color : {"luminance", "red", "green", "blue", "contrast"}, optional
        Gray levels of color images: the brightness to the eye, one of the channels, or the channel whose gray levels
        vary the most.
    spacing : float or sequence of float, optional
        Size of a pixel, one number or along (row, col), shape (2,), overriding that of the file.
    unit : str, optional
        Unit of `spacing`: nm, µm, mm, cm or m.
    check_cancelled : callable, optional
        Called between the parts of a long file while it is hashed; it may raise to stop.

    Returns
    -------
    Image
        Gray levels in the range of the file, shape (H, W), pixel size and position in space if the file states them,
        the hash of the file, and ``notes`` on changes and on further contents of the file.

    Raises
    ------
    ValueError
        When there is no such file, or it cannot be used or read again for its hash; one sentence with its name and
        what to do.

    Examples
    --------
    >>> np.save("disk.npy", cpm.example("disk").values)
    >>> cpm.load_image("disk.npy", spacing=0.5, unit="µm")
    <Image disk.npy, 64 x 64 px, 0.5 µm a pixel>
    """
    reading = Reading(page, channel, time, series, color, _parse_spacing(spacing), unit)
    return _load_part(find_local_file(path), reading, read_plane, check_cancelled)


def load_volume(
    path: AnySource,
    *,
    channel: int | None = None,
    time: int | None = None,
    series: int | str | None = None,
    color: str = "luminance",
    spacing: ArrayLike | None = None,
    unit: str | None = None,
    check_cancelled: Callback | None = None,
) -> Image:
    """Read a volume.

    Parameters
    ----------
    path : path-like or file-like
        A stack or volume, as for `load_image`.
    channel, time, series, color, unit, check_cancelled
        As for `load_image`.
    spacing : float or sequence of float, optional
        Size of a voxel, one number or along (plane, row, col), shape (3,), overriding that of the file.

    Returns
    -------
    Image
        Gray levels of shape (P, H, W): in medical files rows run along the second axis of the file, and planes along
        the third. ``notes`` list further contents of the file.

    Raises
    ------
    ValueError
        When there is no such file, or it cannot be used; one sentence with its name and what to do.

    Examples
    --------
    >>> np.save("ball.npy", cpm.example("ball").values)
    >>> cpm.load_volume("ball.npy", spacing=(2.0, 1.0, 1.0), unit="mm")
    <Image ball.npy, 31 x 31 x 31 voxels, 2 x 1 x 1 mm a voxel>
    """
    reading = Reading(None, channel, time, series, color, _parse_spacing(spacing), unit)
    return _load_part(find_local_file(path), reading, read_volume, check_cancelled)


def load_pages(
    path: AnySource,
    *,
    channel: int | None = None,
    time: int | None = None,
    series: int | str | None = None,
    color: str = "luminance",
    spacing: ArrayLike | None = None,
    unit: str | None = None,
    check_cancelled: Callback | None = None,
) -> Pages:
    """Open a stack or a time series whose pages are images of their own.

    Parameters
    ----------
    path, channel, time, series, color, spacing, unit, check_cancelled
        As for `load_image`.

    Returns
    -------
    Pages
        A sequence of `Image`, each read on demand and none kept: the planes at one time, the points in time of a single
        plane, or else the channels. A still picture has one page.

    Raises
    ------
    ValueError
        When there is no such file, or it cannot be used; an unusable page raises it when it is read.

    Examples
    --------
    >>> np.save("pages.npy", np.stack([cpm.example("disk").values, cpm.example("ring").values]))
    >>> pages = cpm.load_pages("pages.npy")
    >>> len(pages), pages[1].shape
    (2, (64, 64))
    """
    file, reading = find_local_file(path), Reading(None, channel, time, series, color, _parse_spacing(spacing), unit)
    with explain_image_errors(file):
        stack = _open_file(file, reading)
    sha256 = _hash_file(file, check_cancelled)
    axes: tuple[tuple[str, PageAxis, int], ...] = (
        ("page", "z", stack.shape[0]),
        ("time", "t", stack.times if time is None else 1),
        ("channel", "c", stack.channels if channel is None and not stack.has_colors else 1),
    )
    name, axis, count = next((one for one in axes if one[2] > 1), axes[0])

    def read_page(number: int) -> Image:
        chosen: JsonDict = {name: number}
        one = replace(reading, **chosen)
        with explain_image_errors(file):
            decoded = read_plane(stack, one)
        return _build_image(decoded, file, one, sha256)

    return Pages(
        make_printable(file.name),
        count,
        read_page,
        "frame" if stack.plane_word == "frame" else "page",
        axis,
        sum(length > 1 for length in (stack.shape[0], stack.times, stack.channels)) < 2,
        sha256,
        stack.interval if axis == "t" else None,
    )


def holds_volume(path: AnySource, series: int | str | None = None) -> bool:
    """Return whether a file holds enough planes for a volume; ValueError as for `load_volume`."""
    return open_stack(path, series).shape[0] >= MINIMUM_SIDE


def open_stack(path: AnySource, series: int | str | None = None) -> Stack:
    """Open a file without reading any of its planes.

    Parameters
    ----------
    path, series
        As for `load_volume`.

    Returns
    -------
    Stack
        Numbers of planes, channels and points in time, names of the series, and voxel size.

    Raises
    ------
    ValueError
        As for `load_volume`; `UnreadableError` when an archive holds several images and none is chosen.
    """
    file = find_local_file(path)
    with explain_image_errors(file):
        return _open_file(file, Reading(series=series))


def open_levels(path: AnyPath, reading: Reading) -> MultiscaleImage | None:
    """Open all resolutions of an image that is read in parts; None for other images."""
    file = Path(path)
    with explain_image_errors(file):
        return _open_file(file, reading).levels


def _parse_spacing(spacing: ArrayLike | None) -> tuple[float, ...] | None:
    """Parse the spacing of an argument."""
    return None if spacing is None else tuple(np.ravel(as_real_array(spacing)).tolist())


def _load_part(
    file: Path, reading: Reading, read_part: Callable[[Stack, Reading], DecodedImage], check_cancelled: Callback | None
) -> Image:
    """Load a part of a file as an image, hashing the file meanwhile."""
    with ThreadPoolExecutor(1) as other, explain_image_errors(file):
        stack = _open_file(file, reading)
        sha256 = other.submit(_hash_file, file, check_cancelled)
        decoded = read_part(stack, reading)
    return _build_image(decoded, file, reading, sha256.result())


def load_channel(path: AnyPath, reading: Reading, in_volume: bool, sha256: str) -> Image:
    """Read a channel of a file whose hash is known, as a volume or as an image; ValueError as for `load_image`."""
    file = Path(path)
    with explain_image_errors(file):
        decoded = (read_volume if in_volume else read_plane)(_open_file(file, reading), reading)
    return _build_image(decoded, file, reading, sha256)


def _build_image(decoded: DecodedImage, file: Path, reading: Reading, sha256: str) -> Image:
    """Build the image, with the gray levels and the pixel size that were requested."""
    values, notes, colors = decoded.values, decoded.notes, decoded.colors
    spacing, unit, geometry = decoded.spacing, decoded.unit, decoded.geometry
    if reading.color != LUMINANCE_CHOICE and colors is not None:
        values, note = gray_from_color(values, colors, reading.color)
        notes, colors = tuple(note if one == LUMINANCE_NOTE else one for one in notes), None
    if reading.spacing is not None:
        given = reading.spacing
        spacing, unit = given * values.ndim if len(given) == 1 else given, check_unit(reading.unit)
        if geometry is not None and unit and decoded.unit:
            geometry = geometry.scaled(resolution.conversion_factor(decoded.unit, unit))
    if values.dtype == np.float64 and np.all(values == NO_DATA_VALUE):  # a plane outside the recorded range
        notes = (*notes, no_data_note(values.size))
        values = np.zeros(values.shape)
    name, known = make_printable(file.name), decoded.hounsfield
    return Image(
        values, spacing, unit, name, notes, colors, sha256, geometry, hounsfield=known, finer=decoded.finer,
        window=decoded.window,
    )  # fmt: skip


def _hash_file(file: Path, check_cancelled: Callback | None) -> str:
    """Return the hash of a file; empty for a folder."""
    return "" if os.path.isdir(file) else compute_fingerprint(file, check_cancelled)  # noqa: PTH112 - raises nothing


def explain_image_errors(file: Path) -> AbstractContextManager[None]:
    """Explain decoding errors of a file in a sentence, which calls it what its content or its name says."""

    def describe_damage() -> str:
        reader, advice = _find_reader(file), "get a sound copy of it, or save it again"
        if reader is raster:
            return f"is damaged, cut short or of an unknown kind: {advice} as PNG or TIFF."
        return (
            f"is damaged or cut short, or {_IMAGE_READERS[reader]} of an unknown kind: {advice} with the program that "
            "made it."
        )

    return explain_decoding_errors(make_printable(file.name), describe_damage)


def _find_reader(file: Path) -> ImageReader:
    """Find the reader of a file that cannot be read: by its content, or where that says nothing by its name."""
    try:
        head = read_content(file, head_size=_SIGNATURE_SIZE)
        reader = next(reader for reader in _IMAGE_READERS if reader.can_read(head, file))
    except ValueError:  # a folder
        reader = raster
    named = (one for one in _IMAGE_READERS if file.name.lower().endswith(tuple(one.FILE_KINDS)))
    return next(named, raster) if reader is raster else reader


def _find_header(file: Path) -> Path:
    """Find the header of a file with the values of a pair of NIfTI or Analyze; any other file is its own."""
    header = file.with_suffix(".HDR" if file.suffix.isupper() else ".hdr")
    if file.suffix.lower() != ".img" or not header.is_file():
        return file
    head = read_content(header, head_size=_SIGNATURE_SIZE)
    return header if nifti.can_read(head, header) else file


def _open_file(file: Path, reading: Reading) -> Stack:
    """Open a file with the reader for its content."""
    if dicom.holds_dicom_series(file):
        return dicom.open_image_file(file, reading)
    if ome_zarr.is_zarr(file):
        return ome_zarr.open_image_file(file, reading)
    if dicom.holds_dicom_series_below(file):
        return dicom.open_image_file(file, reading)
    file = _find_header(file)
    head = read_content(file, head_size=_SIGNATURE_SIZE)
    if not head:
        raise UnreadableError(f"{file.name} is empty: get a sound copy of it.")
    reader = next(reader for reader in _IMAGE_READERS if reader.can_read(head, file))
    kind = next((kind for place, mark, kind in _FOREIGN_SIGNATURES if head.startswith(mark, place)), None)
    if reader is raster and kind is not None:
        raise UnreadableError(
            f"{file.name} is {kind}, and CPM does not read those: save the image or volume that you want as TIFF, "
            "with the program that made it."
        )
    return reader.open_image_file(file, reading)
