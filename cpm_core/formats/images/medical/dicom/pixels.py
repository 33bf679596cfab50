"""Pixels of DICOM files: unpacked, turned into the values that are meant, bright where they are to be shown bright."""

from __future__ import annotations

import logging
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpm_core.formats.common.printable import printable
from cpm_core.formats.images.decoded import Decoded, UnreadableError, check_size, from_samples
from cpm_core.formats.images.medical.dicom.frame import Frame
from cpm_core.image.gray_levels import NO_DATA

# pydicom logs a warning for everything unusual in a file; the user gets one sentence on what matters instead.
logging.getLogger("pydicom").addHandler(logging.NullHandler())

_JPEG = "1.2.840.10008.1.2.4."
_CODECS = {
    "50": "jpeg8_decode",
    "51": "jpeg8_decode",
    "57": "ljpeg_decode",
    "70": "ljpeg_decode",
    "80": "jpegls_decode",
    "81": "jpegls_decode",
    "90": "jpeg2k_decode",
    "91": "jpeg2k_decode",
    "201": "jpeg2k_decode",
    "202": "jpeg2k_decode",
    "203": "jpeg2k_decode",
}
"""End of the name of a packing -> function of imagecodecs."""

_PIXELS = ("PixelData", "FloatPixelData", "DoubleFloatPixelData")

_BITS = 16
"""Most bits of a pixel that is packed."""


def decoded(dataset: Any, frame: Frame) -> Decoded:
    """One image of a file: values in the unit of the file, upright as stored."""
    name = printable(frame.path.name)
    check_size(name, *frame.shape)
    stored = _unpacked(dataset, frame, name)
    if stored.shape[:2] != frame.shape:
        raise ValueError("the pixels have another size than the header says")
    colors = str(dataset.get("PhotometricInterpretation", "MONOCHROME2")).strip()
    if colors == "PALETTE COLOR":
        from pydicom.pixels.processing import apply_color_lut

        table = apply_color_lut(stored, dataset)
        # some programs write eight bits in tables of sixteen
        bright = table if table.max(initial=0) < 256 else table >> 8
        bright = bright.astype(np.uint8)
        return from_samples(bright[..., :3])
    if stored.ndim == 3:
        bits = int(dataset.get("BitsStored", 8 * stored.dtype.itemsize))
        return from_samples(stored[..., :3], white=2.0**bits - 1.0)
    inverted = colors == "MONOCHROME1"
    notes = ("It counts from white to black and was inverted.",) if inverted else ()
    if dataset.get("ModalityLUTSequence"):
        from pydicom.pixels.processing import apply_modality_lut

        meant = np.asarray(apply_modality_lut(stored, dataset)).astype(np.float64)
        meant = meant.max() + meant.min() - meant if inverted else meant
        return Decoded(_without_padding(dataset, meant, stored), notes=notes)
    values: NDArray[Any] = _ends(dataset) - stored.astype(np.int64) if inverted else stored
    if (frame.slope, frame.intercept) != (1.0, 0.0):
        values = values * np.float64(frame.slope) + np.float64(frame.intercept)
    return Decoded(_without_padding(dataset, values, stored), notes=notes)


def _without_padding(dataset: Any, values: NDArray[Any], stored: NDArray[Any]) -> NDArray[Any]:
    """Values with `NO_DATA` where a pixel is there but to fill the rectangle, as beyond the circle of a scanner."""
    first = _padding(dataset, "PixelPaddingValue", "FloatPixelPaddingValue", "DoubleFloatPixelPaddingValue")
    if first is None:
        return values
    last = _padding(dataset, "PixelPaddingRangeLimit", "FloatPixelPaddingRangeLimit")
    low, high = sorted((first, first if last is None else last))
    absent = (stored >= low) & (stored <= high)
    return np.where(absent, np.float64(NO_DATA), values) if absent.any() else values


