"""Comparisons of methods as files: a table, a picture with the methods side by side, and the contours of each."""

from __future__ import annotations

import csv
import io
import logging
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import PIL.Image
import PIL.ImageDraw
import PIL.PngImagePlugin

from cpm_core.contours.contour import Contour
from cpm_core.contours.ground_truth import Truth
from cpm_core.contours.result import Result
from cpm_core.contours.surface import Surface
from cpm_core.formats.animations.snapshot_strip import strip
from cpm_core.formats.common.atomic import check_place, write_together
from cpm_core.formats.common.printable import cell
from cpm_core.formats.writers import FOR_VOLUMES, WRITABLE, check_export, encoded, omission, suffix_of
from cpm_core.image.image import Image
from cpm_core.numerics.types import Array, Pixels
from cpm_core.objects.methods import CONTOUR_METHODS, Facts, Start, result_of

_LOG = logging.getLogger(__name__)

TABLE, PICTURE = ".csv", ".png"
"""Suffixes of what is written of all methods together; with others, the contours of each method are."""

_START, _TRUTH, _CLOSED, _OPEN, _HALO = "#f0e442", "#d79bd0", "#56b4e9", "#ff9d1e", "#101216"
"""Colors of the start, of the ground truth, of closed and of open contours, and around them."""

_SIDE, _LEAST_WIDTH, _FINER = 420, 380, 2
"""Longer side of an image in a tile; least width of a tile, for its caption [px]; how many times finer lines are drawn
before they are reduced."""

_FEW, _ACROSS = 4, (4, 3)
"""So many tiles stand in one row; of more, one of these numbers, that which leaves the fewest places empty."""

_DARKEST, _BRIGHTEST = 0.1, 0.86
"""Brightness of the extreme gray levels, on which lines and their halos must be visible."""

_LETTERS = 13.0
"""Height of the letters [px]."""


@dataclass(frozen=True, eq=False)
class Tile:
    """What one method has found: contours, or a surface, and the facts of its run, which had these settings."""

    contours: Sequence[Contour]
    facts: Facts
    settings: Any
    surface: Surface | None = None

    def result(self, image: Image, start: Start) -> Result:
        """The same as a result."""
        return result_of(self.facts, self.contours, image, start, self.settings, self.surface)


def table(rows: Sequence[Facts]) -> bytes:
    """A table with a row for each method, as CSV: times in seconds, distances in px, empty where nothing is known."""
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow([field.name for field in fields(Facts)])
    for row in rows:
        writer.writerow([cell(value) if isinstance(value, str) else value for value in asdict(row).values()])
    return text.getvalue().encode()


def picture(image: Image, start: Start, tiles: Sequence[Tile], truth: Truth | None = None) -> Pixels:
    """The start and the contours of each method on the image, side by side, each with its facts below.

    A ground truth is drawn below all of them. What the colors mean stands below the start.
    """
    outlines = [Contour(outline, closed=True) for outline in start.outlines]
    below = [] if truth is None else [(truth.contours, _TRUTH)]
    frames = [_drawn(image, [*below, (outlines, _START)])]
    legend = {"start": "yellow"} | ({} if truth is None else {"truth": "pink"})
    captions = []
    for tile in tiles:
        closed, loose = ([one for one in tile.contours if one.closed is kind] for kind in (True, False))
        legend |= ({"closed": "blue"} if closed else {}) | ({"open": "orange"} if loose else {})
        frames.append(_drawn(image, [*below, (closed, _CLOSED), (loose, _OPEN)]))
        captions.append(caption(tile.facts))
    first = ", ".join(f"{name} {color}" for name, color in legend.items()).capitalize()
    return strip(frames, [first, *captions], columns=_columns(len(frames)), text_size=_LETTERS)


def _columns(count: int) -> int:
    """How many of some tiles stand in a row."""
    return count if count <= _FEW else min(_ACROSS, key=lambda across: -count % across)


def caption(facts: Facts) -> str:
    """A line below a tile: the method, its time, and how well it agrees where that is known."""
    words = f"{CONTOUR_METHODS[facts.method].title}: {facts.seconds:.2f} s"
    return words if facts.dice is None or facts.f is None else f"{words}, Dice {facts.dice:.3f}, F {facts.f:.3f}"


