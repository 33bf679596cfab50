"""Files of all pages of a stack: each format by the suffix of its file."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from cpm_core.contours.measurements import assign_labels
from cpm_core.contours.rasterize import Labels, label_type, rasterize_labels
from cpm_core.formats.common.atomic import check_target, draft_files, find_suffix, write_together
from cpm_core.formats.common.content import AnyPath
from cpm_core.formats.common.json_values import encode_json
from cpm_core.formats.common.provenance import PROGRAM_NAME, PROVENANCE_KEY, describe_provenance
from cpm_core.formats.contours import contour_csv, contour_json, geojson, imagej
from cpm_core.formats.masks.labels import build_imagej_metadata
from cpm_core.numerics.grids import rank_values
from cpm_core.numerics.types import Extent, JsonDict
from cpm_core.pages.page import StackResult
from cpm_core.results.result import Result

_MAX_IMAGEJ_SIZE = 2**32 - 2**25
"""Largest TIFF with the entries of ImageJ; larger ones need 64-bit offsets [bytes]."""

_ALL_CHANNELS = -1
"""Channel of an annotation of QuPath that belongs to all channels."""


def encode_stack_geojson(found: StackResult) -> bytes:
    """Encode each contour of each page as a feature, as `geojson.encode_geojson` does for an image.

    Its properties include ``page`` (from 1) and ``track``, and its geometry has the ``plane`` of QuPath: ``z`` or ``t``
    from 0.
    """
    features: list[JsonDict] = []
    for page, result in found.results:
        tracks = [contour.number for contour in result.contours if not contour.hole]
        for track, feature in zip(tracks, geojson.build_features(_name_by_track(result)), strict=True):
            feature["geometry"]["plane"] = {"c": _ALL_CHANNELS, "z": 0, "t": 0} | {found.axis: page - 1}
            feature["properties"] |= {"page": page, "track": track}
            features.append(feature)
    made = {PROVENANCE_KEY: describe_provenance(found.results[0][1])} if found.results else {}
    return encode_json({"type": "FeatureCollection", **made, "features": features})


def encode_stack_rois(found: StackResult) -> bytes:
    """Encode each contour of each page as a selection, which the ROI manager of ImageJ shows on its page.

    Selections are named by page and track. ValueError when there is no contour, because ImageJ reports an
    empty archive as damaged.
    """
    if not any(result.contours for _, result in found.results):
        raise ValueError(f"{found.source} has no contours, and ImageJ opens no empty set: continue the run.")

    def iterate_rois() -> Iterator[tuple[str, bytes]]:
        digits = len(str(found.count))
        for page, result in found.results:
            place = {"position": page} if found.alone else {f"{found.axis}_position": page}
            properties = f"cpm_page: {page}\n{imagej.format_roi_properties(result)}"
            for contour in _name_by_track(result).contours:
                track = f"cpm_track: {contour.number}\n"
                content = imagej.encode_contour_roi(contour, contour.number, track + properties, **place)
                yield f"page {page:0{digits}d} track {contour.number}", content

    return imagej.encode_roi_archive(iterate_rois())


def _name_by_track(result: Result) -> Result:
    """Name the contours without a name by their tracks."""
    contours = tuple(replace(one, name=one.name or f"track {one.number}") for one in result.contours)
    return replace(result, contours=contours)


def write_label_stack(found: StackResult, target: Path) -> None:
    """Write the label masks of all pages as an uncompressed TIFF, painted one at a time.

    Labels are tracks; unused pages and those without closed contours are 0. The file has the entries of ImageJ if that
    can read it, else plain ones. ValueError when there is nothing to paint.
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
    entries: JsonDict = {"metadata": {"axes": f"{found.axis.upper()}YX"}}
    if kind == np.uint16 and size < _MAX_IMAGEJ_SIZE:
        entries = {"imagej": True, "metadata": build_imagej_metadata(first, f"{found.axis.upper()}YX")}
    if first.unit:
        entries["resolution"] = (1.0 / first.spacing[1], 1.0 / first.spacing[0])

    def paint_pages() -> Iterator[Labels]:
        nothing = np.zeros(shape, kind)
        for page in range(1, found.count + 1):
            yield paint_tracks(results[page], shape).astype(kind) if page in results else nothing

    import tifffile  # only here, because it takes long to import

    tifffile.imwrite(
        target,
        paint_pages(),
        shape=(found.count, *shape),
        dtype=kind,
        bigtiff=size >= _MAX_IMAGEJ_SIZE,
        photometric="minisblack",
        software=PROGRAM_NAME,
        **entries,
    )


def paint_tracks(result: Result, shape: Extent) -> Labels:
    """Paint the insides of closed contours with their tracks, ints of shape `shape`."""
    numbers = {label: one.number for label, one in zip(assign_labels(result.contours), result.contours, strict=True)}
    labels, ranks = rank_values(rasterize_labels(result.contours, shape))
    return np.array([numbers[label] if label else 0 for label in labels.tolist()])[ranks]


_STACK_ENCODERS: dict[str, tuple[str, Callable[[StackResult], bytes]]] = {
    ".measures.csv": ("a table of the measures of all contours on all pages", contour_csv.encode_page_measures),
    ".csv": ("a table of the vertices of all contours on all pages", contour_csv.encode_page_vertices),
    ".json": ("everything, with tracks and what happens to them", contour_json.encode_pages_json),
    ".geojson": ("contours as annotations for QuPath, each on its page", encode_stack_geojson),
    ".zip": ("contours as a set of selections of ImageJ and Fiji, each on its page", encode_stack_rois),
}
"""Suffix -> what is written, and the function that encodes it."""

_LABEL_STACKS = dict.fromkeys((".tif", ".tiff"), "a label stack, one page each, tracks as labels")
"""Suffixes of label stacks, which are written page by page -> what is written."""

STACKS_WRITABLE: dict[str, str] = {**_LABEL_STACKS, **{suffix: text for suffix, (text, _) in _STACK_ENCODERS.items()}}
"""Suffixes of files of all pages of a stack -> what is written."""


def export_stack(
    found: StackResult,
    *paths: AnyPath,
    refused: Callable[[Path, str], object] | None = None,
) -> None:
    """Write what was found in a stack, in the format that each suffix names; see `STACKS_WRITABLE`.

    Parameters
    ----------
    found : StackResult
        The pages that are done.
    *paths : path-like
        Files to write. Existing ones are replaced, each as a whole.
    refused : callable, optional
        Called with each file that cannot be written and the reason in a sentence; by default that is an error.

    Raises
    ------
    ValueError
        When a suffix is not known, a file cannot be written, or there is nothing that it could show.
    """
    files = list(map(Path, paths))
    for file in files:
        check_target(file, STACKS_WRITABLE, "for all pages of a stack")
    for file in files:
        try:
            if (suffix := find_suffix(file, STACKS_WRITABLE)) in _STACK_ENCODERS:
                write_together([(file, _STACK_ENCODERS[suffix][1](found))])
            else:
                with draft_files(file) as (draft,):
                    write_label_stack(found, draft)
        except ValueError as error:
            if refused is None:
                raise
            refused(file, str(error))
