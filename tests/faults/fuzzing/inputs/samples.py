"""Samples: one small sound file of each kind that is read, to be damaged."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import PIL.Image

from cpm_core import to_bytes
from tests.core.formats.drawn import RESULT

from .contour_samples import contours_of_others
from .encoders import Sample, numpy_array, picture, tiff
from .surface_samples import surfaces
from .volume_samples import volumes

SHAPE = (11, 14)
GRAY = (np.add.outer(np.arange(SHAPE[0]) * 17, np.arange(SHAPE[1]) * 13) % 251).astype(np.uint8)
COLOR = np.stack([GRAY, GRAY[::-1], GRAY[:, ::-1]], axis=-1)
CLEAR = np.dstack([COLOR, GRAY])


def _exif(orientation: int) -> PIL.Image.Exif:
    data = PIL.Image.Exif()
    data[274] = orientation
    return data


def _pictures() -> list[Sample]:
    second = [PIL.Image.fromarray(GRAY[::-1].copy())]
    deep = GRAY.astype(np.uint16) * 257
    return [
        Sample(".png", picture(GRAY, "PNG")),
        Sample(".png", picture(COLOR, "PNG", dpi=(25400, 25400))),
        Sample(".png", picture(CLEAR, "PNG", exif=_exif(6))),
        Sample(".png", picture(GRAY, "PNG", "P", transparency=3)),
        Sample(".png", picture(deep, "PNG")),
        Sample(".png", picture(GRAY > 99, "PNG")),
        Sample(".jpg", picture(GRAY, "JPEG", exif=_exif(8))),
        Sample(".jpg", picture(COLOR, "JPEG", progressive=True)),
        Sample(".jpg", picture(CLEAR, "JPEG", "CMYK")),
        Sample(".bmp", picture(COLOR, "BMP")),
        Sample(".bmp", picture(GRAY, "BMP", "1")),
        Sample(".pgm", picture(deep.astype(np.int32), "PPM")),
        Sample(".ppm", b"P3 9 8 255\n" + b"1 2 3 " * 72),
        Sample(".pbm", b"P1\n# bits\n9 8\n" + b"1 0 1 0 1 0 1 0 1\n" * 8),
        Sample(".gif", picture(GRAY, "GIF", save_all=True, append_images=second, transparency=0)),
        Sample(".webp", picture(CLEAR, "WEBP", lossless=True)),
        Sample(".webp", picture(COLOR, "WEBP", save_all=True, append_images=[PIL.Image.fromarray(COLOR[::-1].copy())])),
        Sample(".jp2", picture(COLOR, "JPEG2000")),
    ]


def _tiffs() -> list[Sample]:
    real, deep = GRAY / np.float32(250.0), GRAY.astype(np.uint16) * 16
    tiled = {"tile": (16, 16), "compression": "deflate"}
    contents = [
        tiff(GRAY),
        tiff(deep, byteorder=">", resolution=(20000, 20000), resolutionunit="CENTIMETER"),
        tiff(deep, compression="deflate", predictor=2),
        tiff(COLOR, bigtiff=True, **tiled),
        tiff(np.moveaxis(COLOR, -1, 0), photometric="rgb", planarconfig="separate"),
        tiff(CLEAR, photometric="rgb", extrasamples=["unassalpha"]),
        tiff(np.stack([GRAY, GRAY]), imagej=True, metadata={"unit": "um", "axes": "ZYX"}),
        tiff(GRAY, ome=True, metadata={"PhysicalSizeX": 0.5, "PhysicalSizeY": 0.5}),
        tiff(GRAY, photometric="miniswhite"),
        tiff(GRAY > 99),
        tiff(GRAY, photometric="palette", colormap=np.zeros((3, 256), np.uint16)),
        tiff(real, extratags=[(42113, "s", 0, "-9999", True)]),
        tiff(np.stack([GRAY] * 2), photometric="minisblack"),
        tiff(GRAY[np.newaxis].repeat(3, 0), photometric="minisblack", volumetric=True),
        *(
            picture(values, "TIFF", mode, compression=packing)
            for values, mode, packing in (
                (GRAY, None, "tiff_lzw"), (COLOR, None, "tiff_lzw"), (GRAY, "1", "group4"), (GRAY, "1", "group3"),
                (COLOR, None, "jpeg"), (GRAY, None, "tiff_adobe_deflate"), (GRAY, None, "packbits"),
            )
        ),
        tiff(deep, compression="zstd"),  # as older releases of Pillow cannot
    ]  # fmt: skip
    return [Sample(".tif", content) for content in contents]


def _arrays() -> list[Sample]:
    values = (GRAY, GRAY.astype(">f4"), np.asfortranarray(GRAY.astype(np.int64)), COLOR, CLEAR / 255.0, GRAY > 99)
    return [Sample(".npy", numpy_array(array)) for array in values]


def _contours() -> list[Sample]:
    suffixes = (".csv", ".json", ".geojson", ".labelme.json", ".coco.json", ".zip", ".svg", ".dxf")
    own = [Sample(f".{suffix.rsplit('.', 1)[1]}", to_bytes(RESULT, suffix)) for suffix in suffixes]
    tables = (b"col,row\n3.5,4\n5,6.25\n", b"1,2\n3,4\n")
    return [*own, *(Sample(".csv", table) for table in tables), *contours_of_others()]


KINDS: dict[str, Callable[[], list[Sample]]] = {
    "pictures": _pictures,
    "TIFFs": _tiffs,
    "arrays": _arrays,
    "contours": _contours,
    "volumes": volumes,
    "surfaces": surfaces,
}
"""What is read -> its samples."""


def samples() -> list[Sample]:
    """All samples."""
    return [sample for kind in KINDS.values() for sample in kind()]
