"""Formats: one module reads or writes one kind of file; this one chooses among them.

A reader module looks like `Reader`, a writer module like `Writer`. A new format is a new module of its own and a place
in one of the tuples below.
"""

from __future__ import annotations

import logging
import os
import stat
import warnings
from pathlib import Path
from typing import Protocol

from cpm_core.contours.result import Result
from cpm_core.formats.atomic import check_place, write_together
from cpm_core.formats.contours import (
    coco,
    contour_csv,
    contour_json,
    dxf,
    geojson,
    imagej,
    imagej_rois,
    labelme,
    measures_csv,
    svg,
)
from cpm_core.formats.contours.contour_files import CONTOURS_READABLE, load_contours
from cpm_core.formats.contours.points_csv import load_points
from cpm_core.formats.images import numpy_array, raster, tiff
from cpm_core.formats.images.decoded import Decoded, UnreadableError
from cpm_core.formats.masks import branch_mask, label_mask, label_tiff, nifti, nifti_packed
from cpm_core.image.image import Image
from cpm_core.medial_axis.skeleton import Skeleton

__all__ = [
    "CONTOURS_READABLE",
    "READABLE",
    "WRITABLE",
    "check_export",
    "encoded",
    "export",
    "load_contours",
    "load_image",
    "load_points",
    "suffix_of",
]


class Reader(Protocol):
    """What a module that reads images has."""

    READS: dict[str, str]
    """Suffix -> what such a file is."""

    def recognises(self, head: bytes, /) -> bool:
        """Tell from the first bytes of a file whether it is for this reader."""

    def read(self, path: Path) -> Decoded:
        """Read a file; damaged ones may raise anything."""


class Writer(Protocol):
    """What a module that writes results has."""

    WRITES: dict[str, str]
    """Suffix -> what is written."""

    def encode(self, result: Result, /) -> bytes:
        """Make the bytes of the file; ValueError when the result holds nothing that it could show."""


class SkeletonWriter(Protocol):
    """What a module that writes skeletons has: the same for them."""

    WRITES: dict[str, str]

    def encode(self, skeleton: Skeleton, /) -> bytes:
        """Make the bytes of the file; ValueError when the skeleton has nothing that it could show."""


_READERS: tuple[Reader, ...] = (tiff, numpy_array, raster)  # the last one takes what no other recognises
_BOTH = (
    contour_csv,
    measures_csv,
    contour_json,
    geojson,
    imagej_rois,
    imagej,
    labelme,
    coco,
    label_tiff,
    nifti,
    nifti_packed,
    dxf,
)
"""Writers that make of a skeleton what they make of a result."""

_WRITERS: tuple[Writer, ...] = (svg, *_BOTH, label_mask)
_SKELETON_WRITERS: tuple[SkeletonWriter, ...] = (svg, *_BOTH, branch_mask)  # of the same suffixes
_HEAD = 16
_LOG = logging.getLogger(__name__)

READABLE: dict[str, str] = {suffix: text for reader in _READERS for suffix, text in reader.READS.items()}
"""Suffixes of the images that can be read -> what they are. A file is known by its content, whatever its suffix."""

WRITABLE: dict[str, str] = {suffix: text for writer in _WRITERS for suffix, text in writer.WRITES.items()}
"""Suffixes that a result can be exported to, some of two parts -> what is written."""


def load_image(path: str | os.PathLike[str]) -> Image:
    """Read an image file.

    Parameters
    ----------
    path : path-like
        A file of one of the kinds in `READABLE`.

    Returns
    -------
    Image
        Its grey levels in the range of the file (16 bits stay 16 bits), colour turned into luminance, the size of a
        pixel where the file tells it, and in ``notes`` what was changed.

    Raises
    ------
    ValueError
        When there is no such file, or it cannot be used; one sentence that names it and says what to do.
    """
    file = Path(path)
    head = _head(file)
    reader = next(reader for reader in _READERS if reader.recognises(head))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # what a decoder finds odd but readable is no concern of the user
            decoded: Decoded = reader.read(file)
    except UnreadableError:
        raise
    except MemoryError:
        raise ValueError(f"{file.name} does not fit into memory: crop it or make it smaller first.") from None
    except Exception as error:  # decoders raise anything at all on damaged files, and all of it means the same
        _LOG.info("%s: %s: %s", file, type(error).__name__, error)
        raise ValueError(
            f"{file.name} is damaged, cut short or of an unknown kind: get a sound copy of it, "
            "or save it anew as PNG or TIFF."
        ) from error
    return Image(decoded.values, decoded.spacing, decoded.unit, file.name, decoded.notes)


