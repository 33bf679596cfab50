"""Comparisons of methods as files: a table, a picture with the methods side by side, and the contours of each."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

from cpm_core.contours.contour import Contour
from cpm_core.contours.ground_truth import Truth
from cpm_core.contours.result import Result
from cpm_core.contours.surface import Surface
from cpm_core.formats.common.atomic import check_place, write_together
from cpm_core.formats.common.content import AnyPath
from cpm_core.formats.common.printable import cell
from cpm_core.formats.contours import contour_csv
from cpm_core.formats.writers import FOR_VOLUMES, WRITABLE, check_export, encoded, omission, suffix_of
from cpm_core.image.drawing import encoded_figure, require_matplotlib, show_curves, show_image
from cpm_core.image.image import Image
from cpm_core.objects.methods import CONTOUR_METHODS, Facts, Start, result_of

_LOG = logging.getLogger(__name__)

TABLE, PICTURE = ".csv", ".png"
"""Suffixes of what is written of all methods together; with others, the contours of each method are."""

_START, _TRUTH = "#f0e442", "#d79bd0"
"""Colors of the start and of the ground truth."""

_FEW, _ACROSS = 4, (4, 3)
"""So many tiles form one row; of more, one of these numbers, that which leaves the fewest places empty."""

_SIDE, _CAPTION = 4.0, 0.4
"""Side of a tile and height of its caption [inches]."""


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
    known = [asdict(row) for row in rows]
    cells = [{name: cell(one) if isinstance(one, str) else one for name, one in row.items()} for row in known]
    return contour_csv.table(cells, [field.name for field in fields(Facts)])


def picture(image: Image, start: Start, tiles: Sequence[Tile], truth: Truth | None = None) -> bytes:
    """The start and the contours of each method on the image, side by side, each with its facts above, as PNG.

    A ground truth is drawn below all of them.
    """
    require_matplotlib()
    from matplotlib.figure import Figure

    known = () if truth is None else tuple(replace(one, color=_TRUTH) for one in truth.contours)
    drawn = [Contour(outline, closed=True, color=_START) for outline in start.outlines]
    title = "Start (yellow)" if truth is None else "Start (yellow), ground truth (pink)"
    parts: list[tuple[str, Sequence[Contour]]] = [(title, drawn)]
    for tile in tiles:
        facts = tile.facts
        title = f"{CONTOUR_METHODS[facts.method].title}: {facts.seconds:.2f} s"
        if facts.dice is not None and facts.f is not None:
            title += f", Dice {facts.dice:.3f}, F {facts.f:.3f}"
        parts.append((title, tile.contours))
    count = len(parts)
    columns = count if count <= _FEW else min(_ACROSS, key=lambda across: -count % across)
    rows = -(-count // columns)
    figure = Figure(figsize=(_SIDE * columns, (_SIDE + _CAPTION) * rows), layout="constrained")
    every = figure.subplots(rows, columns, squeeze=False).ravel()
    for ax in every[count:]:
        ax.set_axis_off()
    for ax, (title, contours) in zip(every, parts, strict=False):
        show_image(ax, image.values, image.spacing)
        show_curves(ax, [*known, *contours])
        ax.set_title(title, fontsize=9)
    return encoded_figure(figure, PICTURE, ", ".join(tile.facts.method for tile in tiles))


def write_comparison(
    image: Image,
    start: Start,
    tiles: Sequence[Tile],
    paths: Sequence[AnyPath],
    warn: Callable[[str], object] = _LOG.warning,
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
    warn, refused : callable, optional
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
            contents.append((path, picture(image, start, tiles, truth)))
        else:
            results = [tile.result(image, start) for tile in tiles]
            contents += _contour_files(zip(files_of(path, names), results, strict=True), suffix, warn, refused)
    write_together(contents)
    return tuple(file for file, _ in contents)


def files_of(path: Path, methods: Sequence[str]) -> list[Path]:
    """The files that contours of methods are written to: the path itself for one, else one with each name."""
    if len(methods) < 2 or suffix_of(path) in (TABLE, PICTURE):
        return [path]
    suffix = path.name[len(path.name) - len(suffix_of(path)) :]
    stem = path.name.removesuffix(suffix)
    return [path.with_name(f"{stem}.{method}{suffix}") for method in methods]


def check_comparison(path: AnyPath, methods: Sequence[str] = (), ndim: int = 2) -> None:
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
    warn: Callable[[str], object],
    refused: Callable[[Path, str], object] | None,
) -> Iterator[tuple[Path, bytes]]:
    """The files of some results with their contents, without those that would hold nothing."""
    for file, result in wanted:
        if missing := omission(result, suffix):
            warn(f"{file}: {missing}")
        try:
            yield file, encoded(result, suffix)
        except ValueError as error:
            if refused is None:
                warn(f"{file} was not written: {error}")
            else:
                refused(file, str(error))
