"""Comparisons of methods as files: a table, and the contours of each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, fields
from pathlib import Path

from cpm_core.formats.common.atomic import check_writable, write_together
from cpm_core.formats.common.content import AnyPath
from cpm_core.formats.common.printable import escape_cell
from cpm_core.formats.contours import contour_csv
from cpm_core.formats.writers import CONTOURS_WRITABLE, check_export, describe_omissions, find_format_suffix, to_bytes
from cpm_core.methods import RunReport
from cpm_core.results.result import Result

TABLE_SUFFIX = ".csv"
"""Suffix of the table of all methods; other suffixes give one file of contours per method."""


def write_comparison(
    rows: Sequence[RunReport],
    results: Sequence[Result],
    paths: Sequence[AnyPath],
    warn: Callable[[str], object],
    refuse: Callable[[Path, str], object],
) -> tuple[Path, ...]:
    """Write the table or the contours, by the suffix of each path; all files or none.

    Parameters
    ----------
    rows : sequence of RunReport
        Facts of each run, a row of the table: times in seconds, distances in px, empty if unknown.
    results : sequence of Result
        Result of each run.
    paths : sequence of path-like
        Targets; see `list_comparison_files`.
    warn, refuse : callable
        Called with a sentence for each file that omits contours; with each file that would hold none, and why.

    Returns
    -------
    tuple of Path
        The written files.

    Raises
    ------
    ValueError
        When a file cannot be written.
    """
    contents = []
    for path in map(Path, paths):
        suffix = find_format_suffix(path)
        if suffix == TABLE_SUFFIX:
            known = [
                {k: escape_cell(one) if isinstance(one, str) else one for k, one in asdict(row).items()} for row in rows
            ]
            contents.append((path, contour_csv.encode_csv_rows(known, [field.name for field in fields(RunReport)])))
            continue
        for file, result in zip(list_comparison_files(path, [row.method for row in rows]), results, strict=True):
            if missing := describe_omissions(result, suffix):
                warn(f"{file}: {missing}")
            try:
                contents.append((file, to_bytes(result, suffix)))
            except ValueError as error:
                refuse(file, str(error))
    write_together(contents)
    return tuple(file for file, _ in contents)


def list_comparison_files(path: Path, methods: Sequence[str]) -> list[Path]:
    """List the files written for a path: itself for the table or a single method, else one per method."""
    if len(methods) < 2 or find_format_suffix(path) == TABLE_SUFFIX:
        return [path]
    suffix = path.name[len(path.name) - len(find_format_suffix(path)) :]
    stem = path.name.removesuffix(suffix)
    return [path.with_name(f"{stem}.{method}{suffix}") for method in methods]


def check_comparison(path: AnyPath, methods: Sequence[str]) -> None:
    """Check in advance whether `write_comparison` could write to a path; ValueError if not."""
    file = Path(path)
    check_export(file)
    if find_format_suffix(file) not in CONTOURS_WRITABLE:
        raise ValueError(
            f"{file.name} would be a file of a surface or of center lines, but a comparison is one of contours: choose "
            f"one of {', '.join(CONTOURS_WRITABLE)}."
        )
    for each in list_comparison_files(file, methods):
        check_writable(each)