def _padding(dataset: Any, *names: str) -> float | None:
    """The first of these entries that is there; of numbers with a sign also where it was written without."""
    told = next((dataset.get(name) for name in names if dataset.get(name) is not None), None)
    try:
        value = float(np.frombuffer(told, "<i2")[0] if isinstance(told, bytes) else told)  # type: ignore[arg-type]
    except (TypeError, ValueError, IndexError):
        return None
    bits = int(dataset.get("BitsStored", _BITS))
    return value - 2.0**bits if int(dataset.get("PixelRepresentation", 0)) and value >= 2.0 ** (bits - 1) else value


def _ends(dataset: Any) -> int:
    """The least and the largest value that can be stored, added up: what inverts the others."""
    bits = int(dataset.get("BitsStored", dataset.get("BitsAllocated", _BITS)))
    return -1 if int(dataset.get("PixelRepresentation", 0)) else 2**bits - 1


def _unpacked(dataset: Any, frame: Frame, name: str) -> NDArray[Any]:
    """Stored values of an image, shape (rows, columns) or (rows, columns, 3)."""
    from pydicom import encaps
    from pydicom.pixels.utils import pixel_array

    if not any(kind in dataset for kind in _PIXELS):
        raise UnreadableError(f"{name} holds no DICOM image: choose another file or folder.")
    syntax = dataset.file_meta.TransferSyntaxUID
    if not syntax.is_encapsulated:
        return np.asarray(pixel_array(dataset, index=frame.index))
    content = encaps.get_frame(
        dataset.PixelData, frame.index, number_of_frames=int(dataset.get("NumberOfFrames", 1) or 1)
    )
    declared = _declared_size(content)
    if declared is not None and declared != frame.shape:
        raise ValueError("the pixels have another size than the header says")
    failure: Exception
    try:
        return np.asarray(pixel_array(dataset, index=frame.index))
    except Exception as error:  # of any kind, as decoders do; perhaps another package unpacks it
        failure = error
    codec = _CODECS.get(str(syntax).removeprefix(_JPEG)) if str(syntax).startswith(_JPEG) else None
    if codec is None:
        if "missing dependencies" not in str(failure):
            raise failure
        packing = printable(str(syntax.name))[:80]
        raise UnreadableError(
            f"{name} is packed as {packing}, which is not read: save the image again without packing."
        )
    if int(dataset.get("SamplesPerPixel", 1)) != 1 and dataset.get("PhotometricInterpretation") != "RGB":
        raise failure
    import imagecodecs  # only here, because it takes long to import

    found = np.asarray(getattr(imagecodecs, codec)(content))
    signed = int(dataset.get("PixelRepresentation", 0)) and found.dtype.kind == "u"
    return _with_sign(found, int(dataset.BitsStored)) if signed else found


def _with_sign(values: NDArray[Any], bits: int) -> NDArray[Any]:
    """Values of so many bits, of which the first is the sign."""
    half = 1 << (bits - 1)
    return (values.astype(np.int32) & (2 * half - 1) ^ half) - half


def _declared_size(content: bytes) -> tuple[int, int] | None:
    """Rows and columns by the packed image itself, before memory for them is taken; None for other packings."""
    if content.startswith(b"\xff\x4f\xff\x51") and len(content) >= 24:  # JPEG 2000
        right, bottom, left, top = struct.unpack(">4I", content[8:24])
        return bottom - top, right - left
    if not content.startswith(b"\xff\xd8"):
        return None
    place = 2
    while place + 9 <= len(content):
        mark, length = content[place + 1], int.from_bytes(content[place + 2 : place + 4], "big")
        if (0xC0 <= mark <= 0xCF and mark not in (0xC4, 0xC8, 0xCC)) or mark == 0xF7:  # of JPEG, and of JPEG-LS
            rows, columns = struct.unpack(">2H", content[place + 5 : place + 9])
            return rows, columns
        place += 2 + max(length, 2)
    return None
