"""Readers of images and volumes: the content of a file selects its reader, not its suffix.

A new reader is a module with the interface `Reader`, and an entry in `_READERS`.
"""

from __future__ import annotations

import logging
import os
import stat
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.formats.common.content import fingerprint
from cpm_core.formats.common.printable import printable
from cpm_core.formats.images import foreign, numpy_array, resolution
from cpm_core.formats.images.choice import Choice
from cpm_core.formats.images.decoded import Decoded, UnreadableError
from cpm_core.formats.images.medical import metaimage, nifti, nrrd
from cpm_core.formats.images.medical.dicom import reader as dicom
from cpm_core.formats.images.reading import checked_unit
from cpm_core.formats.images.stacks import frames, tiff_stack
from cpm_core.formats.images.stacks.pages import Axis, Pages
from cpm_core.formats.images.stacks.stack import Stack, plane_of, volume_of
from cpm_core.image.colors import LUMINANCE, LUMINANCE_NOTE, checked_color, in_color
from cpm_core.image.gray_levels import NO_DATA, no_data_note
from cpm_core.image.image import MINIMUM_SIDE, Image
from cpm_core.numerics.real_numbers import real_numbers
from cpm_core.parameters.quotation import shown


class Reader(Protocol):
    """Interface of a module that reads images."""

    FORMAT: str
    """Name of the format of all its files; empty where it reads several, or none."""

    READS: dict[str, str]
    """Suffix -> what such a file is."""

    def reads(self, head: bytes, path: Path, /) -> bool:
        """Whether the file is of this format, by its first 512 bytes (all of a shorter file) and its path."""

    def read(self, path: Path, choice: Choice, /) -> Decoded:
        """Read an image, of a file of several planes one of them; damaged files may raise anything."""

    def stack(self, path: Path, choice: Choice, /) -> Stack:
        """Open a file of several planes, of a picture that stands still its only one."""


# dicom comes first, because a DICOM file may begin as a TIFF does; the last one takes what no other reads
_READERS: tuple[Reader, ...] = (dicom, tiff_stack, numpy_array, nifti, nrrd, metaimage, foreign, frames)
_HEAD = 512
"""Bytes that identify a format: the signatures of medical formats are at 128 (DICOM) and 344 (NIfTI)."""

_AXES: dict[str, Axis] = {"page": "z", "time": "t", "channel": "c"}

_LOG = logging.getLogger(__name__)

READABLE: dict[str, str] = {suffix: text for reader in _READERS for suffix, text in reader.READS.items()}
"""Suffixes of the images that can be read -> what they are. The content of a file decides, not its suffix."""


def load_image(
    path: str | os.PathLike[str],
    go_on: Callable[[], object] | None = None,
    *,
    page: int | None = None,
    channel: int | None = None,
    time: int | None = None,
    series: int | str | None = None,
    color: str = "luminance",
    spacing: ArrayLike | None = None,
    unit: str | None = None,
) -> Image:
    """Read an image file, of a file of several planes one of them.

    Parameters
    ----------
    path : path-like
        A file of one of the kinds in `READABLE`, or a folder with the slices of a DICOM series.
    go_on : callable, optional
        Called between the parts of a long file while it is hashed; it may raise to stop.
    page : int, optional
        Which plane, page or frame, from 1; by default the first page or frame, and the middle plane of a volume.
    channel, time : int, optional
        Which channel and which point in time, from 1; by default the first.
    series : int or str, optional
        Which series of a TIFF or of a folder, which array of an archive, by number from 1 or by name.
    color : {"luminance", "red", "green", "blue", "contrast"}, optional
        What gray levels are made of color: how bright it is to the eye, one of its channels, or the channel whose gray
        levels vary the most.
    spacing : float or sequence of float, optional
        Size of a pixel, or along (row, col), in place of what the file tells.
    unit : str, optional
        Unit of `spacing`: nm, µm, mm, cm or m.

    Returns
    -------
    Image
        Its gray levels in the range of the file, the size of a pixel and its place in space where the file gives them,
        the hash of the file, and in ``notes`` what was changed and what else the file holds.

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
    file, choice = Path(path), Choice(page, channel, time, series)
    decoded = _in(checked_color(color), _read(file, lambda reader: reader.read(file, choice)))
    return _image(decoded, file, _hash(file, go_on), spacing, unit)


def load_volume(
    path: str | os.PathLike[str],
    go_on: Callable[[], object] | None = None,
    *,
    channel: int | None = None,
    time: int | None = None,
    series: int | str | None = None,
    color: str = "luminance",
    spacing: ArrayLike | None = None,
    unit: str | None = None,
) -> Image:
    """Read a volume.

    Parameters
    ----------
    path : path-like
        A stack or volume of one of the kinds in `READABLE`, or a folder with the slices of a DICOM series.
    go_on, channel, time, series, color, unit
        As for `load_image`.
    spacing : float or sequence of float, optional
        Size of a voxel, or along (plane, row, col), in place of what the file tells.

    Returns
    -------
    Image
        With three axes (plane, row, col): in medical files rows run along the second axis of the file, and planes along
        the third. In ``notes`` it says what else the file holds.

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
    choice = Choice(None, channel, time, series)
    file = Path(path)
    decoded = _in(checked_color(color), _read(file, lambda reader: volume_of(reader.stack(file, choice), choice)))
    return _image(decoded, file, _hash(file, go_on), spacing, unit)


