"""SVG: contours as paths for browsers and drawing programs."""

from __future__ import annotations

from html import escape

import numpy as np
from numpy.typing import NDArray

from cpm_core.contours.contour import Contour
from cpm_core.contours.measurements import contour_labels
from cpm_core.contours.result import Result
from cpm_core.formats.common.provenance import facts_of, text_of
from cpm_core.formats.contours.appearance import DEFAULT
from cpm_core.medial_axis.skeleton import Skeleton

_MILLIMETERS = {"nm": 1e-6, "µm": 1e-3, "mm": 1.0, "cm": 10.0, "m": 1000.0}
_SMALLEST_PAGE = 10.0  # [mm]; a page of the true size of a cell would be invisible


def encode(result: Result | Skeleton) -> bytes:
    """Draw the contours of a result.

    User units are pixels of the image, x along columns and y along rows, pixel centers at integers: the image
    covers the view box. Every contour is one path without a fill. Its data attributes give whether it is closed,
    its mean edge strength [gray levels / px], its length [px], its contrast where that can be measured, the length
    that was drawn by hand [px] where that is not zero, and its label in the label mask (0 when open). A name
    becomes the title, a color the stroke. The page has the object's true size where that is known and large enough
    to see, else one CSS pixel per pixel. Of a skeleton each branch is such a path, with the distance to the
    boundary of all its vertices [px]. The metadata are how they were found, as JSON.
    """
    rows, cols = result.shape
    width, height = _page(result)
    spacing = " ".join(f"{size:.9g}" for size in result.spacing)
    known = f' data-unit="{escape(result.unit)}" data-spacing="{spacing}"' if result.unit else ""
    if isinstance(result, Skeleton):
        title = "Skeleton"
        paths = [_path(c, n, r) for n, (c, r) in enumerate(zip(result.contours, result.radii, strict=True), start=1)]
    else:
        title = "Contours"
        paths = [_path(contour, n) for contour, n in zip(result.contours, contour_labels(result.contours), strict=True)]
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="-0.5 -0.5 {cols} {rows}" '
        f'preserveAspectRatio="none"{known}>',
        f"<title>{title} of {escape(result.source, quote=False)}</title>",
        f"<metadata>{escape(text_of(facts_of(result)), quote=False)}</metadata>",
        f'<g fill="none" stroke="{DEFAULT}" stroke-width="1.5" stroke-linejoin="round" stroke-linecap="round">',
        *paths,
        "</g>",
        "</svg>",
    ]
    return ("\n".join(lines) + "\n").encode()


def _path(contour: Contour, label: int, radii: NDArray[np.float64] | None = None) -> str:
    vertices = contour.points if len(contour.points) > 1 else contour.points.repeat(2, axis=0)  # a single vertex: a dot
    points = " L".join(f"{col:.3f} {row:.3f}" for row, col in vertices)
    known = "" if radii is None else f'data-radii="{" ".join(f"{radius:.3f}" for radius in radii)}" '
    known += "" if contour.sides is None else f'data-contrast="{contour.contrast:.4f}" '
    known += f'data-number="{contour.number}" ' if contour.number else ""
    known += f'data-by-hand="{contour.length_by_hand:.3f}" ' if contour.by_hand else ""
    known += f'stroke="{contour.color}" ' if contour.color else ""
    end = f"><title>{escape(contour.name, quote=False)}</title></path>" if contour.name else "/>"
    return (
        f'<path fill="none" vector-effect="non-scaling-stroke" data-closed="{str(contour.closed).lower()}" '
        f'data-label="{label}" data-strength="{contour.strength:.6g}" data-length="{contour.length:.3f}" {known}'
        f'd="M{points}{" Z" if contour.closed else ""}"{end}'
    )


def _page(result: Result | Skeleton) -> tuple[str, str]:
    """Width and height of the drawing as SVG lengths."""
    size = np.array(result.shape) * result.spacing
    millimeters = size * _MILLIMETERS.get(result.unit or "", 0.0)
    if millimeters.min() >= _SMALLEST_PAGE:
        return f"{millimeters[1]:.6g}mm", f"{millimeters[0]:.6g}mm"
    pixels = size / min(result.spacing)
    return f"{pixels[1]:.6g}", f"{pixels[0]:.6g}"
