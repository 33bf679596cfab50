"""Comparisons of methods as files: a table, and the contours of each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, fields
from pathlib import Path

from cpm_core.contours.result import Result
from cpm_core.formats.common.atomic import check_place, write_together
from cpm_core.formats.common.content import AnyPath
from cpm_core.formats.common.printable import cell
from cpm_core.formats.contours import contour_csv
from cpm_core.formats.writers import WRITABLE, check_export, encoded, omission, suffix_of
from cpm_core.objects.methods import Facts

TABLE = ".csv"
"""Suffix of what is written of all methods together; with others, what each method has found is."""


def write_comparison(
    rows: Sequence[Facts],
    results: Sequence[Result],
    paths: Sequence[AnyPath],
    warn: Callable[[str], object],
    refuse: Callable[[Path, str], object],
) -> tuple[Path, ...]:
    """Write the table or the contours, by the suffix of each path; all files or none.

    Parameters
    ----------
    rows : sequence of Facts
        The facts of each run, a row of the table: times in seconds, distances in px, empty where nothing is known.
    results : sequence of Result
        What each has found.
    paths : sequence of path-like
        Where to write; see `files_of`.
    warn, refuse : callable
        Called with a sentence for each file that leaves contours out; with each that would hold none, and why.

    Returns
    -------
    tuple of Path
        The files that have been written.

    Raises
    ------
    ValueError
        When a file cannot be written.
    """
    contents = []
    for path in map(Path, paths):
        suffix = suffix_of(path)
        if suffix == TABLE:
            known = [{k: cell(one) if isinstance(one, str) else one for k, one in asdict(row).items()} for row in rows]
            contents.append((path, contour_csv.table(known, [field.name for field in fields(Facts)])))
            continue
        for file, result in zip(files_of(path, [row.method for row in rows]), results, strict=True):
            if missing := omission(result, suffix):
                warn(f"{file}: {missing}")
            try:
                contents.append((file, encoded(result, suffix)))
            except ValueError as error:
                refuse(file, str(error))
    write_together(contents)
    return tuple(file for file, _ in contents)


def files_of(path: Path, methods: Sequence[str]) -> list[Path]:
    """The files that are written for a path: itself for the table or one method, else one with each name."""
    if len(methods) < 2 or suffix_of(path) == TABLE:
        return [path]
    suffix = path.name[len(path.name) - len(suffix_of(path)) :]
    stem = path.name.removesuffix(suffix)
    return [path.with_name(f"{stem}.{method}{suffix}") for method in methods]


def check_comparison(path: AnyPath, methods: Sequence[str]) -> None:
    """Check in advance whether `write_comparison` could write to a path; ValueError if not."""
    file = Path(path)
    check_export(file)
    if suffix_of(file) not in WRITABLE:
        raise ValueError(
            f"{file.name} would be a file of a surface or of center lines, but a comparison is one of contours: choose "
            f"one of {', '.join(WRITABLE)}."
        )
    for each in files_of(file, methods):
        check_place(each)
