"""Volumes: arrays of NumPy, TIFF stacks, and NIfTI where the package nibabel is installed."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import tifffile
from numpy.typing import NDArray

from cpm_core.formats.fingerprint import fingerprint
from cpm_core.formats.images.decoded import UnreadableError
from cpm_core.formats.printable import printable
from cpm_core.image.image import Image

READS: dict[str, str] = {
    ".npy": "NumPy array (P, H, W)",
    ".npz": "the only such array in an archive of NumPy",
    ".tif": "TIFF stack",
    ".tiff": "TIFF stack",
    ".nii": "NIfTI volume",
    ".nii.gz": "NIfTI volume",
}
"""Suffixes of the volumes that can be read -> what they are."""


class _Stored(NamedTuple):
    """Values of a file, the sides of a voxel along (plane, row, col), and their unit."""

    values: NDArray[Any]
    spacing: tuple[float, ...] = ()
    unit: str | None = None


def load_volume(path: str | os.PathLike[str], go_on: Callable[[], object] | None = None) -> Image:
    """Read a volume.

    Parameters
    ----------
    path : path-like
        A file of one of the kinds in `READS`. The axes of a NIfTI volume are taken in the order in which they are
        stored.
    go_on : callable, optional
        Called while the hash of a long file is made; it may raise to stop.

    Returns
    -------
    Image
        With three axes (plane, row, col), and the size of a voxel where the file gives it.

    Raises
    ------
    ValueError
        When there is no such file, or it cannot be used; one sentence with its name and what to do.
    """
    file = Path(path)
    name = printable(file.name)
    read = next((one for suffix, one in _READERS.items() if file.name.lower().endswith(suffix)), None)
    if read is None:
        raise ValueError(f"{name} is of no kind of volume that can be read: save it as {', '.join(READS)}.")
    try:
        stored = read(file)
    except UnreadableError:
        raise
    except FileNotFoundError:
        raise ValueError(f"{file} does not exist: check its name and folder.") from None
    except OSError as error:
        raise ValueError(f"{file} cannot be read: {error.strerror or error}.") from error
    except Exception as error:  # decoders raise exceptions of any kind on damaged files
        raise ValueError(f"{name} is damaged or of an unknown kind: get a sound copy of it.") from error
    if not stored.values.size:
        raise ValueError(f"{name} is damaged or empty: get a sound copy of it.")
    if stored.values.ndim != 3:
        raise ValueError(
            f"{name} has the shape {stored.values.shape}, but a volume has three, "
            "(planes, rows, columns): use an image with --circle instead, or save one volume of it."
        )
    return Image(stored.values, stored.spacing, stored.unit, name, file_sha256=fingerprint(file, go_on))


def _array(file: Path) -> _Stored:
    return _Stored(np.load(file, mmap_mode="r", allow_pickle=False))


def _archive(file: Path) -> _Stored:
    with np.load(file, allow_pickle=False) as archive:
        found = [key for key in archive.files if archive[key].ndim == 3]
        if len(found) != 1:
            raise UnreadableError(
                f"{printable(file.name)} holds {len(found)} volumes, but must hold one: save it as a file of its own."
            )
        return _Stored(archive[found[0]])


def _tiff(file: Path) -> _Stored:
    with tifffile.TiffFile(file) as stack:
        return _Stored(np.asarray(stack.asarray(maxworkers=1)))


def _nifti(file: Path) -> _Stored:
    try:
        import nibabel  # noqa: PLC0415 - it need not be installed
    except ImportError:
        raise UnreadableError(
            f"{printable(file.name)} is a NIfTI volume, which needs the package nibabel: install it (pip install "
            "nibabel), or save the volume as a NumPy array."
        ) from None
    volume: Any = nibabel.load(file)
    values = np.asanyarray(volume.dataobj)
    values = values.reshape([n for n in values.shape if n > 1] if values.ndim > 3 else values.shape)
    return _Stored(values, tuple(float(side) for side in volume.header.get_zooms()[: values.ndim]), "mm")


_READERS = {
    ".npy": _array,
    ".npz": _archive,
    ".tif": _tiff,
    ".tiff": _tiff,
    ".nii": _nifti,
    ".nii.gz": _nifti,
}