def write_comparison(
    image: Image,
    start: Start,
    tiles: Sequence[Tile],
    paths: Sequence[str | os.PathLike[str]],
    tell: Callable[[str], object] = _LOG.warning,
    truth: Truth | None = None,
    refused: Callable[[Path, str], object] | None = None,
) -> tuple[Path, ...]:
    """Write table, picture and contours, by the suffix of each path; all files or none.

    Parameters
    ----------
    image : Image
        The image.
    start : Start
        What all methods began from.
    tiles : sequence of Tile
        What each method has found.
    paths : sequence of path-like
        A table, ``.csv``; a picture, ``.png``; or contours in another format, in a volume surfaces: a file for each
        method, whose name is put before the suffix where there are several.
    tell, refused : callable, optional
        Called with a sentence for each file that leaves contours out; with each that would hold none, and why.
    truth : Truth, optional
        What the methods are measured by, for the picture.

    Returns
    -------
    tuple of Path
        The files that have been written.

    Raises
    ------
    ValueError
        When a suffix is not known, a file cannot be written there.
    """
    contents, names = [], [tile.facts.method for tile in tiles]
    for path in map(Path, paths):
        check_comparison(path, names, image.ndim)
        suffix = suffix_of(path)
        if suffix == TABLE:
            contents.append((path, table([tile.facts for tile in tiles])))
        elif suffix == PICTURE:
            contents.append((path, _picture_file(image, start, tiles, truth)))
        else:
            results = [tile.result(image, start) for tile in tiles]
            contents += _contour_files(zip(files_of(path, names), results, strict=True), suffix, tell, refused)
    write_together(contents)
    return tuple(file for file, _ in contents)


def files_of(path: Path, methods: Sequence[str]) -> list[Path]:
    """The files that contours of methods are written to: the path itself for one, else one with each name."""
    if len(methods) < 2 or suffix_of(path) in (TABLE, PICTURE):
        return [path]
    suffix = path.name[len(path.name) - len(suffix_of(path)) :]
    stem = path.name.removesuffix(suffix)
    return [path.with_name(f"{stem}.{method}{suffix}") for method in methods]


def check_comparison(path: str | os.PathLike[str], methods: Sequence[str] = (), ndim: int = 2) -> None:
    """Check in advance whether `write_comparison` could write to a path, of an image or a volume; ValueError if not."""
    file = Path(path)
    check_export(file)
    if ndim == 3 and suffix_of(file) not in (TABLE, *FOR_VOLUMES):
        raise ValueError(
            f"{file.name} would be a file of contours, but in a volume surfaces are compared: choose one of "
            f"{', '.join((TABLE, *FOR_VOLUMES))}."
        )
    if ndim == 2 and suffix_of(file) not in WRITABLE:
        raise ValueError(
            f"{file.name} would be a file of a surface or of center lines, but a comparison is one of contours: choose "
            f"one of {', '.join(WRITABLE)}."
        )
    for each in files_of(file, methods):
        check_place(each)


def _contour_files(
    wanted: Iterable[tuple[Path, Result]],
    suffix: str,
    tell: Callable[[str], object],
    refused: Callable[[Path, str], object] | None,
) -> Iterator[tuple[Path, bytes]]:
    """The files of some results with their contents, without those that would hold nothing."""
    for file, result in wanted:
        if missing := omission(result, suffix):
            tell(f"{file}: {missing}")
        try:
            yield file, encoded(result, suffix)
        except ValueError as error:
            if refused is None:
                tell(f"{file} was not written: {error}")
            else:
                refused(file, str(error))


def _picture_file(image: Image, start: Start, tiles: Sequence[Tile], truth: Truth | None) -> bytes:
    stream, texts = io.BytesIO(), PIL.PngImagePlugin.PngInfo()
    texts.add_text("Description", ", ".join(tile.facts.method for tile in tiles))
    PIL.Image.fromarray(picture(image, start, tiles, truth)).save(stream, format="PNG", pnginfo=texts)
    return stream.getvalue()


def _drawn(image: Image, layers: Sequence[tuple[Sequence[Contour], str]]) -> Pixels:
    """The image as large as a tile, with lines in their colors on dark halos; a narrow one stands on white."""
    low, high = np.percentile(image.values, (0.2, 99.8))
    shade = np.clip((image.values - low) / max(high - low, 1e-300), 0.0, 1.0)
    gray = np.rint(255.0 * (_DARKEST + (_BRIGHTEST - _DARKEST) * shade)).astype(np.uint8)
    rows, cols = image.shape
    zoom = _FINER * _SIDE / max(rows, cols)
    size = max(round(cols * zoom), _FINER), max(round(rows * zoom), _FINER)
    large = PIL.Image.fromarray(gray).convert("RGB").resize(size, PIL.Image.Resampling.BILINEAR)
    pen = PIL.ImageDraw.Draw(large)
    for contours, own in layers:
        for color, width in ((_HALO, 3 * _FINER), (own, 2 * _FINER - 1)):
            for contour in contours:
                pen.line(_line(contour.path, zoom), fill=color, width=width, joint="curve")
    tile = np.asarray(large.resize((size[0] // _FINER, size[1] // _FINER), PIL.Image.Resampling.BOX))
    beside = max(_LEAST_WIDTH - tile.shape[1], 0)
    return np.pad(tile, ((0, 0), (beside // 2, beside - beside // 2), (0, 0)), constant_values=255)


def _line(path: Array, zoom: float) -> list[tuple[float, float]]:
    """A path as Pillow takes it: the center of the first pixel lies half a pixel inside."""
    return [((col + 0.5) * zoom, (row + 0.5) * zoom) for row, col in path.tolist()]