def load_pages(
    path: str | os.PathLike[str],
    go_on: Callable[[], object] | None = None,
    *,
    channel: int | None = None,
    time: int | None = None,
    series: int | str | None = None,
    color: str = "luminance",
    spacing: ArrayLike | None = None,
    unit: str | None = None,
) -> Pages:
    """Open a stack or a time series whose pages are images of their own.

    Parameters
    ----------
    path, go_on, channel, time, series, color, spacing, unit
        As for `load_image`.

    Returns
    -------
    Pages
        A sequence of `Image`, each read when it is asked for, and none kept: the planes at one time, of one plane the
        points in time, and where there are only channels, these. A picture that stands still has one page.

    Raises
    ------
    ValueError
        When there is no such file, or it cannot be used; a page that cannot be used raises it when it is asked for.

    Examples
    --------
    >>> np.save("pages.npy", np.stack([cpm.example("disk").values, cpm.example("ring").values]))
    >>> pages = cpm.load_pages("pages.npy")
    >>> len(pages), pages[1].shape
    (2, (64, 64))
    """
    file, wanted = Path(path), checked_color(color)
    opened: Stack = _read(file, lambda reader: reader.stack(file, Choice(None, channel, time, series)))
    sha256 = _hash(file, go_on)

    axis, count = _paged(opened, time, channel)

    def page(number: int) -> Image:
        chosen: dict[str, Any] = {"page": None, "channel": channel, "time": time, "series": series, axis: number}
        return _image(
            _in(wanted, _read(file, lambda _: plane_of(opened, Choice(**chosen)))), file, sha256, spacing, unit
        )

    return Pages(
        printable(file.name),
        count,
        page,
        word="frame" if opened.word == "frame" else "page",
        axis=_AXES[axis],
        alone=sum(length > 1 for length in (opened.shape[0], opened.times, opened.channels)) < 2,
        sha256=sha256,
    )


def _paged(stack: Stack, time: int | None, channel: int | None) -> tuple[str, int]:
    """What the pages of a stack are, as `Choice` names it, and how many there are."""
    if stack.shape[0] > 1:
        return "page", stack.shape[0]
    if stack.times > 1 and time is None:
        return "time", stack.times
    if stack.channels > 1 and channel is None:
        return "channel", stack.channels
    return "page", 1


def holds_volume(path: str | os.PathLike[str], series: int | str | None = None) -> bool:
    """Whether a file holds enough planes for a volume; ValueError as for `load_volume`."""
    return open_stack(path, series).shape[0] >= MINIMUM_SIDE


