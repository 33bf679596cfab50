"""Labels: closed contours as filled regions, or branches of a skeleton as lines, each with its own number."""

from __future__ import annotations

import colorsys
import io
from collections.abc import Sequence

import numpy as np
import PIL.Image
import PIL.PngImagePlugin
import skimage
from numpy.typing import NDArray

from cpm_core.contours.contour import Contours, assign_numbers
from cpm_core.contours.measurements import assign_labels
from cpm_core.contours.rasterize import MAX_UINT16_LABELS, label_type
from cpm_core.formats.common.printable import make_printable
from cpm_core.formats.common.provenance import (
    PROGRAM_NAME,
    Outcome,
    describe_provenance,
    dump_provenance,
    flatten_provenance,
)
from cpm_core.formats.images import resolution
from cpm_core.image.surface import Label
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.numerics.types import Extent, JsonDict, Pixels
from cpm_core.results.result import Result

_HUE_STEP = 0.6180339887
"""Step of hue from one label to the next: the golden ratio spreads its multiples evenly."""

_SATURATION_STEP = 0.7548776662
"""Step of saturation from one label to the next: the plastic ratio."""

_BRIGHTNESS_STEP = 0.4142135624
"""Step of brightness from one label to the next: the silver ratio."""

_MAX_PALETTE = 1000
"""Number of colors after which they repeat: labels of brain atlases reach 614,454,277."""


def paint_labels(result: Outcome, *, outlines: bool = False) -> NDArray[np.unsignedinteger]:
    """Paint the insides of the closed contours of a result, or the branches of a skeleton.

    Parameters
    ----------
    result : Result or Skeleton
        Result to paint.
    outlines : bool
        Whether contours, open ones too, are painted as lines one pixel wide with their numbers as labels.

    Returns
    -------
    ndarray of uint16 or uint32, shape `result.shape`
        Labels, 0 outside; 32 bits for more than 65535. In a volume the objects inside the surface, the largest first.
        Branches are lines one pixel wide, the longest first and on top where they meet.

    Raises
    ------
    ValueError
        When there is nothing to paint.
    """
    if isinstance(result, Result) and result.surface is not None:
        if not result.surface.closed:
            raise ValueError(f"{result.source} has no closed surface, so nothing is inside: write the surface itself.")
        return result.labels.astype(label_type(int(result.labels.max())))
    count = _largest_label(result, outlines)
    if isinstance(result, Skeleton):
        return paint_lines(result.contours, range(1, count + 1), result.shape)
    if outlines:
        return paint_lines(result.contours, assign_numbers(result.contours), result.shape)
    return result.labels.astype(label_type(count))


def find_named_labels(result: Outcome, *, outlines: bool = False) -> tuple[Label, ...]:
    """Return the labels that `paint_labels` paints, each with a color; empty if none has a name or a color."""
    if isinstance(result, Result) and result.surface is not None:
        labels = result.surface.labels
    else:
        numbers = assign_labels(result.contours) if not outlines else assign_numbers(result.contours)
        known = zip(numbers, result.contours, strict=True)
        labels = tuple({number: Label(number, one.name, one.color) for number, one in known if number}.values())
    if not any(label.name or label.color for label in labels):
        return ()
    colors = label_palette(min(max(label.number for label in labels), _MAX_PALETTE))
    return tuple(
        Label(
            one.number,
            make_printable(one.name),
            one.color or f"#{bytes(colors[1 + (one.number - 1) % (len(colors) - 1)]).hex()}",
        )
        for one in labels
    )


def paint_lines(contours: Contours, labels: Sequence[int], shape: Extent) -> NDArray[np.unsignedinteger]:
    """Draw contours as lines one pixel wide with their labels, shape `shape`; the first is on top where they meet."""
    mask = np.zeros(shape, label_type(max(labels, default=0)))
    last = np.array(shape) - 1
    for contour, label in reversed(list(zip(contours, labels, strict=True))):
        pixels = np.clip(np.floor(contour.path + 0.5).astype(int), 0, last)
        pixels = pixels[np.r_[True, (np.diff(pixels, axis=0) != 0).any(axis=1)]]
        mask[pixels[0, 0], pixels[0, 1]] = label
        for a, b in zip(pixels[:-1].tolist(), pixels[1:].tolist(), strict=True):
            mask[skimage.draw.line(*a, *b)] = label  # type: ignore[no-untyped-call]
    return mask


