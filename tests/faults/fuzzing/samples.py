"""Samples: one small sound file of each kind that is read, to be damaged."""

from __future__ import annotations

import io
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import nrrd
import numpy as np
import PIL.Image
import tifffile
from pydicom.uid import RLELossless

from cpm_core import encoded
from tests.core.formats.drawn import RESULT
from tests.core.formats.images.volumes import made

SHAPE = (11, 14)
GRAY = (np.add.outer(np.arange(SHAPE[0]) * 17, np.arange(SHAPE[1]) * 13) % 251).astype(np.uint8)
COLOR = np.stack([GRAY, GRAY[::-1], GRAY[:, ::-1]], axis=-1)
CLEAR = np.dstack([COLOR, GRAY])


class Sample(NamedTuple):
    """A sound file: the suffix of its name, and its bytes."""

    suffix: str
    content: bytes


def _picture(values: Any, kind: str, mode: str | None = None, **options: Any) -> bytes:
    picture = PIL.Image.fromarray(values)
    stream = io.BytesIO()
    (picture.convert(mode) if mode else picture).save(stream, format=kind, **options)
    return stream.getvalue()


def _tiff(values: Any, **options: Any) -> bytes:
    stream = io.BytesIO()
    kinds = {name: options.pop(name) for name in ("bigtiff", "byteorder", "imagej", "ome") if name in options}
    with tifffile.TiffWriter(stream, **kinds) as writer:
        writer.write(values, **options)
    return stream.getvalue()


def _array(values: Any) -> bytes:
    stream = io.BytesIO()
    np.save(stream, values)
    return stream.getvalue()


def _exif(orientation: int) -> PIL.Image.Exif:
    data = PIL.Image.Exif()
    data[274] = orientation
    return data


def _pictures() -> list[Sample]:
    second = [PIL.Image.fromarray(GRAY[::-1].copy())]
    deep = GRAY.astype(np.uint16) * 257
    return [
        Sample(".png", _picture(GRAY, "PNG")),
        Sample(".png", _picture(COLOR, "PNG", dpi=(25400, 25400))),
        Sample(".png", _picture(CLEAR, "PNG", exif=_exif(6))),
        Sample(".png", _picture(GRAY, "PNG", "P", transparency=3)),
        Sample(".png", _picture(deep, "PNG")),
        Sample(".png", _picture(GRAY > 99, "PNG")),
        Sample(".jpg", _picture(GRAY, "JPEG", exif=_exif(8))),
        Sample(".jpg", _picture(COLOR, "JPEG", progressive=True)),
        Sample(".jpg", _picture(CLEAR, "JPEG", "CMYK")),
        Sample(".bmp", _picture(COLOR, "BMP")),
        Sample(".bmp", _picture(GRAY, "BMP", "1")),
        Sample(".pgm", _picture(deep.astype(np.int32), "PPM")),
        Sample(".ppm", b"P3 9 8 255\n" + b"1 2 3 " * 72),
        Sample(".pbm", b"P1\n# bits\n9 8\n" + b"1 0 1 0 1 0 1 0 1\n" * 8),
        Sample(".gif", _picture(GRAY, "GIF", save_all=True, append_images=second, transparency=0)),
        Sample(".webp", _picture(CLEAR, "WEBP", lossless=True)),
        Sample(
            ".webp", _picture(COLOR, "WEBP", save_all=True, append_images=[PIL.Image.fromarray(COLOR[::-1].copy())])
        ),
        Sample(".jp2", _picture(COLOR, "JPEG2000")),
    ]


def _tiffs() -> list[Sample]:
    real, deep = GRAY / np.float32(250.0), GRAY.astype(np.uint16) * 16
    tiled = {"tile": (16, 16), "compression": "deflate"}
    contents = [
        _tiff(GRAY),
        _tiff(deep, byteorder=">", resolution=(20000, 20000), resolutionunit="CENTIMETER"),
        _tiff(deep, compression="deflate", predictor=2),
        _tiff(COLOR, bigtiff=True, **tiled),
        _tiff(np.moveaxis(COLOR, -1, 0), photometric="rgb", planarconfig="separate"),
        _tiff(CLEAR, photometric="rgb", extrasamples=["unassalpha"]),
        _tiff(np.stack([GRAY, GRAY]), imagej=True, metadata={"unit": "um", "axes": "ZYX"}),
        _tiff(GRAY, ome=True, metadata={"PhysicalSizeX": 0.5, "PhysicalSizeY": 0.5}),
        _tiff(GRAY, photometric="miniswhite"),
        _tiff(GRAY > 99),
        _tiff(GRAY, photometric="palette", colormap=np.zeros((3, 256), np.uint16)),
        _tiff(real, extratags=[(42113, "s", 0, "-9999", True)]),
        _tiff(np.stack([GRAY] * 2), photometric="minisblack"),
        _tiff(GRAY[np.newaxis].repeat(3, 0), photometric="minisblack", volumetric=True),
        *(
            _picture(values, "TIFF", mode, compression=packing)
            for values, mode, packing in (
                (GRAY, None, "tiff_lzw"), (COLOR, None, "tiff_lzw"), (GRAY, "1", "group4"), (GRAY, "1", "group3"),
                (COLOR, None, "jpeg"), (GRAY, None, "tiff_adobe_deflate"), (deep, None, "zstd"),
                (GRAY, None, "packbits"),
            )
        ),
    ]  # fmt: skip
    return [Sample(".tif", content) for content in contents]


def _arrays() -> list[Sample]:
    values = (GRAY, GRAY.astype(">f4"), np.asfortranarray(GRAY.astype(np.int64)), COLOR, CLEAR / 255.0, GRAY > 99)
    return [Sample(".npy", _array(array)) for array in values]


def _volumes() -> list[Sample]:
    """Volumes of each kind, the values of those with a file beside them left out."""
    planes = np.stack([GRAY + number for number in range(9)]).astype(np.int16)
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
            nrrd.write(str(place / f"{encoding}.nrrd"), planes, header, index_order="C")
        for number, slice_ in enumerate(slices):
            slice_.save_as(place / f"{number}.dcm", enforce_file_format=True)
        np.savez_compressed(place / "a.npz", volume=planes, size=np.ones(3))
        tifffile.imwrite(place / "a.tif", hyper.astype(np.uint16), imagej=True, metadata={"axes": "TZCYX"})
        tifffile.imwrite(place / "a.ome.tif", hyper.astype(np.uint16), metadata={"axes": "TZCYX"})
        pages[0].save(place / "a.png", save_all=True, append_images=pages[1:])
        files = [file for file in sorted(place.iterdir()) if file.suffix != ".raw"]
        return [Sample("".join(file.suffixes), file.read_bytes()) for file in files]


def _contours() -> list[Sample]:
    suffixes = (".csv", ".json", ".geojson", ".labelme.json", ".coco.json")
    own = [Sample(f".{suffix.rsplit('.', 1)[1]}", encoded(RESULT, suffix)) for suffix in suffixes]
    return [*own, Sample(".csv", b"col,row\n3.5,4\n5,6.25\n"), Sample(".csv", b"1,2\n3,4\n")]


KINDS: dict[str, Callable[[], list[Sample]]] = {
    "pictures": _pictures,
    "TIFFs": _tiffs,
    "arrays": _arrays,
    "volumes": _volumes,
    "contours": _contours,
}
"""What is read -> its samples."""


def samples() -> list[Sample]:
    """All samples."""
    return [sample for kind in KINDS.values() for sample in kind()]