def open_stack(path: str | os.PathLike[str], series: int | str | None = None) -> Stack:
    """What a file holds, of whose planes none has been read yet.

    Parameters
    ----------
    path, series
        As for `load_volume`.

    Returns
    -------
    Stack
        How many planes, channels and points in time there are, the names of its series, and the size of a voxel.

    Raises
    ------
    ValueError
        As for `load_volume`; `UnchosenError` when an archive holds several images and none is chosen.
    """
    file = Path(path)
    opened: Stack = _read(file, lambda reader: reader.stack(file, Choice(series=series)))
    return opened


def _read(file: Path, do: Callable[[Reader], Any]) -> Any:
    """What the reader of a file makes of it; ValueError, one sentence, when it fails."""
    head = _head(file)
    reader = next(reader for reader in _READERS if reader.reads(head, file))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # oddities of a readable file do not concern the user
            return do(reader)
    except UnreadableError:
        raise
    except MemoryError:
        raise ValueError(f"{file.name} does not fit into memory: crop it or make it smaller first.") from None
    except Exception as error:  # decoders raise exceptions of any kind on damaged files
        _LOG.info("%s: %s: %s", file, type(error).__name__, error)
        named = (other.FORMAT for other in _READERS if file.name.lower().endswith(tuple(other.READS)))
        if kind := reader.FORMAT or next(named, ""):
            raise ValueError(
                f"{file.name} is a damaged {kind} file: get a sound copy of it, or save it again."
            ) from error
        raise ValueError(
            f"{file.name} is damaged, cut short or of an unknown kind: get a sound copy of it, "
            "or save it again as PNG or TIFF."
        ) from error


def _in(color: str, decoded: Decoded) -> Decoded:
    """What was read, in the gray levels of a channel of its colors."""
    if color == LUMINANCE or decoded.colors is None:
        return decoded
    values, said = in_color(decoded.values, decoded.colors, color)
    notes = tuple(said if note == LUMINANCE_NOTE else note for note in decoded.notes)
    return replace(decoded, values=values, colors=None, notes=notes)


def _image(decoded: Decoded, file: Path, sha256: str, spacing: ArrayLike | None, unit: str | None) -> Image:
    """The image of what was read, with the size of a pixel that is given, if one is."""
    sizes, named, geometry = decoded.spacing, decoded.unit, decoded.geometry
    if spacing is None and unit is not None:
        raise ValueError(f"unit is {shown(unit)} but there is no spacing: give the size of a pixel as well.")
    if spacing is not None:
        given = real_numbers(spacing)
        if given.ndim == 0:
            given = np.full(decoded.values.ndim, given.item())
        sizes, named = tuple(np.ravel(given).tolist()), checked_unit(unit)
        if geometry is not None and named and decoded.unit:
            geometry = geometry.scaled(resolution.factor(decoded.unit, named))
    name, values, notes = printable(file.name), decoded.values, decoded.notes
    if values.dtype == np.float64 and np.all(values == NO_DATA):  # a plane beyond what was recorded
        notes = (*notes, no_data_note(values.size))
        values = np.zeros(values.shape)
    return Image(values, sizes, named, name, notes, decoded.colors, sha256, geometry)


def _hash(file: Path, go_on: Callable[[], object] | None) -> str:
    """Hash of a file; none of a folder."""
    return "" if os.path.isdir(file) else fingerprint(file, go_on)  # noqa: PTH112 - raises nothing


def _head(file: Path) -> bytes:
    """First bytes of a file; ValueError unless it is a regular file that can be read."""
    try:
        kind = file.stat().st_mode
        if stat.S_ISDIR(kind):
            if dicom.is_series(file):
                return dicom.FOLDER
            raise UnreadableError(f"{file} is a folder: choose an image file in it.")
        if not stat.S_ISREG(kind):
            raise UnreadableError(f"{file} is not an ordinary file: choose an image file.")
        with file.open("rb") as stream:
            head = stream.read(_HEAD)
    except FileNotFoundError:
        raise ValueError(f"{file} does not exist: check its name and folder.") from None
    except PermissionError:
        raise ValueError(f"{file} cannot be read, because you have no permission: ask its owner for it.") from None
    except OSError as error:
        raise ValueError(f"{file} cannot be read: {error.strerror or error}.") from error
    if not head:
        raise ValueError(f"{file.name} is empty: get a sound copy of it.")
    return head