def encode_label_png(result: Outcome, *, outlines: bool = False) -> bytes:
    """Encode the labels as PNG: 8 bits with a color table up to label 255, else 16 bits in gray.

    Each label is the index of its color, so that viewers show labels in different colors, and programs that read the
    indices, such as Pillow, get the labels. Provenance is a text chunk. ValueError when there is nothing to paint, or
    more than 65535 labels.
    """
    count = _largest_label(result, outlines)
    if count > MAX_UINT16_LABELS:
        raise ValueError(
            f"{result.source} has labels up to {count}, but a PNG mask can hold at most {MAX_UINT16_LABELS}: export to "
            "TIFF, or raise min_length, min_strength or pruning."
        )
    stream = io.BytesIO()
    pixels = paint_labels(result, outlines=outlines).astype(np.uint8 if count <= 255 else np.uint16)
    picture = PIL.Image.fromarray(pixels)
    if count <= 255:
        picture.putpalette(label_palette(count).tobytes())
    texts = PIL.PngImagePlugin.PngInfo()
    texts.add_text("Software", PROGRAM_NAME)
    texts.add_text("Description", dump_provenance(describe_provenance(result)))
    picture.save(stream, format="PNG", pnginfo=texts)
    return stream.getvalue()


def encode_label_tiff(result: Outcome, *, outlines: bool = False) -> bytes:
    """Encode the labels as uncompressed gray TIFF of 16 bits with the entries of ImageJ, which give it the pixel size.

    It has 32 bits for more than 65535 labels; ImageJ would interpret them as real numbers, so its entries are left out.
    Provenance is the info of ImageJ (Image > Show Info), or with 32 bits the description. ValueError when there is
    nothing to paint.
    """
    facts = describe_provenance(result)
    mask = paint_labels(result, outlines=outlines)
    entries: JsonDict = {}
    height, width = result.spacing[-2:]
    if result.unit:
        entries["resolution"] = (1.0 / width, 1.0 / height)
    if mask.dtype == np.uint16:
        entries |= {"imagej": True, "metadata": build_imagej_metadata(result, "ZYX"[-mask.ndim :])}
        if mask.ndim == 3:
            entries["metadata"]["spacing"] = result.spacing[0]
    else:
        entries |= {"metadata": None, "description": dump_provenance(facts)}
        if factor := resolution.conversion_factor(result.unit, "cm"):
            entries["resolution"] = (1.0 / (factor * width), 1.0 / (factor * height))
            entries["resolutionunit"] = "CENTIMETER"
    stream = io.BytesIO()
    import tifffile  # only here, because it takes long to import

    tifffile.imwrite(stream, mask, photometric="minisblack", software=PROGRAM_NAME, **entries)
    return stream.getvalue()


def build_imagej_metadata(result: Outcome, axes: str) -> JsonDict:
    """Build the entries that ImageJ reads from a TIFF: axes, unit of the resolution, and provenance."""
    info = "".join(f"{name}: {value}\n" for name, value in flatten_provenance(describe_provenance(result)).items())
    return {"axes": axes, "unit": resolution.ascii_unit(result.unit, "pixel"), "Info": info}


def label_palette(count: int) -> Pixels:
    """Return the colors of labels up to `count`, uint8 of shape (count + 1, 3): black for 0, then bright distinct ones.

    No two have the same luminance, so that labels differ in programs that turn colors into gray.
    """
    colors, taken, index = [(0, 0, 0)], {0.0}, 0
    while len(colors) <= count:
        saturation, value = (
            0.45 + 0.5 * (index * _SATURATION_STEP % 1.0),
            0.75 + 0.25 * (index * _BRIGHTNESS_STEP % 1.0),
        )
        red, green, blue = (
            round(255 * part) for part in colorsys.hsv_to_rgb(index * _HUE_STEP % 1.0, saturation, value)
        )
        luminance = round(0.299 * red + 0.587 * green + 0.114 * blue, 3)
        if luminance not in taken:
            colors.append((red, green, blue))
            taken.add(luminance)
        index += 1
    return np.array(colors, np.uint8)


def _largest_label(result: Outcome, outlines: bool = False) -> int:
    """Return the largest label; ValueError without labels."""
    if isinstance(result, Skeleton):
        count = len(result.contours)
        nothing = f"{result.source} has no skeleton, so its picture would be empty: take less smoothing"
    elif outlines:
        count = max(assign_numbers(result.contours), default=0)
        nothing = f"{result.source} has no contours, so a picture of them would be empty: continue the run"
    else:
        count = max(int(result.labels.max()), *assign_labels(result.contours), 0)
        nothing = f"No contour of {result.source} is closed, so a label mask would be empty: continue the run"
    if count == 0:
        raise ValueError(f"{nothing}, or export to SVG or CSV.")
    return count
