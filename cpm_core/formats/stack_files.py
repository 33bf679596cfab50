"""Files of all pages of a stack: each format by the suffix of its file."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from cpm_core.contours.measurements import contour_labels
from cpm_core.contours.rasterize import Labels, label_type, paint
from cpm_core.contours.result import Result
from cpm_core.formats.common.atomic import check_target, drafts_of, suffix_among, write_together
from cpm_core.formats.common.content import AnyPath
from cpm_core.formats.common.plain import encoded_json
from cpm_core.formats.common.provenance import ENTRY, PROGRAM, facts_of
from cpm_core.formats.contours import contour_csv, contour_json, geojson, imagej
from cpm_core.formats.masks.labels import entries_for_imagej
from cpm_core.numerics.types import Entries, Extent
from cpm_core.pages.page import StackResult

_LARGEST_IMAGEJ = 2**32 - 2**25
"""Size that a TIFF with the entries of ImageJ may have; a larger one needs addresses of 64 bits [bytes]."""

_NO_CHANNEL = -1
"""What QuPath writes where an annotation belongs to all channels."""


def encode_geojson(found: StackResult) -> bytes:
    """Write a collection of features, one for each contour of each page, as `geojson.encode` does for an image.

    Each has ``page`` (from 1) and ``track`` among its properties, and its geometry the ``plane`` by which QuPath
    places it: ``z`` or ``t`` counted from 0.
    """
    features: list[Entries] = []
    for page, result in found.results:
        tracks = [contour.number for contour in result.contours if not contour.hole]
        for track, feature in zip(tracks, geojson.features_of(_named(result)), strict=True):
            feature["geometry"]["plane"] = {"c": _NO_CHANNEL, "z": 0, "t": 0} | {found.axis: page - 1}
            feature["properties"] |= {"page": page, "track": track}
            features.append(feature)
    made = {ENTRY: facts_of(found.results[0][1])} if found.results else {}
    return encoded_json({"type": "FeatureCollection", **made, "features": features})


def encode_set(found: StackResult) -> bytes:
    """Write each contour of each page as a selection, which the ROI manager of ImageJ shows on its page.

    The name of a selection is its page and its track. ValueError when there is no contour, because ImageJ reports an
    empty archive as damaged.
    """
    if not any(result.contours for _, result in found.results):
        raise ValueError(f"{found.source} has no contours, and ImageJ opens no empty set: continue the run.")

    def selections() -> Iterator[tuple[str, bytes]]:
        digits = len(str(found.count))
        for page, result in found.results:
            place = {"position": page} if found.alone else {f"{found.axis}_position": page}
            properties = f"cpm_page: {page}\n{imagej.properties_of(result)}"
            for contour in _named(result).contours:
                track = f"cpm_track: {contour.number}\n"
                content = imagej.selection(contour, contour.number, track + properties, **place)
                yield f"page {page:0{digits}d} track {contour.number}", content

    return imagej.set_of(selections())


def _named(result: Result) -> Result:
    """The result with the tracks as names of the contours that have none."""
    contours = tuple(replace(one, name=one.name or f"track {one.number}") for one in result.contours)
    return replace(result, contours=contours)


def write_labels(found: StackResult, target: Path) -> None:
    """Write the label masks of all pages as an uncompressed TIFF, painted one at a time.

    The labels are tracks; pages that were not used, and those without closed contours, are 0. It has the entries of
    ImageJ where that can read it, else plain ones. ValueError when there is nothing to paint.
    """
    results = dict(found.results)
    closed = [one.number for result in results.values() for one in result.contours if one.closed]
    if not closed:
        raise ValueError(
            f"No contour of {found.source} is closed, so a label stack would be empty: continue the run, or "
            "export to CSV."
        )
    first = next(iter(results.values()))
    kind = np.dtype(label_type(max(closed)))
    shape = tuple(int(side) for side in np.max([result.shape for result in results.values()], axis=0))
    size = found.count * int(np.prod(shape)) * kind.itemsize
    entries: Entries = {"metadata": {"axes": f"{found.axis.upper()}YX"}}
    if kind == np.uint16 and size < _LARGEST_IMAGEJ:
        entries = {"imagej": True, "metadata": entries_for_imagej(first, f"{found.axis.upper()}YX")}
    if first.unit:
        entries["resolution"] = (1.0 / first.spacing[1], 1.0 / first.spacing[0])

    def painted() -> Iterator[Labels]:
        nothing = np.zeros(shape, kind)
        for page in range(1, found.count + 1):
            yield tracks_on(results[page], shape).astype(kind) if page in results else nothing

    import tifffile  # only here, because it takes long to import

    tifffile.imwrite(
        target,
        painted(),
        shape=(found.count, *shape),
        dtype=kind,
        bigtiff=size >= _LARGEST_IMAGEJ,
        photometric="minisblack",
        software=PROGRAM,
        **entries,
    )


def tracks_on(result: Result, shape: Extent) -> Labels:
    """Paint the insides of closed contours with their tracks."""
    numbers = {label: one.number for label, one in zip(contour_labels(result.contours), result.contours, strict=True)}
    return np.array([0, *(numbers[label] for label in range(1, max(numbers) + 1))])[paint(result.contours, shape)]


_ENCODERS: dict[str, tuple[str, Callable[[StackResult], bytes]]] = {
    ".measures.csv": ("a table of the measures of all contours on all pages", contour_csv.encode_measures_of_pages),
    ".csv": ("a table of the vertices of all contours on all pages", contour_csv.encode_pages),
    ".json": ("everything, with tracks and what happens to them", contour_json.encode_pages),
    ".geojson": ("contours as annotations for QuPath, each on its page", encode_geojson),
    ".zip": ("contours as a set of selections of ImageJ and Fiji, each on its page", encode_set),
}
_STACKS = dict.fromkeys((".tif", ".tiff"), "a label stack, one page each, tracks as labels")

FOR_STACKS: dict[str, str] = {**_STACKS, **{suffix: text for suffix, (text, _) in _ENCODERS.items()}}
"""Suffixes of files of all pages of a stack -> what is written."""


def stack_suffix_of(path: AnyPath) -> str:
    """Suffix of such a file, the longest that fits; empty for others."""
    return suffix_among(path, FOR_STACKS)


def export_stack(
    found: StackResult,
    *paths: AnyPath,
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
        check_target(file, FOR_STACKS, "for all pages of a stack")
    for file in files:
        try:
            if (suffix := stack_suffix_of(file)) in _ENCODERS:
                write_together([(file, _ENCODERS[suffix][1](found))])
            else:
                with drafts_of(file) as (draft,):
                    write_labels(found, draft)
        except ValueError as error:
            if refused is None:
                raise
            refused(file, str(error))
