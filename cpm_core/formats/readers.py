"""Readers of images: the content of a file selects its reader, not its suffix.

A new reader is a module with the interface `Reader`, and an entry in `_READERS`.
"""

from __future__ import annotations

import logging
import os
import stat
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from cpm_core.formats.fingerprint import fingerprint
from cpm_core.formats.images import foreign, numpy_array, raster, tiff
from cpm_core.formats.images.decoded import Decoded, UnreadableError
from cpm_core.formats.printable import printable
from cpm_core.image.image import Image


class Reader(Protocol):
    """Interface of a module that reads images."""

    READS: dict[str, str]
    """Suffix -> what such a file is."""

    def reads(self, head: bytes, path: Path, /) -> bool:
        """Whether the file is of this format, by its first 512 bytes (all of a shorter file) and its path."""

    def read(self, path: Path) -> Decoded:
        """Read a file; damaged ones may raise anything."""


_READERS: tuple[Reader, ...] = (tiff, numpy_array, foreign, raster)  # the last one takes what no other reads
_HEAD = 512
"""Bytes that identify a format: the signatures of medical formats are at 128 (DICOM) and 344 (NIfTI)."""

_LOG = logging.getLogger(__name__)

READABLE: dict[str, str] = {suffix: text for reader in _READERS for suffix, text in reader.READS.items()}
"""Suffixes of the images that can be read -> what they are. The content of a file decides, not its suffix."""


def load_image(path: str | os.PathLike[str], go_on: Callable[[], object] | None = None) -> Image:
    """Read an image file.

    Parameters
    ----------
    path : path-like
        A file of one of the kinds in `READABLE`.
    go_on : callable, optional
        Called between the parts of a long file while its hash is made; it may raise to stop.

    Returns
    -------
    Image
        Its gray levels in the range of the file (16 bits stay 16 bits), color turned into luminance, the size of a
        pixel where the file gives it, the hash of the file, and in ``notes`` what was changed.

    Raises
    ------
    ValueError
        When there is no such file, or it cannot be used or read again for its hash; one sentence with its name and
        what to do.
    """
    file = Path(path)
    head = _head(file)
    reader = next(reader for reader in _READERS if reader.reads(head, file))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # oddities of a readable file do not concern the user
            decoded: Decoded = reader.read(file)
    except UnreadableError:
        raise
    except MemoryError:
        raise ValueError(f"{file.name} does not fit into memory: crop it or make it smaller first.") from None
    except Exception as error:  # decoders raise exceptions of any kind on damaged files
        _LOG.info("%s: %s: %s", file, type(error).__name__, error)
        if foreign.reads(head, file):  # a DICOM file may begin as a TIFF does, and need not be one as well
            foreign.read(file)
        raise ValueError(
            f"{file.name} is damaged, cut short or of an unknown kind: get a sound copy of it, "
            "or save it again as PNG or TIFF."
        ) from error
    name, sha256 = printable(file.name), fingerprint(file, go_on)
    return Image(decoded.values, decoded.spacing, decoded.unit, name, decoded.notes, decoded.colors, sha256)


def _head(file: Path) -> bytes:
    """First bytes of a file; ValueError unless it is a regular file that can be read."""
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
        raise ValueError(f"{file} cannot be read, because you have no permission: ask its owner for it.") from None
    except OSError as error:
        raise ValueError(f"{file} cannot be read: {error.strerror or error}.") from error
    if not head:
        raise ValueError(f"{file.name} is empty: get a sound copy of it.")
    return head
