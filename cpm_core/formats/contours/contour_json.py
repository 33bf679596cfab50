"""JSON: everything in a result, of an image or of all pages of a stack, for scripts and for resumed runs."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from cpm_core.contours.contour import Bridge, Contour
from cpm_core.contours.measurements import measure
from cpm_core.formats.common.json_values import encode_json, from_json, to_json
from cpm_core.formats.common.provenance import PROVENANCE_KEY, Outcome, describe_image_provenance, describe_provenance
from cpm_core.formats.contours.contents import CollectedContours, clean_properties, round_coordinates
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.numerics.types import Array, JsonDict, JsonObject
from cpm_core.pages.page import Page, StackResult
from cpm_core.pages.tracks import TrackEvent
from cpm_core.parameters.provenance import Provenance
from cpm_core.results.result import Result

_IMAGE_FORMAT = "cpm-contours"
"""Value of the entry ``format`` for the result of an image."""

_STACK_FORMAT = "cpm-pages"
"""Value of the entry ``format`` for all pages of a stack."""

_READ_PROVENANCE = "method", "parameters", "seeds", "scale", "steered", "model"
"""Fields of a provenance that are read as they are."""


def encode_contour_json(result: Outcome) -> bytes:
    """Write an object with the image, the run, the contours and the bridges; `load_contours` reads it back.

    ``points`` are pairs [row, col] in px, pixel centers at integers; lengths are in px, areas in px², strengths in gray
    levels / px. ``gross_area`` is the area enclosed by a contour, ``net_area`` excludes the closed contours in it, as
    in the label mask. ``inside`` is the number of the innermost closed contour around it, 0 for none; ``contrast`` is
    null without an image to measure it in; ``reached`` is how particles
    got to a contour, if known. If the pixel size is known, length and areas are given in its unit as well. Boundaries
    of an object have its number as ``object``, its class as ``class``, and the length without a detected edge as
    ``bridged``. The image has the ``channel`` in which contours were found, unless it is the luminance.
    ``provenance`` is described by `describe_provenance`. Branches of a skeleton are contours with ``radii`` [px], and
    there is no run.
    """
    return encode_json({"format": _IMAGE_FORMAT, "version": 1, **_result_to_json(result)})


def encode_pages_json(found: StackResult) -> bytes:
    """Write an object with a stack, its tracks and its pages; `page_from_json` reads a page back.

    ``stack`` has its ``name``, the number of its ``pages``, the ``axis`` z, t or c, and the ``drawn`` shapes. Each of
    ``tracks`` has its number, its ``pages``, the track that it split off as ``origin``, 0 for none, and how it
    ``begins`` and ``ends``, null if it is on the first or the last page. Each of ``pages`` has its number, ``trouble``
    if it could not be used, ``events``, and the entries that `encode_contour_json` writes for an image; the number of a
    contour is its track.
    """
    stack: JsonDict = {"name": found.source, "pages": found.count, "axis": found.axis, "alone": found.alone}
    stack |= {"drawn": describe_image_provenance(found.source, Provenance(), found.drawn).get("shapes", [])}
    tracks = [
        {
            "track": one.number,
            "pages": list(one.pages),
            "origin": one.origin,
            "begins": one.begin,
            "ends": one.end and one.end.kind,
        }
        for one in found.tracks
    ]
    pages = list(map(page_to_json, found.pages))
    return encode_json({"format": _STACK_FORMAT, "version": 1, "stack": stack, "tracks": tracks, "pages": pages})


def page_to_json(page: Page) -> JsonDict:
    """Convert a page to an entry of ``pages``; see `encode_pages_json`."""
    plain: JsonDict = {"page": page.number, "trouble": page.error, "events": to_json(page.events)}
    if page.result is not None:
        plain |= _result_to_json(page.result)
        for entry in plain["contours"]:
            entry["label"] = entry["number"] if entry["label"] else 0
    return plain


def _result_to_json(result: Outcome) -> JsonDict:
    """Convert a result to JSON; see `encode_contour_json`."""
    image: JsonDict = {"name": result.source, "shape": list(result.shape)}
    image |= {"spacing": list(result.spacing), "unit": result.unit}
    if result.channel != "luminance":
        image["channel"] = result.channel
    content: JsonDict = {
        "image": image,
        PROVENANCE_KEY: describe_provenance(result),
        "contours": _contours_to_json(result),
    }
    if isinstance(result, Result):
        run = {name: getattr(result, name) for name in ("steps", "converged", "stop_reason")}
        content["run"] = run | {"particles": len(result.particles)}
        content["bridges"] = [
            {
                "length": round(bridge.length, 4),
                "strength": round(bridge.strength, 6),
                "points": round_coordinates(bridge.points),
            }
            for bridge in result.bridges
        ]
        content["links"] = list(map(round_coordinates, result.links))
    return content


def _contours_to_json(result: Outcome) -> list[JsonDict]:
    """Convert the contours of a result to JSON; see `encode_contour_json`."""
    entries: list[JsonDict] = []
    rows = measure(result.contours, result.spacing)
    for index, (contour, row) in enumerate(zip(result.contours, rows, strict=True)):
        entry: JsonDict = {
            name: getattr(row, name) for name in ("number", "label", "name", "color", "closed", "inside")
        }
        entry |= {"junctions": list(contour.junctions), "length": round(row.length, 4)}
        entry |= {"gross_area": round(row.area, 4), "net_area": round(row.net_area, 4)}
        entry["strength"] = round(row.strength, 6)
        entry["contrast"] = None if row.contrast is None else round(row.contrast, 6)
        if contour.category:
            entry["class"] = contour.category
        if contour.gray is not None:
            entry["gray"] = contour.gray
        if result.unit:
            entry |= {"length_in_units": row.length_in_units, "gross_area_in_units": row.area_in_units}
            entry["net_area_in_units"] = row.net_area_in_units
        if contour.group:
            entry |= {"object": contour.group, "hole": contour.hole, "bridged": round(contour.bridged, 4)}
        if isinstance(result, Skeleton):
            entry["radii"] = round_coordinates(result.radii[index])
        entries.append(entry | {"points": round_coordinates(contour.points)})
    return entries


def is_cpm_json(content: Any) -> bool:
    """Return whether JSON is of this format."""
    return isinstance(content, dict) and content.get("format") in (_IMAGE_FORMAT, _STACK_FORMAT)


def read_contour_json(content: JsonDict) -> CollectedContours:
    """Read contours with their numbers, objects and strengths, and for a stack their pages."""
    found = CollectedContours()
    for page in content["pages"] if content["format"] == _STACK_FORMAT else [content]:
        for contour in map(_contour_from_json, page.get("contours", ())):
            found.shape = _parse_shape(page)
            if len(contour.points) > 1:
                found.contours.append(contour)
                found.pages.append(int(page.get("page", 0)))
            else:
                found.add_point(contour.points[0], int(page.get("page", 0)))
    return found


def page_from_json(plain: JsonObject) -> Page:
    """Build the page of an entry; a damaged one raises an exception of any kind."""
    events = tuple(from_json(TrackEvent, event, "event of a page") for event in plain["events"])
    result = _result_from_json(plain) if "contours" in plain else None
    return Page(int(plain["page"]), result, events, str(plain["trouble"]))


def _result_from_json(plain: JsonObject) -> Result:
    """Build the result of a page from JSON."""
    image, run = plain["image"], plain["run"]
    rows, cols = _parse_shape(plain)
    height, width = map(float, image["spacing"])
    contours = []
    for entry in plain["contours"]:
        contour, contrast = _contour_from_json(entry), entry["contrast"]
        contours.append(
            contour if contrast is None else replace(contour, measure_contrast=partial(float, float(contrast)))
        )
    facts = plain[PROVENANCE_KEY]
    return Result(
        np.zeros((int(run["particles"]), 2)),  # the file holds only their number
        tuple(contours),
        None,
        int(run["steps"]),
        bool(run["converged"]),
        str(run["stop_reason"]),
        (rows, cols),
        (height, width),
        image["unit"],
        str(image["name"]),
        tuple(Bridge(_parse_points(one), float(one["length"]), float(one["strength"])) for one in plain["bridges"]),
        tuple(_parse_points({"points": one}) for one in plain.get("links", ())),
        channel=image.get("channel", "luminance"),
        provenance=Provenance(
            **{name: facts[name] for name in _READ_PROVENANCE if name in facts},
            shapes=tuple(facts.get("shapes", ())),
            sha256=facts["image"].get("sha256", facts["image"].get("array_sha256", "")),
            of_file="array_sha256" not in facts["image"],
        ),
    )


def _parse_shape(plain: JsonObject) -> tuple[int, int]:
    """Parse the shape of the image."""
    rows, cols = plain["image"]["shape"]
    return int(rows), int(cols)


def _contour_from_json(plain: JsonObject) -> Contour:
    """Build a contour from JSON."""
    first, last = plain["junctions"]
    known = {name: plain.get(name) for name in ("strength", "name", "color", "number", "bridged", "gray")}
    properties = clean_properties(
        known
        | {"category": plain.get("class"), "group": int(plain.get("object", 0)), "hole": bool(plain.get("hole", False))}
    )
    return Contour(_parse_points(plain), bool(plain["closed"]), junctions=(bool(first), bool(last)), **properties)


def _parse_points(plain: JsonObject) -> Array:
    """Parse the vertices of a contour, shape (K, 2)."""
    return np.array(plain["points"], float).reshape(len(plain["points"]), 2)