def export(result: Result | Skeleton, *paths: str | os.PathLike[str]) -> None:
    """Write the contours of a result, or a skeleton, in the format that each suffix names.

    Everything is made before anything is written, and each file takes its place in one stroke, so that nothing
    half-written is ever left behind.

    Parameters
    ----------
    result : Result or Skeleton
        Outcome of a run, or of `skeleton`.
    *paths : path-like
        Files to write; see `WRITABLE` for the suffixes. Files that exist are replaced.

    Raises
    ------
    ValueError
        When a suffix is not known, a file cannot be written there, or the result holds nothing such a file could show.
    """
    files = [Path(path) for path in paths]
    for file in files:
        check_export(file)
    write_together([(file, encoded(result, suffix_of(file))) for file in files])


def encoded(result: Result | Skeleton, suffix: str) -> bytes:
    """Make what `export` would write, for the clipboard or for wherever there is no file.

    Parameters
    ----------
    result : Result or Skeleton
        Outcome of a run, or of `skeleton`.
    suffix : str
        One of `WRITABLE`. What is text is UTF-8.

    Returns
    -------
    bytes
        Content of the file.

    Raises
    ------
    ValueError
        When the suffix is not known, or the result holds nothing such a file could show.
    """
    writers = _SKELETON_WRITERS if isinstance(result, Skeleton) else _WRITERS
    writer = next((writer for writer in writers if suffix in writer.WRITES), None)
    if writer is None:
        raise ValueError(f'"{suffix}" says no format that can be written: choose one of {_known()}.')
    # of the two kinds of writers the one for this kind of result was taken
    return writer.encode(result)  # type: ignore[arg-type]


def suffix_of(path: str | os.PathLike[str]) -> str:
    """Suffix of `WRITABLE` that a file's name ends in, in small letters.

    Of several the longest counts, so that ``a.coco.json`` is no plain ``.json``; a name that is nothing but a suffix
    has none.

    Returns
    -------
    str
        The suffix; empty when no format is known by it.
    """
    name = Path(path).name.lower()
    suffix = max((suffix for suffix in WRITABLE if name.endswith(suffix)), key=len, default="")
    return suffix if len(suffix) < len(name) else ""


def check_export(path: str | os.PathLike[str]) -> None:
    """Tell beforehand whether `export` could write to a path.

    Raises
    ------
    ValueError
        When the suffix is not known, the folder does not exist or must not be written to, or the path is a folder.
    """
    file = Path(path)
    if not suffix_of(file) and not file.is_dir():
        named = f'ends in "{file.suffix}"' if file.suffix and file.suffix not in WRITABLE else "has no suffix"
        raise ValueError(f"{file.name} {named}, which says no format that can be written: choose one of {_known()}.")
    check_place(file)


def _known() -> str:
    """All formats that can be written, in words."""
    return ", ".join(f"{suffix} ({text})" for suffix, text in WRITABLE.items())


def _head(file: Path) -> bytes:
    """First bytes of a file, once it is certain to be one that can be read."""
    try:
        kind = file.stat().st_mode
        if stat.S_ISDIR(kind):
            raise UnreadableError(f"{file} is a folder: choose an image file in it.")
        if not stat.S_ISREG(kind):
            raise UnreadableError(f"{file} is not an ordinary file: choose an image file.")
        with file.open("rb") as stream:
            head = stream.read(_HEAD)
    except FileNotFoundError:
        raise ValueError(f"{file} does not exist: check its name and folder.") from None
    except PermissionError:
        raise ValueError(f"{file} must not be read by you: ask its owner for permission, or copy it.") from None
    except OSError as error:
        raise ValueError(f"{file} cannot be read: {error.strerror or error}.") from error
    if not head:
        raise ValueError(f"{file.name} is empty: get a sound copy of it.")
    return head
