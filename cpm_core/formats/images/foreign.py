"""Foreign kinds: files of images that are sound but not read, so that they are called by their names."""

from __future__ import annotations

import zlib
from pathlib import Path

from cpm_core.formats.images.choice import FIRST, Choice
from cpm_core.formats.images.decoded import Decoded, UnreadableError
from cpm_core.formats.images.stacks.stack import Stack

FORMAT = ""
READS: dict[str, str] = {}

_SIGNATURES: tuple[tuple[int, tuple[bytes, ...], str], ...] = (
    (128, (b"DICM",), "a packed DICOM file"),
    (0, (b"NRRD000",), "a packed NRRD volume"),
    (0, (b"ObjectType =", b"NDims ="), "a packed MetaImage volume"),
    (0, (b"ZISRAWFILE",), "a CZI file of Zeiss"),
    (0, (b"\xda\xce\xbe\x0a", b"\0\0\0\x0cjP  \r\n\x87\nND2"), "an ND2 file of Nikon"),
    (4, (b"ftypheic", b"ftypheix", b"ftyphevc", b"ftypheim", b"ftypheis", b"ftypmif1"), "a HEIC picture"),
    (4, (b"ftypavif", b"ftypavis"), "an AVIF picture"),
    (0, (b"SIMPLE  =",), "a FITS image"),
    (0, (b"\x89HDF\r\n\x1a\n",), "an HDF5 file"),
    (0, (b"MATLAB 5.0 MAT-file",), "a MATLAB file"),
    (0, (b"PK\x03\x04",), "an archive of files (ZIP)"),
    (0, (b"%PDF-",), "a PDF document"),
    (0, (b"8BPS",), "a Photoshop picture"),
    (0, (b"v/1\x01",), "an OpenEXR picture"),
    (0, (b"\0\0\0\x0cJXL \r\n\x87\n", b"\xff\x0a"), "a JPEG XL picture"),
    (0, (b"#?RADIANCE", b"#?RGBE"), "an HDR picture"),
    (0, (b"qoif",), "a QOI picture"),
    (0, (b"II\xbc\x01",), "a JPEG XR picture"),
    (0, (b"gimp xcf",), "a picture of GIMP"),
    (0, (b"SDPX", b"XPDS"), "a DPX picture"),
    (0, (b"FUJIFILMCCD-RAW", b"FOVb"), "a raw picture of a camera"),
    (0, (b"p\0\0\0",), "a LIF file of Leica"),
    (0, (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1",), "an OIB or ZVI file of a microscope, or a document"),
    (0, (b"\0\0\0\3\0\0", b"\0\0\0\4\0\0"), "a DM3 or DM4 file of Digital Micrograph"),
    (0, (b"CDF\1", b"CDF\2", b"CDF\5"), "a NetCDF or MINC file"),
    (0, (b"\x5c\1\0\0", b"\0\0\1\x5c"), "an Analyze volume"),
    (4, (b"ftypmp4", b"ftypisom", b"ftypM4V", b"ftypqt", b"ftypavc1"), "a film"),
    (8, (b"AVI LIST",), "a film"),
    (0, (b"\x1aE\xdf\xa3",), "a film"),
    (0, (b"<svg", b"<?xml", b"<!DOCTYPE", b"<html"), "an SVG drawing or another XML file"),
    (208, (b"MAP DA\0\0", b"MAP DD\0\0", b"MAP \x11\x11\0\0"), "an MRC volume"),
)
"""Place of a signature in a file, its forms, and what the file is."""

_GZIP = b"\x1f\x8b"


def reads(head: bytes, _path: Path) -> bool:
    """Whether the first bytes of a file are those of a kind that is known but not read."""
    return _kind(head) is not None


def read(path: Path, _choice: Choice = FIRST) -> Decoded:
    """Refuse the file and say what it is."""
    raise _refusal(path)


def stack(path: Path, _choice: Choice = FIRST) -> Stack:
    """Refuse the file and say what it is."""
    raise _refusal(path)


def _refusal(path: Path) -> UnreadableError:
    with path.open("rb") as stream:
        kind = _kind(stream.read(512))
    return UnreadableError(
        f"{path.name} is {kind}, and CPM does not read those: save the image or volume that you want as TIFF, "
        "with the program that made it."
    )


def _kind(head: bytes) -> str | None:
    """What a file is by its first bytes, unpacked if they are packed; None for a kind that is not known."""
    packed = head.startswith(_GZIP)
    if packed:
        try:
            head = zlib.decompressobj(wbits=31).decompress(head, 512)
        except zlib.error:
            return None
    found = (kind for place, forms, kind in _SIGNATURES if head.startswith(forms, place))
    return next(found, "a packed file (gzip) of no known kind" if packed else None)
