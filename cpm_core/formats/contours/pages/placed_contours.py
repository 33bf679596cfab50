"""GeoJSON and sets of selections of ImageJ: contours on all pages of a stack, each with its page."""

from __future__ import annotations

import io
import zipfile
from dataclasses import replace
from typing import Any

from cpm_core.contours.result import Result
from cpm_core.formats.common.provenance import ENTRY, facts_of
from cpm_core.formats.contours import geojson, imagej
from cpm_core.formats.contours.json_text import text
from cpm_core.pages.page import StackResult

_NO_CHANNEL = -1
"""What QuPath writes where an annotation belongs to all channels."""


def encode_geojson(found: StackResult) -> bytes:
    """Write a collection of features, one for each contour of each page, as `geojson.encode` does for an image.

    Each has ``page`` (from 1) and ``track`` among its properties, and its geometry the ``plane`` by which QuPath
    places it: ``z`` or ``t`` counted from 0.
    """
    features: list[dict[str, Any]] = []
    for page, result in found.results:
        tracks = [contour.number for contour in result.contours if not contour.hole]
        for track, feature in zip(tracks, geojson.features_of(_named(result)), strict=True):
            plane = {"c": _NO_CHANNEL, "z": 0, "t": 0} | {found.axis: page - 1}
            feature["geometry"]["plane"] = plane
            feature["properties"] |= {"page": page, "track": track}
            features.append(feature)
    made = {ENTRY: facts_of(found.results[0][1])} if found.results else {}
    return text({"type": "FeatureCollection", **made, "features": features})


def encode_set(found: StackResult) -> bytes:
    """Write each contour of each page as a selection, which the ROI manager of ImageJ shows on its page.

    The name of a selection is its page and its track. ValueError when there is no contour, because ImageJ reports an
    empty archive as damaged.
    """
    if not any(result.contours for _, result in found.results):
        raise ValueError(f"{found.source} has no contours, and ImageJ opens no empty set: let it run on.")
    stream, digits = io.BytesIO(), len(str(found.count))
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for page, result in found.results:
            place = {"position": page} if found.alone else {f"{found.axis}_position": page}
            properties = f"cpm_page: {page}\n{imagej.properties_of(result)}"
            for contour in _named(result).contours:
                track = f"cpm_track: {contour.number}\n"
                content = imagej.selection(contour, contour.number, track + properties, **place)
                imagej.add(archive, f"page {page:0{digits}d} track {contour.number}", content)
    return stream.getvalue()


def _named(result: Result) -> Result:
    """The result with the tracks as names of the contours that have none."""
    contours = tuple(replace(one, name=one.name or f"track {one.number}") for one in result.contours)
    return replace(result, contours=contours)
