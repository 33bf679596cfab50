"""Figures for publications: the image with contours and a scale bar as SVG, PNG or PDF, drawn by matplotlib."""

from __future__ import annotations

from pathlib import Path

from cpm_core.formats.common.atomic import check_target, write_together
from cpm_core.formats.common.content import AnyPath
from cpm_core.formats.common.provenance import Outcome, describe_provenance, dump_provenance
from cpm_core.image.drawing import FIGURE_FORMATS, new_figure, render_figure
from cpm_core.medial_axis.skeleton import Skeleton


def write_figure(
    result: Outcome,
    *paths: AnyPath,
    image: bool = True,
    contours: bool = True,
    particles: bool = False,
    labels: bool = False,
    scale_bar: bool = True,
) -> None:
    """Write a figure: the image with contours and a scale bar, as SVG, PNG or PDF.

    Contours stay lines in SVG and PDF, and text stays text in SVG, so that a drawing program can edit both.

    Parameters
    ----------
    result : Result or Skeleton
        Result to draw; for a volume its surface.
    *paths : path-like
        Files to write, with the suffix ``.svg``, ``.png`` or ``.pdf``. Existing ones are replaced.
    image, contours, particles, labels, scale_bar : bool
        What is drawn, as in `Result.plot`.

    Raises
    ------
    ValueError
        For another suffix, or a file that cannot be written. Then nothing is written.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("disks"), cpm.uniform_grid((64, 64)))
    >>> cpm.write_figure(result, "disks.pdf", labels=True)
    """
    files = list(map(Path, paths))
    for file in files:
        check_target(file, FIGURE_FORMATS, "of a figure")
    drawn = {"image": image, "contours": contours, "particles": particles, "labels": labels, "scale_bar": scale_bar}
    contents = [(file, encode_figure(file.suffix.lower(), result, **drawn)) for file in files]
    write_together(contents)


def encode_figure(suffix: str, result: Outcome, **drawn: bool) -> bytes:
    """Encode the figure of `write_figure` in the format of a suffix; `drawn` is passed to `Result.plot`."""
    figure, ax = new_figure(result.shape if result.surface is None else None, result.spacing)
    if isinstance(result, Skeleton):
        result.plot(ax, image=drawn.get("image", True), scale_bar=drawn.get("scale_bar", True))
    else:
        result.plot(ax, **drawn)
    return render_figure(figure, suffix, dump_provenance(describe_provenance(result)))
