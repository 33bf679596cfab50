"""Samples of volumes: one small sound file of each kind that is read, to be damaged."""

from __future__ import annotations

import gzip
import tempfile
import warnings
from pathlib import Path
from typing import Any

import nibabel
import nrrd
import numpy as np
import PIL.Image
import tifffile
from pydicom.uid import RLELossless

from tests.core.formats.images import made

from .encoders import Sample, numpy_array, tiff

SHAPE = (9, 10, 11)
_GRAY = (np.add.outer(np.arange(11) * 17, np.arange(14) * 13) % 251).astype(np.uint8)
VOLUME = (np.indices(SHAPE).sum(0) * 9 % 251).astype(np.uint8)


def _nifti(values: Any, sides: tuple[float, ...] = (0.5, 0.5, 2.0), kind: Any = nibabel.Nifti1Image) -> bytes:
    volume = kind(values, np.diag([*sides, 1.0]))
    volume.header.set_xyzt_units("mm", "sec")
    return bytes(volume.to_bytes())


def _of_medicine() -> list[Sample]:
    """Volumes as programs of medicine and microscopy write them; values in a file beside them are left out."""
    planes = np.stack([_GRAY + number for number in range(9)]).astype(np.int16)
    hyper = np.stack([[planes, planes + 1]] * 2).transpose(0, 2, 1, 3, 4)
    pages = [PIL.Image.fromarray(plane.astype(np.uint8)) for plane in planes]
    film = {"ImagePositionPatient": None, "NumberOfFrames": 9, "FrameTime": 40.0}
    packed = made.dataset(planes[0].astype(np.uint16), SliceThickness=2.0)
    packed.compress(RLELossless)
    slices = [made.dataset(planes[0], (0.0, 1.0, 2.0), made.OBLIQUE), made.dataset(planes, **film), packed]
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        made.write_nifti(place / "a.nii", planes)
        made.write_nifti(place / "a.nii.gz", planes)
        made.write_metaimage(place / "raw.mha", planes)
        made.write_metaimage(place / "packed.mha", planes, packed=True)
        made.write_metaimage(place / "apart.mhd", planes, beside="a.raw")
        for encoding in ("raw", "gzip", "bzip2", "ascii"):
            header = {"space": "LPS", "space directions": np.eye(3), "encoding": encoding}
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", DeprecationWarning)  # it asks for the time in an old way
                nrrd.write(str(place / f"{encoding}.nrrd"), planes, header, index_order="C")
        for number, slice_ in enumerate(slices):
            slice_.save_as(place / f"{number}.dcm", enforce_file_format=True)
        np.savez_compressed(place / "a.npz", volume=planes, size=np.ones(3))
        tifffile.imwrite(place / "a.tif", hyper.astype(np.uint16), imagej=True, metadata={"axes": "TZCYX"})
        tifffile.imwrite(place / "a.ome.tif", hyper.astype(np.uint16), metadata={"axes": "TZCYX"})
        pages[0].save(place / "a.png", save_all=True, append_images=pages[1:])
        files = [file for file in sorted(place.iterdir()) if file.suffix != ".raw"]
        return [Sample("".join(file.suffixes), file.read_bytes()) for file in files]


def volumes() -> list[Sample]:
    """The samples."""
    real = VOLUME.astype(np.float32) / np.float32(3.0)
    scaled = nibabel.Nifti1Image(VOLUME.astype(np.int16), np.eye(4))
    scaled.header.set_slope_inter(0.5, 3.0)
    turned = nibabel.Nifti1Image(VOLUME, np.array([[0, -1.0, 0, 3], [0, 0, 2.0, 4], [0.5, 0, 0, 5], [0, 0, 0, 1]]))
    niftis = [_nifti(VOLUME), _nifti(real[..., None]), _nifti(real, kind=nibabel.Nifti2Image)]
    niftis += [bytes(scaled.to_bytes()), bytes(turned.to_bytes()), _nifti(VOLUME.astype(">i2"))]
    stacks = [
        tiff(VOLUME, photometric="minisblack"),
        tiff(VOLUME, imagej=True, resolution=(2.0, 2.0), metadata={"unit": "um", "spacing": 1.5, "axes": "ZYX"}),
        tiff(real, ome=True, metadata={"axes": "ZYX", "PhysicalSizeZ": 2.0, "PhysicalSizeX": 0.5}),
        tiff(VOLUME.astype(np.uint16), compression="deflate", predictor=2, photometric="minisblack"),
        tiff(VOLUME, photometric="minisblack", volumetric=True, tile=(16, 16, 16)),
    ]
    return [
        Sample(".npy", numpy_array(VOLUME)),
        Sample(".npy", numpy_array(np.asfortranarray(real))),
        *(Sample(".tif", content) for content in stacks),
        *(Sample(".nii", content) for content in niftis),
        *(Sample(".nii.gz", gzip.compress(content, mtime=0)) for content in niftis[:2]),
        *_of_medicine(),
    ]
