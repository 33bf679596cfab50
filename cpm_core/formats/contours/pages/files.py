"""Files of all pages of a stack: each format by the suffix of its file."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

from cpm_core.formats.common.atomic import check_place, draft_of, write_together
from cpm_core.formats.contours.pages import label_stack, placed_contours, stack_json, tables
from cpm_core.pages.page import StackResult

_ENCODERS: Mapping[str, tuple[str, Callable[[StackResult], bytes]]] = MappingProxyType(
    {
        ".measures.csv": ("a table of the measures of all contours on all pages", tables.encode_measures),
        ".csv": ("a table of the vertices of all contours on all pages", tables.encode),
        ".json": ("everything, with tracks and what happens to them; --resume goes on from it", stack_json.encode),
        ".geojson": ("contours as annotations for QuPath, each on its page", placed_contours.encode_geojson),
        ".zip": ("contours as a set of selections of ImageJ and Fiji, each on its page", placed_contours.encode_set),
    }
)
_STACKS = dict.fromkeys((".tif", ".tiff"), "a label stack, one page each, tracks as labels")

FOR_STACKS: dict[str, str] = {**_STACKS, **{suffix: text for suffix, (text, _) in _ENCODERS.items()}}
"""Suffixes of files of all pages of a stack -> what is written."""


def stack_suffix_of(path: str | os.PathLike[str]) -> str:
    """Suffix of such a file, the longest that fits; empty for others."""
    name = Path(path).name.lower()
    suffix = max((suffix for suffix in FOR_STACKS if name.endswith(suffix)), key=len, default="")
    return suffix if len(suffix) < len(name) else ""


def check_stack_export(path: str | os.PathLike[str]) -> None:
    """Raise ValueError unless `export_stack` could write to a path."""
    file = Path(path)
    if not stack_suffix_of(file):
        known = ", ".join(FOR_STACKS)
        raise ValueError(f"{file.name} names no format for all pages of a stack: choose one of {known}.")
    check_place(file)


def export_stack(
    found: StackResult,
    *paths: str | os.PathLike[str],
    refused: Callable[[Path, str], object] | None = None,
) -> None:
    """Write what was found in a stack, in the format that each suffix names; see `FOR_STACKS`.

    Parameters
    ----------
    found : StackResult
        The pages that are done.
    *paths : path-like
        Files to write. Existing ones are replaced, each as a whole.
    refused : callable, optional
        Called with each file that cannot be written, and why in a sentence; by default that is an error.

    Raises
    ------
    ValueError
        When a suffix is not known, a file cannot be written, or there is nothing that it could show.
    """
    files = list(map(Path, paths))
    for file in files:
        check_stack_export(file)
    whole = []
    for file in [one for one in files if stack_suffix_of(one) not in _STACKS]:
        try:
            whole.append((file, _ENCODERS[stack_suffix_of(file)][1](found)))
        except ValueError as error:
            _refuse(file, error, refused)
    write_together(whole)
    for file in [one for one in files if stack_suffix_of(one) in _STACKS]:
        try:
            with draft_of(file) as draft:
                label_stack.write(found, draft)
        except ValueError as error:
            _refuse(file, error, refused)


def _refuse(file: Path, error: ValueError, refused: Callable[[Path, str], object] | None) -> None:
    if refused is None:
        raise error
    refused(file, str(error))
